"""What an EVENT's words say by their class: what something is taken from, and which sort of act.

With a few hundred commands most verbs and prepositions occur too rarely to learn this of each.
"""

from __future__ import annotations

from collections.abc import Sequence

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
UNUSUAL = float(np.log(0.05))
"""What it costs that an action isn't of the sort that the verb's class names."""


def is_source(path: SDC) -> bool:
    """Whether a PATH tells where something is taken from: "off the truck"."""
    named = concepts(field_words(path.relation))
    return "from" in named and "to" not in named


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


def verb_scores(
    event: SDC, kinds: Sequence[str], *, leads: bool = False, held: str | None = None
) -> FloatArray:
    """What it costs actions of some kinds (n,) that a verb doesn't name such; shape (n,).

    Who goes, turns or waits handles nothing; who places something does, and doesn't just pick it
    up; who takes something doesn't put it down. Who carries something somewhere puts it down there,
    or drives there with what is on the forks. Verbs that may mean either cost nothing.

    Parameters
    ----------
    leads
        Whether the clause names what is carried and where to.
    held
        What is on the forks.
    """
    verb = set(verb_class(event).split("+")) & VERBS
    handles = np.isin(kinds, HANDLING)
    unusual = np.zeros(len(kinds), dtype=bool)
    if verb and verb <= {"going", "turning", "staying"}:
        unusual = handles
    elif verb == {"placing"}:
        unusual = ~np.isin(kinds, PUTTING)
    elif verb == {"carrying"} and leads:
        drives = np.char.startswith(np.array(kinds, dtype=str), "drive") & (held is not None)
        unusual = ~(np.isin(kinds, PUTTING) | drives)
    elif verb == {"taking"}:
        unusual = np.isin(kinds, ["put down"])
    return np.where(unusual, UNUSUAL, 0.0)
