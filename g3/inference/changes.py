"""What an action changes of the state that the command was given in."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from g3.groundings import FloatArray, PhysicalObject, Place
from g3.inference.actions import Action
from g3.inference.candidates import beneath, is_surface
from g3.inference.clauses import UNUSUAL
from g3.inference.places import carrier, on_ground, stands_at
from g3.inference.roles import is_goal, is_source
from g3.inference.state import State
from g3.inference.surroundings import Candidate
from g3.inference.tree import Tree
from g3.sdc import SDC

UNMOVED = float(np.log(0.001))
"""What it costs to put something where it stood."""


def change_scores(start: State, actions: Sequence[Action]) -> FloatArray:
    """What it costs actions (n,) to put a load where it stood when the command was given.

    Nobody asks to move a pallet from a truck onto the same truck. What was on the forks stood
    nowhere.
    """
    stood: dict[str, tuple[PhysicalObject, PhysicalObject | None]] = {}
    total = np.zeros(len(actions))
    for i, action in enumerate(actions):
        if action.place is None or not action.object_id or action.object_id == start.held:
            continue
        if action.object_id not in stood:
            thing = start.thing(action.object_id)
            stood[action.object_id] = thing, beneath(Place(thing.prism), start, thing.id)
        if stands_at([action.place], *stood[action.object_id])[0]:
            total[i] = UNMOVED
    return total


def source_scores(
    path: SDC, state: State, actions: Sequence[Action], marks: Sequence[Candidate | None]
) -> FloatArray:
    """What it costs actions to take something that isn't on what it is to be taken from.

    Parameters
    ----------
    path
        "Off the truck", or another PATH, which costs nothing.
    actions, marks
        n actions, and m candidates of the PATH's landmark.

    Returns
    -------
    ndarray
        Shape (n, m).
    """
    total = np.zeros((len(actions), len(marks)))
    if not is_source(path):
        return total
    surfaces = [_surface(mark) for mark in marks]
    for i, action in enumerate(actions):
        if action.object_id and action.object_id != state.held:
            under = carrier(state, action.object_id)
            own = under.id if under else ""
            total[i] = [UNUSUAL if s and s != own else 0.0 for s in surfaces]
    return total


def beside_scores(
    tree: Tree,
    state: State,
    actions: Sequence[Action],
    goal_path: int,
    goals: Sequence[Candidate | None],
) -> FloatArray:
    """What it costs actions (n,) to put a load on something, or not, when a PATH says otherwise.

    "To the floor" is not on the truck, and "to the truck" is on it. Of PLACEs the first pass knows.

    Parameters
    ----------
    goals
        Candidates of the PATH's landmark.
    """
    total = np.zeros(len(actions))
    if goal_path < 0:
        return total
    path = tree.nodes[goal_path]
    low, onto = on_ground(path, path), is_goal(path)
    surfaces = [_surface(goal) for goal in goals]
    for i, action in enumerate(actions):
        if action.place is not None and action.goal >= 0:
            high = beneath(action.place, state, action.object_id) is not None
            wrong = high if low else onto and bool(surfaces[action.goal]) and not high
            total[i] = UNUSUAL if wrong else 0.0
    return total


def _surface(candidate: Candidate | None) -> str:
    """Id of the one thing of a candidate if a load can be put on it; else empty."""
    if candidate is None or len(candidate.group) > 1:
        return ""
    thing = candidate.group[0]
    return thing.id if isinstance(thing, PhysicalObject) and is_surface(thing) else ""
