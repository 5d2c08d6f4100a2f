"""The judge's geometry: near, beside, between, on, and sides, with all of its numbers."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from itertools import combinations

import numpy as np

from g3.actions.robot_state import State
from g3.geometry.footprints import centre, covers
from g3.geometry.plane import area, convex_hull, gap, rotate
from g3.groundings import FloatArray, Place, Prism

Things = frozenset[str]
"""Ids of things."""

BESIDE_M = 4.0
"""Largest distance from a thing's border that is beside it, in metres."""
NEAR_M = 6.0
"""Largest distance from a thing's border that is near it or on one of its sides, in metres."""
BETWEEN_M = 3.0
"""Largest distance from the line between two middles that is between them, in metres."""
SIDE_M = 0.7
"""Smallest displacement to a side, in metres."""
AHEAD = np.pi / 3
"""Largest angle off the direction of view that is ahead, in radians."""
ON_M = 0.35
"""Largest gap between a carrier's top and the bottom of what stands on it, in metres."""
CARRIER_M2, CARRIER_M = 4.0, 1.5
"""Smallest footprint (square metres) and largest height (metres) of what carries loads."""
DECK_M = 0.4
"""A height between the ground and the decks of vehicles, in metres."""
REGION_M, ROBOT_REGION_M = 0.5, 2.0
"""Largest distances of a load and of the robot from a region that they are in, in metres."""
SHORT_M = 4.0
"""Additional tolerance for a load that is still on the forks, in metres."""
LEFT_ALONE_M = 0.5
"""Largest distance from its start at which something hasn't been moved, in metres."""
PASSED_M = 8.0
"""Largest distance from a thing's border that the robot passes, in metres."""
TURN = np.pi / 6
"""Smallest angle of a turn to a side, in radians."""
DRIVEN_M = 1.0
"""Smallest distance to a side that replaces a turn, in metres."""

_WAYS = {"front": (1.0, 0.0), "back": (-1.0, 0.0), "left": (0.0, 1.0), "right": (0.0, -1.0)}
"""Directions in the frame of a pose: ahead, and to the left."""


def support(state: State, bottom: Prism, thing: str) -> str | None:
    """Return the id of the object on which a thing with some shape stands; None for the ground."""
    for other in state.context.objects:
        if other.id in (thing, state.context.agent_id):
            continue
        if abs(other.prism.z_max - bottom.z_min) < ON_M and covers(other.prism, centre(bottom)):
            return other.id
    return None


def supports(state: State, ids: Iterable[str]) -> dict[str, str | None]:
    """Return the id of the object on which each of some things stands."""
    return {i: support(state, state.thing(i).prism, i) for i in ids}


def is_carrier(prism: Prism) -> bool:
    """Check that a shape is large and low enough to carry loads."""
    wide = float(area(convex_hull(prism.xy)[None])[0]) >= CARRIER_M2
    return wide and prism.z_max - prism.z_min < CARRIER_M


def nearest(one: Prism, others: Iterable[Prism]) -> float:
    """Return the distance in metres to the nearest footprint of several; infinite without one."""
    hull = convex_hull(one.xy)[None]
    return min((float(gap(hull, convex_hull(o.xy)[None])[0]) for o in others), default=np.inf)


def is_between(one: Prism, others: Sequence[Prism]) -> bool:
    """Check that an object lies between any two of several."""
    for a, b in combinations((centre(o) for o in others), 2):
        length = float(np.linalg.norm(b - a))
        along, aside = seen(looking_at(a, b[None]), centre(one)[None])[0]
        if 0 < along < length and abs(aside) <= BETWEEN_M:
            return True
    return False


def in_region(one: Prism, places: Iterable[Place], margin_m: float) -> bool | None:
    """Check that an object's middle is in one of several regions; None without a region."""
    inside = [covers(place.prism, centre(one), margin_m) for place in places]
    return any(inside) if inside else None


def same_level(one: Prism, other: Prism) -> bool:
    """Check that two shapes are both on the ground, or both on a deck."""
    return (one.z_min > DECK_M) == (other.z_min > DECK_M)


def seen(pose: FloatArray, points: FloatArray) -> FloatArray:
    """Return points (n, 2) in the frame of a pose x, y, yaw: distances ahead and to the left."""
    return rotate(points - pose[:2], np.full(len(points), -pose[2]))


def looking_at(pose: FloatArray, points: FloatArray) -> FloatArray:
    """Return the pose turned towards the middle of points, shape (n, 2)."""
    way = points.mean(axis=0) - pose[:2]
    return np.array([*pose[:2], np.arctan2(way[1], way[0])])


def goes(side: str, way: FloatArray, least_m: float = SIDE_M) -> bool:
    """Check that a displacement ahead and to the left, shape (2,), leads to a side."""
    return float(way @ np.array(_WAYS[side])) >= least_m


def on_side(one: Prism, side: str, marks: Sequence[Prism], pose: FloatArray) -> bool:
    """Check that a shape is on a side of landmarks, for an onlooker as he stands or faces them."""
    if nearest(one, marks) > NEAR_M:
        return False
    points, end = np.array([centre(m) for m in marks]), centre(one)[None]
    # In front of a thing is between it and the onlooker.
    sign = -1.0 if side in ("front", "back") else 1.0
    views = (pose, looking_at(pose, points))
    ways = np.concatenate([seen(view, end) - seen(view, points) for view in views])
    return any(goes(side, sign * way) for way in ways)


def from_left(state: State, ids: Iterable[str]) -> list[str]:
    """Sort things from left to right, as the robot sees them at the start."""
    order = sorted(ids)
    if not order:
        return order
    points = middles(state, order)
    leftward = seen(looking_at(state.pose, points), points)[:, 1]
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
    place = way * seen(state.pose, middles(state, order))
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
