"""Order of a state's things for the judge: supports, rows, sides and distances."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence

import numpy as np

from g3.actions.grounding_candidates import beneath
from g3.actions.robot_state import State
from g3.geometry.footprints import centre
from g3.geometry.relations import AHEAD, in_frame, looking_at
from g3.groundings import FloatArray, Place, Prism

Things = frozenset[str]
"""Ids of things."""

REGION_M, ROBOT_REGION_M = 0.5, 2.0
"""Largest distances of a load and of the robot from a region that they are in, in metres."""
SHORT_M = 4.0
"""Additional tolerance for a load that is still on the forks, in metres."""
LEFT_ALONE_M = 0.5
"""Largest distance from its start at which something hasn't been moved, in metres."""
TURN = np.pi / 6
"""Smallest angle of a turn to a side, in radians."""
DRIVEN_M = 1.0
"""Smallest distance to a side that replaces a turn, in metres."""


def support(state: State, bottom: Prism, thing: str) -> str | None:
    """Return the id of the object on which a thing with some shape stands; None for the ground."""
    under = beneath(Place(bottom), state, thing)
    return under.id if under else None


def supports(state: State, ids: Iterable[str]) -> dict[str, str | None]:
    """Return the id of the object on which each of some things stands."""
    return {i: support(state, state.thing(i).prism, i) for i in ids}


def from_left(state: State, ids: Iterable[str]) -> list[str]:
    """Sort things from left to right, as the robot sees them at the start."""
    order = sorted(ids)
    if not order:
        return order
    points = middles(state, order)
    leftward = in_frame(points, looking_at(state.pose, points))[:, 1]
    return [order[i] for i in np.argsort(-leftward, kind="stable")]


def in_rows(state: State, ids: Things) -> list[Things]:
    """Group things by the object that they stand on; all if each stands on another one."""
    rows: dict[str | None, set[str]] = {}
    for thing, under in supports(state, ids).items():
        rows.setdefault(under, set()).add(thing)
    return [frozenset(row) for row in rows.values() if len(row) > 1] or [ids]


def straight_ahead(state: State, ids: Things, way: int = 1) -> Things:
    """Return the nearest and the straightest thing ahead or behind, or the held one."""
    order = sorted(ids)
    if not order:
        return ids
    place = way * in_frame(middles(state, order), state.pose)
    off = np.abs(np.arctan2(place[:, 1], place[:, 0]))
    away = np.where(off <= AHEAD, np.linalg.norm(place, axis=1), np.inf)
    best = {order[k] for k in (int(np.argmin(off)), int(np.argmin(away))) if off[k] <= AHEAD}
    return frozenset(best) | (ids & {state.held or ""})


def by_distance(state: State, ids: Things, *, far: bool) -> Things:
    """Return the thing nearest to the robot, or the farthest."""
    order = sorted(ids)
    if not order:
        return ids
    away = np.linalg.norm(middles(state, order) - state.pose[:2], axis=1)
    return frozenset({order[int(np.argmax(away) if far else np.argmin(away))]})


def middles(state: State, ids: Sequence[str]) -> FloatArray:
    """Return the middles of things, shape (n, 2)."""
    return np.array([centre(prism) for prism in prisms(state, ids)])


def prisms(state: State, ids: Collection[str]) -> list[Prism]:
    """Return the shapes of things, in the order of their ids."""
    return [state.thing(i).prism for i in sorted(ids)]
