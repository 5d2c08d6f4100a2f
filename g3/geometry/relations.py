"""Spatial relations of a scene: near, beside, between, sides and levels, with their numbers.

Rules, candidates, the judge and the benchmarks share them. Features measure the same quantities
in bins, whose weights are learned.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import combinations

import numpy as np

from g3.geometry.footprints import centre, covers
from g3.geometry.plane import area, convex_hull, gap, rotate
from g3.groundings import FloatArray, Place, Prism

BESIDE_M = 4.0
"""Largest distance from a thing's border that is beside it, in metres."""
NEAR_M = 6.0
"""Largest distance from a thing's border that is near it or on one of its sides, in metres."""
PASSED_M = 8.0
"""Largest distance from a thing's border that the robot passes, in metres."""
BETWEEN_M = 3.0
"""Largest distance from the line between two middles that is between them, in metres."""
SIDE_M = 0.7
"""Smallest displacement to a side, in metres."""
AHEAD = np.pi / 3
"""Largest angle off the direction of view that is ahead, in radians."""
LEVEL_M = 0.35
"""Heights that differ by less are one level, as of a deck and what stands on it; logs are noisy."""
CARRIER_M2, CARRIER_M = 4.0, 1.5
"""Smallest footprint (square metres) and largest height (metres) of what carries loads."""
DECK_M = 0.4
"""A height between the ground and the decks of vehicles, in metres."""
OTHER_PLACE_M = 2.5
"""Places of the search nearer than this to each other may both be meant, in metres."""

_WAYS = {"front": (1.0, 0.0), "back": (-1.0, 0.0), "left": (0.0, 1.0), "right": (0.0, -1.0)}
"""Directions in the frame of a pose: ahead, and to the left."""


def in_frame(points: FloatArray, pose: FloatArray) -> FloatArray:
    """Return points (..., 2) in the frame of a pose x, y, yaw: metres ahead and to the left."""
    return rotate(points - pose[:2], np.full(points.shape[:-1], -pose[2]))


def looking_at(pose: FloatArray, points: FloatArray) -> FloatArray:
    """Return the pose turned towards the middle of points, shape (n, 2)."""
    way = points.mean(axis=0) - pose[:2]
    return np.array([*pose[:2], np.arctan2(way[1], way[0])])


def nearest(one: Prism, others: Iterable[Prism]) -> float:
    """Return the distance in metres to the nearest footprint of several; infinite without one."""
    hull = convex_hull(one.xy)[None]
    return min((float(gap(hull, convex_hull(o.xy)[None])[0]) for o in others), default=np.inf)


def is_between(one: Prism, others: Sequence[Prism]) -> bool:
    """Check that an object lies between any two of several."""
    for a, b in combinations((centre(o) for o in others), 2):
        length = float(np.linalg.norm(b - a))
        along, aside = in_frame(centre(one)[None], looking_at(a, b[None]))[0]
        if 0 < along < length and abs(aside) <= BETWEEN_M:
            return True
    return False


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
    ways = np.concatenate([in_frame(end, view) - in_frame(points, view) for view in views])
    return any(goes(side, sign * way) for way in ways)


def rests_on(bottom: Prism, support: Prism) -> bool:
    """Check that a shape stands on another one: its middle over it, and its bottom at its top."""
    return abs(support.z_max - bottom.z_min) < LEVEL_M and covers(support, centre(bottom))


def same_level(one: Prism, other: Prism) -> bool:
    """Check that two shapes are both on the ground, or both on a deck."""
    return (one.z_min > DECK_M) == (other.z_min > DECK_M)


def is_carrier(prism: Prism) -> bool:
    """Check that a shape is large and low enough to carry loads."""
    wide = float(area(convex_hull(prism.xy)[None])[0]) >= CARRIER_M2
    return wide and prism.z_max - prism.z_min < CARRIER_M


def in_region(one: Prism, places: Iterable[Place], margin_m: float) -> bool | None:
    """Check that an object's middle is in one of several regions; None without a region."""
    inside = [covers(place.prism, centre(one), margin_m) for place in places]
    return any(inside) if inside else None
