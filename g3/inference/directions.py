"""Ways that words name without a landmark: "back up", "turn left", "go forward"."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from g3.groundings import FloatArray
from g3.inference.actions import Action
from g3.inference.clauses import UNUSUAL
from g3.inference.phrases import is_measure, verb_class
from g3.inference.tree import Tree
from g3.language.concepts import concepts
from g3.language.lexicon import AROUND, HANDLING_VERBS, WAYS, YOU
from g3.language.words import field_words
from g3.sdc import all_words

BARE = frozenset({"wait", "go straight", "back up", "turn"})
"""Actions that lead to nothing in particular."""


def direction_scores(tree: Tree, root: int, actions: Sequence[Action]) -> FloatArray:
    """What it costs actions (n,) to lead another way than a clause without a landmark names.

    Only actions that lead to nothing in particular cost something.
    """
    below = (tree.nodes[n] for n in tree.all_below(root))
    things = (sdc for sdc in below if sdc.type == "OBJECT" and not sdc.is_implicit)
    if not all(map(is_measure, things)):
        return np.zeros(len(actions))
    words = field_words(all_words(tree.nodes[root]))
    named = WAYS & {*concepts(words), *(("around",) if AROUND.intersection(words) else ())}
    wrong = [bool(named) and a.kind in BARE and way_of(a) not in named for a in actions]
    return np.where(wrong, UNUSUAL, 0.0)


def way_of(action: Action) -> str:
    """Which way an action goes by itself; empty where it stays, or goes by what it is about."""
    if action.kind == "turn":
        half = abs(action.amount) > 3 * np.pi / 4
        return "around" if half else "left" if action.amount > 0 else "right"
    return {"go straight": "front", "back up": "back"}.get(action.kind, "")


def told_side(tree: Tree, root: int) -> str:
    """The side that the robot has been told to go to when a clause begins, or is in it.

    "Swing left and proceed to the truck" speaks of a truck on the left. What something is picked
    up from or put down at tells nothing of the next thing.
    """
    found = ""
    for node in range(root + 1):
        verb = set(verb_class(tree.nodes[node]).split("+"))
        if node < root and verb & HANDLING_VERBS:
            found = ""
        if tree.nodes[node].type == "EVENT" and (node == root or verb & {"going", "turning"}):
            named = _own_words(tree, node) & {"left", "right"}
            found = named.pop() if len(named) == 1 else found
    return found


def _own_words(tree: Tree, root: int) -> set[str]:
    """Concepts of an EVENT and of what in it has no landmark but who is spoken to."""
    told: set[str] = set(concepts(field_words(tree.nodes[root].relation)))
    for node in tree.below(root, ("l", "l2"), "PATH", "PLACE"):
        marks = [w.text.lower() for mark in tree.nodes[node].landmark1 for w in all_words(mark)]
        if not marks or YOU.intersection(marks):
            told |= concepts(field_words(all_words(tree.nodes[node])))
    return told
