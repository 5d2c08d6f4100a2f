"""Questions back: which thing is meant, where the plans that are about as good disagree."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import softmax

from g3.actions.grounding_candidates import beneath
from g3.actions.robot_state import State
from g3.geometry.footprints import centre
from g3.geometry.plane import rotate
from g3.groundings import FloatArray, PhysicalObject, Place
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.phrases import is_pronoun
from g3.inference.search.action_search import Choices, Hypothesis
from g3.sdc.clauses import all_words
from g3.short_repr import short_repr

UNSURE_NATS = 0.5
"""Smallest entropy over a clause's candidate objects that leads to a question."""
LIKELY = 0.1
"""Objects with a smaller share are not offered."""


@short_repr
@dataclass(frozen=True, slots=True)
class Question:
    """A choice between several objects that a clause may mean.

    Parameters
    ----------
    node
        The clause.
    text
        The question.
    options
        Ids of the objects and how the question calls them.
    """

    node: int
    text: str
    options: tuple[tuple[str, str], ...]


def question_about(tree: Tree, plan: Hypothesis, start: State) -> Question | None:
    """Return the question about the least sure clause of a plan; None if it is sure enough."""
    best: tuple[float, int, dict[str, float]] | None = None
    for node, choices in sorted(plan.choices.items()):
        if tree.nodes[node].type != "OBJECT" or is_pronoun(tree.nodes[node]):
            continue
        shares = thing_shares(choices)
        p = np.array(list(shares.values()))
        entropy = float(-(p * np.log(np.maximum(p, 1e-12))).sum())
        if entropy > UNSURE_NATS and (best is None or entropy > best[0]):
            best = (entropy, node, shares)
    return None if best is None else _asked(tree, best[1], best[2], start)


def thing_shares(choices: Choices) -> dict[str, float]:
    """Divide the probability of a clause among the single things that it may mean.

    Empty if it rather means several.
    """
    single = {g[0].id: s for g, s in choices if len(g) == 1 and isinstance(g[0], PhysicalObject)}
    if len(choices[0][0]) != 1 or not single:
        return {}
    return dict(zip(single, softmax(list(single.values())).tolist(), strict=True))


def _asked(tree: Tree, node: int, shares: dict[str, float], start: State) -> Question | None:
    likely = sorted((i for i, p in shares.items() if p >= LIKELY), key=lambda i: -shares[i])
    if len(likely) < 2:
        return None
    words = " ".join(word.text for word in all_words(tree.nodes[node]))
    options = tuple(zip(likely, told_apart(start, likely), strict=True))
    *first, last = (text for _, text in options)
    listed = f"{', '.join(first)} or {last}"
    return Question(node, f'Which one is "{words}": {listed}?', options)


def told_apart(state: State, object_ids: Sequence[str]) -> list[str]:
    """Describe objects in words by their largest difference: position, or else order.

    Things on different sides, or on different things, are named by that alone; others by which is
    further left or nearer.
    """
    where = [_where(state, i) for i in object_ids]
    texts = [f"the one {place}" for place in where]
    for place in dict.fromkeys(where):
        same = [n for n, other in enumerate(where) if other == place]
        if len(same) > 1:
            orders = _orders(np.array([_from_robot(state, object_ids[n]) for n in same]))
            for n, order in zip(same, orders, strict=True):
                texts[n] = f"the {order} one {place}"
    return texts


def _orders(points: FloatArray) -> list[str]:
    """Order points (n, 2) in the robot's frame: left or right, near or far."""
    away = np.linalg.norm(points, axis=1)
    angle = np.arctan2(points[:, 1], points[:, 0])
    middle = np.arctan2(np.sin(angle).sum(), np.cos(angle).sum())
    # Left and right are those of who faces the things.
    leftward = points[:, 1] * np.cos(middle) - points[:, 0] * np.sin(middle)
    across = np.ptp(leftward) >= np.ptp(away)
    order = np.argsort(-leftward if across else away, kind="stable")
    first, last = ("left", "right") if across else ("near", "far")
    counted = ["first", "second", "third", "fourth", "fifth", "sixth"]
    if len(points) < 4:
        names = [first, "middle", last] if len(points) == 3 else [first, last]
    else:
        side = "from the left" if across else "from you"
        names = [f"{counted[min(n, 5)]} {side}" for n in range(len(points))]
    found = [""] * len(points)
    for name, n in zip(names, order, strict=True):
        found[n] = name
    return found


def _where(state: State, object_id: str) -> str:
    """Locate an object: on another, or on which side of the robot."""
    if object_id == state.held:
        return "on your forks"
    under = beneath(Place(state.thing(object_id).prism), state, object_id)
    if under is not None:
        return f"on the {' '.join(under.labels)}"
    x, y = _from_robot(state, object_id)
    sides = ["ahead of you", "to your left", "behind you", "to your right"]
    return sides[int(np.round(np.arctan2(y, x) / (np.pi / 2))) % 4]


def _from_robot(state: State, object_id: str) -> FloatArray:
    """Return an object's middle in the robot's frame, shape (2,)."""
    middle = centre(state.thing(object_id).prism)
    return rotate(middle - state.pose[:2], -state.pose[2])
