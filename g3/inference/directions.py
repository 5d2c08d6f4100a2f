"""Ways that words name without a landmark: "back up", "turn left", "go forward"."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from g3.groundings import FloatArray
from g3.inference.actions import Action
from g3.inference.clauses import UNUSUAL
from g3.inference.tree import Tree
from g3.language.concepts import concepts
from g3.language.words import field_words, normalise
from g3.sdc import all_words

AROUND = frozenset(normalise(word) for word in ("around", "round", "circle", "u-turn"))
WAYS = frozenset({"front", "back", "left", "right", "around"})
BARE = frozenset({"wait", "go straight", "back up", "turn"})
"""Actions that lead to nothing in particular."""


def direction_scores(tree: Tree, root: int, actions: Sequence[Action]) -> FloatArray:
    """What it costs actions (n,) to lead another way than a clause without a landmark names.

    Only actions that lead to nothing in particular cost something.
    """
    below = (tree.nodes[n] for n in tree.all_below(root))
    if any(sdc.type == "OBJECT" and not sdc.is_implicit for sdc in below):
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
