"""Repetitions for another load: "put the drum on the truck, then the crate"."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from g3.inference.problem.phrases import arguments_of, names_robot, subject_of, verb_words
from g3.inference.problem.world_nouns import Nouns
from g3.language.discourse.groups import noun_leaf
from g3.language.lexicon.concepts import concepts
from g3.language.lexicon.field_words import bare, bare_words, field_words
from g3.language.lexicon.tables import WORDS
from g3.language.lexicon.verb_chains import verb_of
from g3.language.lexicon.verb_classes import HANDLING_VERBS
from g3.sdc.clauses import SDC, all_words
from g3.sdc.sdc_notation import IMPLICIT_FIGURE

BACK = 2
"""What is said again is said by one of so many clauses before."""


def repeated(sdcs: Sequence[SDC], nouns: Nouns) -> tuple[SDC, ...]:
    """The top-level clauses, plain ones, where what names only a load says the same of it.

    The same is what the clause before says: its verb, and where to.
    """
    found: list[SDC] = []
    for sdc in sdcs:
        load = _load(sdc, nouns)
        said = [_same(before, load) for before in found[-BACK:]] if load else []
        found.append(next(filter(None, reversed(said)), sdc))
    return tuple(found)


def _load(sdc: SDC, nouns: Nouns) -> SDC | None:
    """The load that a clause names, if it says nothing else but that the same is wanted."""
    if WORDS["again"].isdisjoint(_said(sdc)):
        return None
    parts: list[SDC] = []
    if (
        sdc.type == "EVENT"
        and WORDS["same_again"].issuperset(verb_words(sdc))
        and not subject_of(sdc)
    ):
        parts = [inner for part in arguments_of(sdc) for inner in _inside(part)]
    elif sdc.type in ("PLACE", "PATH"):
        parts = [part for part in _inside(sdc) if part is not sdc]
    elif sdc.type == "OBJECT":
        again = sdc.figure and not sdc.landmark1 and WORDS["same_again"].issuperset(verb_words(sdc))
        parts = list(sdc.figure) if again else [sdc]
    loads = [p for p in parts if p.type == "OBJECT" and _may_be_load(p, nouns)]
    others = [p for p in parts if p not in loads]
    if len(loads) != 1 or any(WORDS["again"].isdisjoint(_said(p)) for p in others):
        return None
    return _without_again(loads[0])


def _said(sdc: SDC) -> list[str]:
    return bare_words(all_words(sdc))


def _inside(part: SDC) -> tuple[SDC, ...]:
    """Return the clauses that an argument names: "the drum" of "the same with the drum"."""
    said = {word for figure in part.figure for word in _said(figure)}
    same = WORDS["same_again"].issuperset(said - WORDS["articles"])
    if part.landmark1 and same and WORDS["same_again"].issuperset(verb_words(part)):
        return part.landmark1
    return (part,)


def _may_be_load(sdc: SDC, nouns: Nouns) -> bool:
    """Check that an OBJECT names a load, or leaves its noun out: "the other one", "the left"."""
    noun = noun_leaf(sdc).words
    if not noun or nouns.name_load(noun):
        return bool(noun)
    return bare(noun[-1].text) in WORDS["nounless"] or bool(concepts(field_words(noun[-1:])))


def _without_again(load: SDC) -> SDC:
    """A load without words before it that a tree has taken for its own: "this also the drum"."""
    start = 0
    while start < len(load.words) - 1 and bare(load.words[start].text) in WORDS["same_again"]:
        start += 1
    return replace(load, words=load.words[start:]) if load.words else load


def _same(before: SDC, load: SDC) -> SDC | None:
    """Return a clause for another load; None if it puts nothing anywhere."""
    if before.type != "EVENT":
        return None
    goals = tuple(p for p in arguments_of(before) if p.type in ("PLACE", "PATH"))
    handles = verb_of(tuple(verb_words(before))).classes & HANDLING_VERBS or not before.relation
    subject = subject_of(before)
    moves = subject is not None and not names_robot(subject)
    if not goals or not (handles or moves):
        return None
    if moves:
        return replace(before, figure=(load,), landmark1=goals, landmark2=())
    return replace(before, figure=IMPLICIT_FIGURE, landmark1=(load,), landmark2=goals)
