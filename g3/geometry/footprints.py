"""Footprints of single things: their middles, and what they cover."""

from __future__ import annotations

from functools import lru_cache
from typing import TypeAlias

import numpy as np

from g3.geometry.plane import convex_hull, hull_centre, point_gap, rotate
from g3.groundings import FloatArray, Prism

_BORDER_M2 = 1e-9
_Point: TypeAlias = tuple[float, ...]


def centre(prism: Prism) -> FloatArray:
    """Return the middle of a footprint, shape (2,)."""
    return hull_centre(prism.xy)


def apart(one: Prism, other: Prism) -> float:
    """Return the distance between the middles of two footprints, in metres."""
    return float(np.linalg.norm(centre(one) - centre(other)))


def extent(prism: Prism, yaw: float) -> FloatArray:
    """Return the extent of a prism along a heading, across it, and upwards, shape (3,)."""
    turned = rotate(prism.xy, np.full(len(prism.xy), -yaw))
    return np.array([*np.ptp(turned, axis=0), prism.z_max - prism.z_min])


def covers(prism: Prism, point: FloatArray, margin_m: float = 0.0) -> bool:
    """Check that a point (2,) lies in a footprint or within a margin of it, in metres."""
    x, y = float(point[0]), float(point[1])
    (x_min, y_min), (x_max, y_max), edges = _outline(prism.xy.tobytes())
    if x < x_min - margin_m or x > x_max + margin_m or y < y_min - margin_m or y > y_max + margin_m:
        return False
    inwards = min(ex * (y - cy) - ey * (x - cx) for cx, cy, ex, ey in edges)
    if inwards >= 0 and x_min <= x <= x_max and y_min <= y <= y_max:
        return True
    if inwards < -_BORDER_M2 and margin_m == 0:
        return False
    return bool(point_gap(point[None, None], convex_hull(prism.xy)[None])[0, 0] <= margin_m)


# The same things are asked for many points, one by one.
@lru_cache(maxsize=1 << 14)
def _outline(corners: bytes) -> tuple[_Point, _Point, tuple[_Point, ...]]:
    """Least and largest x and y of corners (k, 2), and corners and edges of their hull."""
    xy = np.frombuffer(corners).reshape(-1, 2)
    hull = convex_hull(xy)
    edges = np.column_stack((hull, np.roll(hull, -1, axis=0) - hull))
    low, high = xy.min(axis=0).tolist(), xy.max(axis=0).tolist()
    return tuple(low), tuple(high), tuple(map(tuple, edges.tolist()))
