"""How things lie to each other and to who looks at them, as a judge measures it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import combinations

import numpy as np

from g3.geometry.footprints import centre
from g3.geometry.plane import convex_hull, gap, rotate
from g3.groundings import FloatArray, Prism

BESIDE_M = 4.0
"""What is next to a thing is no further from its border."""
NEAR_M = 6.0
"""What is near a thing, or before or behind it, is no further from its border."""
ASIDE_M = 3.0
"""What is between two things is no further from the line between their middles."""


def nearest(one: Prism, others: Iterable[Prism]) -> float:
    """Metres from a footprint to the nearest of several; infinite if there is none."""
    own = convex_hull(one.xy)[None]
    return min((float(gap(own, convex_hull(o.xy)[None])[0]) for o in others), default=np.inf)


def seen(pose: FloatArray, points: FloatArray) -> FloatArray:
    """Points (n, 2) as seen from a pose x, y, yaw: how far ahead, and how far to the left."""
    return rotate(points - pose[:2], np.full(len(points), -pose[2]))


def looking_at(pose: FloatArray, points: FloatArray) -> FloatArray:
    """The pose turned so that it looks at the middle of points (n, 2)."""
    way = points.mean(axis=0) - pose[:2]
    return np.array([*pose[:2], np.arctan2(way[1], way[0])])


def is_between(one: Prism, others: Sequence[Prism]) -> bool:
    """Whether something lies between any two of several."""
    point = centre(one)
    return any(_between(point, centre(a), centre(b)) for a, b in combinations(others, 2))


def _between(point: FloatArray, a: FloatArray, b: FloatArray) -> bool:
    way = b - a
    length = float(np.linalg.norm(way))
    if length < 1e-6:
        return False
    along, aside = seen(np.array([*a, np.arctan2(way[1], way[0])]), point[None])[0]
    return bool(0 < along < length and abs(aside) <= ASIDE_M)
