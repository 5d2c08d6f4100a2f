"""Distances between convex polygons, as machine code."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from g3.geometry.compiled import compiled
from g3.groundings import FloatArray

Polygons: TypeAlias = tuple[FloatArray, npt.NDArray[np.uint8], npt.NDArray[np.intp]]
"""Polygons (m, k, 2), how many corners each has before the last one is repeated, and which of them
each of n pairs has."""
_POLYGONS = "Tuple((f8[:, :, ::1], u1[::1], i8[::1]))"

LEAST_M2 = 1e-18
"""Edges whose square is no larger have no inner side."""


@compiled("UniTuple(f8, 2)(f8[:, ::1], u1, f8[:, ::1], u1)")
def from_edges(
    points: FloatArray, count: int, polygon: FloatArray, corners: int
) -> tuple[float, float]:
    """Measure points against the edges of a polygon.

    Below 0 where all points are on the outer side of some edge; and the square of the distance of
    the point and the edge that are nearest.
    """
    outmost, nearest = np.inf, np.inf
    x, y = polygon[corners - 1]
    for i in range(corners):
        from_x, from_y = x, y
        x, y = polygon[i]
        along, across = x - from_x, y - from_y
        square = along * along + across * across
        scale = 1 / square if square > 0 else 0.0
        inmost = np.inf if square <= LEAST_M2 else -np.inf
        for j in range(count):
            dx, dy = points[j, 0] - from_x, points[j, 1] - from_y
            inmost = max(inmost, along * dy - across * dx)
            part = min(max((dx * along + dy * across) * scale, 0.0), 1.0)
            dx -= part * along
            dy -= part * across
            nearest = min(nearest, dx * dx + dy * dy)
        outmost = min(outmost, inmost)
    return outmost, nearest


@compiled(f"void({_POLYGONS}, {_POLYGONS}, f8[::1])")
def separations(a: Polygons, b: Polygons, result: FloatArray) -> None:
    """Write the distances of n pairs of polygons into the result (n,), 0 of those that overlap.

    Polygons are apart where some edge of one has all of the other on its outer side (separating
    axis), and points and lines where their extents are.
    """
    for i in range(len(result)):
        p, n = a[0][a[2][i]], a[1][a[2][i]]
        q, m = b[0][b[2][i]], b[1][b[2][i]]
        of_b, nearest = from_edges(p, n, q, m)
        of_a, near = from_edges(q, m, p, n)
        apart = min(of_a, of_b) < 0
        for axis in range(2):
            p_low = p_high = p[0, axis]
            for j in range(1, n):
                p_low, p_high = min(p_low, p[j, axis]), max(p_high, p[j, axis])
            q_low = q_high = q[0, axis]
            for j in range(1, m):
                q_low, q_high = min(q_low, q[j, axis]), max(q_high, q[j, axis])
            apart |= q_low > p_high or p_low > q_high
        result[i] = np.sqrt(min(nearest, near)) if apart else 0.0
