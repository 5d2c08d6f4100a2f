"""What an action changes of the state that the command was given in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from g3.groundings import FloatArray, PhysicalObject, Place
from g3.inference.actions import Action
from g3.inference.candidates import beneath, is_surface
from g3.inference.clauses import UNUSUAL, is_source
from g3.inference.places import carrier, on_ground, stands_at
from g3.inference.state import State
from g3.inference.surroundings import Candidate
from g3.inference.tree import Tree

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
    tree: Tree,
    state: State,
    actions: Sequence[Action],
    paths: Mapping[int, Sequence[Candidate | None]],
) -> FloatArray:
    """What it costs actions (n,) to take something that isn't on what it is to be taken from.

    Parameters
    ----------
    paths
        PATHs with the candidates of their landmarks: "off the truck" among them.
    """
    total = np.zeros(len(actions))
    for path, marks in paths.items():
        things = [g for c in marks if c for g in c.group if isinstance(g, PhysicalObject)]
        sources = {thing.id for thing in things if is_surface(thing)}
        if not sources or not is_source(tree.nodes[path]):
            continue
        for i, action in enumerate(actions):
            if action.object_id and action.object_id != state.held:
                under = carrier(state, action.object_id)
                if under is None or under.id not in sources:
                    total[i] = UNUSUAL
    return total


def beside_scores(
    tree: Tree, root: int, state: State, actions: Sequence[Action], goal_path: int
) -> FloatArray:
    """What it costs actions (n,) to put a load on something when a PATH's words say otherwise.

    "To the floor" is not on the truck. Of PLACEs the first pass knows.
    """
    total = np.zeros(len(actions))
    if goal_path < 0 or not on_ground(tree.nodes[root], tree.nodes[goal_path]):
        return total
    for i, action in enumerate(actions):
        if action.place is not None and action.goal >= 0:
            high = beneath(action.place, state, action.object_id) is not None
            total[i] = UNUSUAL if high else 0.0
    return total
