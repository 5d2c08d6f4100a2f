"""Changes that actions make to the state in which the command was given."""

from __future__ import annotations

from collections import Counter
from math import log

import numpy as np

from g3.actions.grounding_candidates import beneath
from g3.geometry.plane import BoolArray
from g3.groundings import FloatArray, PhysicalObject, Place
from g3.inference.potentials.cases import ActionCase, PathCase
from g3.inference.potentials.place_rules import stands_at
from g3.inference.potentials.potential_registry import Measured, potential
from g3.inference.problem.clause_roles import is_source
from g3.inference.problem.grounding_problem import things_of
from g3.inference.problem.phrases import is_floor
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
    "taken-from", kind="path", types=("PATH",), roles=("figure", "landmark"), weight=log(0.001)
)
def taken_from(case: PathCase) -> Measured:
    """A load taken "off the truck" stands on it, where anything does; off the ground, there."""
    if not is_source(case.sdc):
        return False
    under = case.problem.carriers
    if any(map(is_floor, case.sdc.landmark1)):
        return np.repeat([[a.object_id in under] for a in case.actions], len(case.marks), axis=1)
    marks = [things_of(mark.group) if mark else [] for mark in case.marks]
    laden = [{thing.id for thing in own}.intersection(under.values()) for own in marks]
    taken = [a.object_id if a.object_id != case.state.held else "" for a in case.actions]
    return np.array(
        [[bool(load and own) and under.get(load) not in own for own in laden] for load in taken]
    )


@potential("many-spots", kind="action", types=_CLAUSES, weight=-0.6)
def many_spots(case: ActionCase) -> Measured:
    """Of many spots for the same load at the same goal each is less probable: logarithm."""
    alike = [(a.kind, a.object_id, a.goal) if a.place is not None else None for a in case.actions]
    count = Counter(alike)
    measures: FloatArray = np.log([count[key] if key else 1 for key in alike])
    return measures
