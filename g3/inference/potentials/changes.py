"""What an action changes of the state that the command was given in."""

from __future__ import annotations

from collections import Counter
from math import log

import numpy as np

from g3.actions.grounding_candidates import beneath, carrier, is_surface
from g3.geometry.plane import BoolArray
from g3.groundings import FloatArray, PhysicalObject, Place
from g3.inference.potentials.cases import ActionCase, PathCase
from g3.inference.potentials.place_rules import on_ground, stands_at
from g3.inference.potentials.potential_registry import Measured, potential
from g3.inference.problem.clause_roles import is_goal, is_source
from g3.inference.problem.grounding_problem import Candidate
from g3.sdc.clauses import SDCType

_CLAUSES: tuple[SDCType, ...] = ("EVENT", "PATH")


@potential("moved", kind="action", types=_CLAUSES, roles=("theme",), weight=log(0.001))
def moved(case: ActionCase) -> BoolArray:
    """A load isn't put where it stood, nor onto what it stood on.

    What was on the forks stood nowhere.
    """
    start = case.problem.state
    stood: dict[str, tuple[PhysicalObject, PhysicalObject | None]] = {}
    same = np.zeros(case.shape, dtype=bool)
    for i, action in enumerate(case.actions):
        if action.place is None or not action.object_id or action.object_id == start.held:
            continue
        if action.object_id not in stood:
            thing = start.thing(action.object_id)
            stood[action.object_id] = thing, beneath(Place(thing.prism), start, thing.id)
        same[i] = stands_at([action.place], *stood[action.object_id])[0]
    return same


@potential(
    "taken-from", kind="path", types=("PATH",), roles=("figure", "landmark"), weight=log(0.05)
)
def taken_from(case: PathCase) -> FloatArray:
    """What is taken "off the truck" stands on it."""
    total = np.zeros(case.shape)
    if not is_source(case.sdc):
        return total
    surfaces = [_surface(mark) for mark in case.marks]
    for i, action in enumerate(case.actions):
        if action.object_id and action.object_id != case.state.held:
            under = carrier(case.state, action.object_id)
            own = under.id if under else ""
            total[i] = [bool(s) and s != own for s in surfaces]
    return total


def _is_put_on(case: ActionCase) -> BoolArray:
    """Which actions put a load on something, not on the ground."""
    return case.each(
        lambda a: a.place is not None and beneath(a.place, case.state, a.object_id) is not None
    )


def _is_put_at_goal(case: ActionCase) -> BoolArray:
    return case.each(lambda a: a.place is not None and a.goal >= 0)


@potential("onto", kind="action", types=_CLAUSES, roles=("goal",), weight=log(0.05))
def onto(case: ActionCase) -> Measured:
    """A load that goes "to the truck" is put on it."""
    if case.path is None or on_ground(case.path, case.path) or not is_goal(case.path):
        return False
    surfaces = [bool(_surface(goal)) for goal in case.found.goals]
    on_surface = case.each(lambda a: a.goal >= 0 and surfaces[a.goal])
    return on_surface & _is_put_at_goal(case) & ~_is_put_on(case)


def _surface(candidate: Candidate | None) -> str:
    """Id of the one thing of a candidate if a load can be put on it; else empty."""
    if candidate is None or len(candidate.group) > 1:
        return ""
    thing = candidate.group[0]
    return thing.id if isinstance(thing, PhysicalObject) and is_surface(thing) else ""


@potential("many-spots", kind="action", types=_CLAUSES, weight=-0.6)
def many_spots(case: ActionCase) -> Measured:
    """Of many spots for the same load at the same goal each is less probable: logarithm."""
    alike = [(a.kind, a.object_id, a.goal) if a.place is not None else None for a in case.actions]
    count = Counter(alike)
    measures: FloatArray = np.log([count[key] if key else 1 for key in alike])
    return measures
