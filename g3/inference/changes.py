"""What an action changes of the state that the command was given in."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from g3.actions import centre, covers
from g3.groundings import FloatArray, PhysicalObject, Place
from g3.inference.actions import Action
from g3.inference.candidates import GROUND_M, beneath
from g3.inference.clauses import UNUSUAL
from g3.inference.state import State
from g3.inference.things import Tree
from g3.language.concepts import concepts
from g3.language.words import field_words
from g3.sdc import all_words

UNMOVED = float(np.log(0.001))
"""What it costs to put something where it stood."""
FLOOR = frozenset({"ground", "floor", "pavement"})
BESIDE = frozenset({"near", "left", "right", "front", "back", "between"})
SAME_SPOT_M = 1.5
"""Nearer than this to where it stood a load has not been moved."""


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
        if _stands(action.place, *stood[action.object_id]):
            total[i] = UNMOVED
    return total


def _stands(place: Place, thing: PhysicalObject, under: PhysicalObject | None) -> bool:
    """Whether a place is on what a thing stands on, or for one on the ground where it is."""
    middle = centre(place.prism)
    if under is None:
        return bool(np.linalg.norm(middle - centre(thing.prism)) < SAME_SPOT_M)
    level = abs(under.prism.z_max - place.prism.z_min) < GROUND_M
    return level and covers(under.prism, middle)


def beside_scores(
    tree: Tree, root: int, state: State, actions: Sequence[Action], goal_path: int
) -> FloatArray:
    """What it costs actions (n,) to put a load on something when words say otherwise.

    "On the floor" is not on the truck, and neither is "closer to the truck". The goal is the
    clause's PLACE, or else its PATH ``goal_path``, -1 for none.
    """
    total = np.zeros(len(actions))
    goal = next(iter(tree.below(root, ("l", "l2"), "PLACE")), goal_path)
    if goal < 0:
        return total
    floor = FLOOR.intersection(field_words(all_words(tree.nodes[root])))
    named = concepts(field_words(tree.nodes[goal].relation))
    if not floor and ("on" in named or not named & BESIDE):
        return total
    for i, action in enumerate(actions):
        if action.place is not None and action.goal >= 0:
            on_ground = beneath(action.place, state, action.object_id) is None
            total[i] = 0.0 if on_ground else UNUSUAL
    return total
