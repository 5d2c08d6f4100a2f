"""What an EVENT's words say by their class: what something is taken from, and which sort of act.

With a few hundred commands most verbs and prepositions occur too rarely to learn this of each.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from g3.groundings import FloatArray
from g3.inference.tree import Tree
from g3.language.concepts import concepts
from g3.language.verb_classes import word_class
from g3.language.words import bare, field_words
from g3.sdc import SDC

VERBS = frozenset({"placing", "taking", "carrying", "going", "turning", "staying"})
PUTTING = ("carry", "put down")
HANDLING = ("pick up", *PUTTING)
WHERE = frozenset({"left", "right", "front", "back", "between", "near"})
UNUSUAL = float(np.log(0.05))
"""What it costs that an action isn't of the sort that the verb's class names."""


def is_source(path: SDC) -> bool:
    """Whether a PATH tells where something is taken from: "off the truck"."""
    named = concepts(field_words(path.relation))
    return "from" in named and "to" not in named


def tells_place(path: SDC) -> bool:
    """Whether a PATH tells where something is to be put as a PLACE does: "beside the crate"."""
    return bool(path.landmark1) and bool(WHERE & concepts(field_words(path.relation)))


def goal_paths(tree: Tree, root: int) -> list[int]:
    """PATHs of an EVENT that may tell where it leads, those with "to" first.

    "Past the crates to the truck" leads to the truck.
    """
    paths = tree.below(root, ("l", "l2"), "PATH")
    found = [p for p in paths if not is_source(tree.nodes[p])]
    return sorted(found, key=lambda p: "to" not in concepts(field_words(tree.nodes[p].relation)))


def verb_class(sdc: SDC) -> str:
    """The classes of an EVENT's verb, of its first word that has any; "other" if none has.

    >>> from g3.sdc import Span
    >>> verb_class(SDC("EVENT", relation=(Span(0, "pick"), Span(5, "up"))))
    'taking'
    """
    for span in sdc.relation:
        found = word_class(bare(span.text))
        if set(found.split("+")) & VERBS:
            return found
    return "other"


@dataclass(frozen=True, slots=True)
class Asked:
    """What a clause asks for besides what its verb says.

    Parameters
    ----------
    theme
        Whether it names what is handled.
    leads
        Whether it names what is moved and where to, and no later clause puts that down.
    at_place
        Whether where to is a PLACE, not a PATH.
    held
        What is on the forks.
    """

    theme: bool = False
    leads: bool = False
    at_place: bool = False
    held: str | None = None


def verb_scores(event: SDC, kinds: Sequence[str], asked: Asked = Asked()) -> FloatArray:
    """What it costs actions of some kinds (n,) that a verb doesn't name such; shape (n,).

    Who goes, turns or waits handles nothing; who places something does, and doesn't just pick it
    up; who takes something does that, and carries it only where the clause leads. Who carries
    something to a place puts it down there, and along a path may just drive there with what is on
    the forks. Verbs that may mean either cost nothing, but "leave it there" doesn't pick it up.
    """
    verb = set(verb_class(event).split("+")) & VERBS
    kind = np.array(kinds, dtype=str)
    unusual = np.zeros(len(kinds), dtype=bool)
    if verb and verb <= {"going", "turning", "staying"}:
        unusual = np.isin(kind, HANDLING)
    elif verb == {"placing"}:
        unusual = ~np.isin(kind, PUTTING)
    elif "placing" in verb and not verb & {"taking", "carrying"}:
        unusual = kind == "pick up"
    elif verb == {"carrying"} and asked.leads:
        drives = np.char.startswith(kind, "drive") & (asked.held is not None)
        unusual = ~(np.isin(kind, PUTTING) | (drives & (not asked.at_place)))
    elif verb == {"taking"}:
        taking = np.isin(kind, ("pick up", "carry") if asked.leads else ("pick up",))
        takes = asked.theme and asked.held is None
        unusual = ~taking if takes else np.isin(kind, HANDLING) & ~taking
    return np.where(unusual, UNUSUAL, 0.0)
