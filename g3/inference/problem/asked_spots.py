"""What words ask of candidates that few commands need: far spots, corners, so many things."""

from __future__ import annotations

from itertools import pairwise

from g3.actions.grounding_candidates import SpotsAsked
from g3.inference.problem.command_tree import Tree
from g3.language.discourse.groups import group
from g3.language.lexicon.concepts import concepts
from g3.language.lexicon.field_words import bare, field_words
from g3.language.lexicon.word_sets import CARDINALS, METRES, SIDES
from g3.sdc.clauses import SDC

FAR_M = 3.0
"""Nearer spots are there anyway: who says "a few feet" or "a metre" doesn't measure."""
PAIR = 2
"""Pairs are always candidates."""


def metres_said(words: list[str]) -> float | None:
    """How far words say, in metres; None if they don't.

    >>> metres_said("about five metres to the left of".split())
    5.0
    >>> metres_said(["to", "the", "left", "of"])
    """
    for number, unit in pairwise(words):
        if unit in METRES and (number in CARDINALS or number.isdecimal()):
            return METRES[unit] * float(CARDINALS.get(number, number))
    return None


def spots_asked(sdc: SDC) -> SpotsAsked:
    """What the words of a PLACE, or of what tells a place, ask of spots."""
    relation = field_words(sdc.relation)
    said = concepts(relation)
    apart = metres_said([bare(word.text) for word in sdc.relation])
    return SpotsAsked(
        apart=apart if apart is not None and apart > FAR_M else None,
        corner="corner" in relation,
        side="on" in said and bool(said & SIDES),
        top="top" in relation,
    )


def counts_said(tree: Tree) -> tuple[int, ...]:
    """How many things OBJECTs name, where that is more than two."""
    said = {group(sdc).count or 0 for sdc in tree.nodes if sdc.type == "OBJECT" and sdc.is_leaf}
    return tuple(sorted(count for count in said if count > PAIR))
