"""Plane geometry of footprints and trajectories, vectorised over a leading batch axis.

Footprints are convex polygons with their corners counter-clockwise, shape (n, k, 2);
polygons with fewer corners than k repeat their last one. Every function works on the
whole batch at once.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache, reduce
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from g3.groundings import FloatArray

_Floats = TypeVar("_Floats", FloatArray, npt.NDArray[np.float32])

_BLOCK = 4096
"""Pairs that are looked at together."""

BoolArray = npt.NDArray[np.bool_]
IntArray = npt.NDArray[np.intp]

SAMPLES = 25
"""Poses that every trajectory is resampled to, evenly along its length."""

METRES_PER_RADIAN = 1.0
"""Length that a turn on the spot counts for when poses are spread along a trajectory."""


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the z component of the cross product of plane vectors, over the last axis."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def length(vectors: FloatArray) -> FloatArray:
    """Return the lengths of plane vectors (..., 2)."""
    x, y = vectors[..., 0], vectors[..., 1]
    # np.linalg.norm does the same in several times the time.
    return np.sqrt(x * x + y * y)


def extent(polygons: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the least and the largest coordinates of polygons, each of shape (n, 2)."""
    return _least(polygons), reduce(np.maximum, _columns(polygons))


def _columns(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Move a short second axis first: reducing along it is faster."""
    swapped: npt.NDArray[Any] = values.swapaxes(0, 1)
    return swapped


def _least(values: FloatArray) -> FloatArray:
    """Minimum over a short second axis."""
    return reduce(np.minimum, _columns(values))


def _all(values: BoolArray) -> BoolArray:
    return reduce(np.logical_and, _columns(values))


def rotate(xy: FloatArray, angle: FloatArray) -> FloatArray:
    """Turn plane vectors (..., 2) counter-clockwise by angles in radians (...)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack((c * xy[..., 0] - s * xy[..., 1], s * xy[..., 0] + c * xy[..., 1]), axis=-1)


def wrap(angle: FloatArray) -> FloatArray:
    """Wrap angles in radians to [-pi, pi)."""
    return (angle + np.pi) % (2 * np.pi) - np.pi


def following(corners: _Floats) -> _Floats:
    """Return the next corner of each corner (n, k, ...); the first after the last."""
    # np.roll does the same in three times the time.
    return np.concatenate((corners[:, 1:], corners[:, :1]), axis=1)


def area(polygons: FloatArray) -> FloatArray:
    """Return areas in square metres, shape (n,)."""
    local = polygons - polygons[:, :1]
    total: FloatArray = 0.5 * cross(local, following(local)).sum(axis=1)
    return total


def centroid(polygons: FloatArray) -> FloatArray:
    """Return centres of area in metres, (n, 2); the middle of the extent where it vanishes."""
    low, high = extent(polygons)
    middle = (low + high) / 2
    local = polygons - middle[:, None]
    ahead = following(local)
    weight = cross(local, ahead)
    total = weight.sum(axis=1)
    moment = ((local + ahead) * weight[..., None]).sum(axis=1)
    flat = np.abs(total) <= 1e-12 * ((high - low) ** 2).sum(axis=1)
    offset: FloatArray = moment / (3 * np.where(flat, 1.0, total))[:, None]
    return middle + np.where(flat[:, None], 0.0, offset)


def contains_point(polygons: FloatArray, points: FloatArray) -> BoolArray:
    """Check that each polygon holds its point (n, 2), borders included."""
    low, high = extent(polygons)
    inside = _all((low - 1e-9 <= points) & (points <= high + 1e-9))
    near = np.flatnonzero(inside)
    corners = polygons[near]
    edges = following(corners) - corners
    inside[near] = _all(cross(edges, points[near, None] - corners) >= -1e-9)
    return inside


def intersection_area(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the areas in square metres that pairs of polygons share, shape (n,).

    Sutherland and Hodgman's clipping, with the shrinking polygon held in a fixed number of
    corners so that the batch stays one array (I. E. Sutherland and G. W. Hodgman, "Reentrant
    polygon clipping", Communications of the ACM 17(1), 1974).
    """
    shared = np.zeros(len(a))
    low, high = _shared_extent(a, b)
    near = np.flatnonzero(_all(low < high))
    if len(near) == 0:
        return shared
    corners, clip = a[near], b[near]
    edges = following(clip) - clip
    for i in range(clip.shape[1]):
        corners = _clip(corners, clip[:, i], edges[:, i])
    shared[near] = np.maximum(area(corners), 0.0)
    return shared


def _clip(corners: FloatArray, origin: FloatArray, edge: FloatArray) -> FloatArray:
    """Keep what lies to the left of a line; dropped corners move onto their neighbours."""
    n, k, _ = corners.shape
    side = cross(edge[:, None], corners - origin[:, None])
    ahead, next_side = following(corners), following(side)
    inside = side >= 0
    crossing = inside != (next_side >= 0)
    ratio = side / np.where(crossing, side - next_side, 1.0)
    meeting = corners + ratio[..., None] * (ahead - corners)
    candidates = np.stack((corners, meeting), axis=2).reshape(n, 2 * k, 2)
    kept = np.stack((inside, crossing), axis=2).reshape(n, 2 * k)
    # A cut adds a corner at most, and more by rounding where an edge lies along the line.
    count = kept.sum(axis=1)
    order = np.argsort(~kept, axis=1, kind="stable")[:, : max(1, count.max())]
    rows = np.arange(n)[:, None]
    last = np.maximum(count - 1, 0)[:, None]
    order = np.where(np.arange(order.shape[1]) < count[:, None], order, order[rows, last])
    clipped: FloatArray = candidates[rows, order]
    return np.where((count > 0)[:, None, None], clipped, 0.0)


def gap(a: FloatArray, b: FloatArray, rows: tuple[IntArray, IntArray] | None = None) -> FloatArray:
    """Return the distances in metres between pairs of polygons, 0 where they overlap.

    Parameters
    ----------
    rows
        Indices of the polygons of each pair; left out, those in the same place.
    """
    in_place = np.arange(len(a))
    one, other = rows or (in_place, in_place)
    blocks = range(0, max(len(one), 1), _BLOCK)  # one that is empty if there are no pairs
    pairs = [(a[one[i : i + _BLOCK]], b[other[i : i + _BLOCK]]) for i in blocks]
    return np.concatenate([_separations(p, q) for p, q in pairs])


def _separations(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the distances of n pairs of polygons, 0 of those that overlap.

    Polygons are apart where some edge of one has all of the other on its outer side (separating
    axis), and points and lines where their extents are.
    """
    (of_a, from_a), (of_b, from_b) = _from_edges(b, a), _from_edges(a, b)
    low, high = _shared_extent(a, b)
    apart = np.minimum(of_a.max(axis=0).min(axis=0), of_b.max(axis=0).min(axis=0)) < 0
    apart |= (low > high).any(axis=1)
    return np.where(apart, np.minimum(from_a.min(axis=0), from_b.min(axis=0)), 0.0)


def _shared_extent(a: FloatArray, b: FloatArray) -> tuple[FloatArray, FloatArray]:
    (a_low, a_high), (b_low, b_high) = extent(a), extent(b)
    return np.maximum(a_low, b_low), np.minimum(a_high, b_high)


def _from_edges(points: FloatArray, polygons: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Measure points (n, m, 2) against the edges of polygons (n, k, 2).

    Returns
    -------
    inwards : FloatArray
        Positive on the inner side of an edge, shape (m, k, n); edges without a length have
        everything far inwards of them.
    distance : FloatArray
        From the nearest edge in metres, shape (m, n).
    """
    px, py = np.ascontiguousarray(points.T)[:, :, None]
    cx, cy = np.ascontiguousarray(polygons.T)
    ex, ey = np.roll(cx, -1, axis=0) - cx, np.roll(cy, -1, axis=0) - cy
    square = ex * ex + ey * ey
    dx, dy = px - cx, py - cy
    inwards = ex * dy
    part = ey * dx
    inwards -= part
    inwards += np.where(square <= 1e-18, np.inf, 0.0)
    scale = 1 / np.where(square > 0, square, 1.0)
    along = dx * (ex * scale)
    along += np.multiply(dy, ey * scale, out=part)
    np.maximum(along, 0, out=along)
    np.minimum(along, 1, out=along)
    dx -= np.multiply(along, ex, out=part)
    dy -= np.multiply(along, ey, out=part)
    dx *= dx
    dx += np.multiply(dy, dy, out=part)
    distance: FloatArray = np.sqrt(dx.min(axis=1))
    return inwards, distance


def point_gap(points: FloatArray, polygons: FloatArray) -> FloatArray:
    """Return distances in metres from points (n, T, 2) to polygons (n, k, 2), shape (n, T).

    Zero inside the polygon.
    """
    inwards, distance = _from_edges(points, polygons)
    low, high = (bound[:, None] for bound in extent(polygons))
    within = (low <= points) & (points <= high)
    inside = (inwards.min(axis=1) >= 0).T & within[..., 0] & within[..., 1]
    return np.where(inside, 0.0, distance.T)


def convex_hull(points: FloatArray) -> FloatArray:
    """Return the convex hull of points (m, 2), corners counter-clockwise; it is read-only.

    Andrew's monotone chain; used to bring footprints into the form of this module.
    """
    return _hull(_bytes(points))


def hull_centre(points: FloatArray) -> FloatArray:
    """Return the centre of area of points' convex hull, shape (2,); it is read-only."""
    return _hull_centre(_bytes(points))


def _bytes(points: FloatArray) -> bytes:
    return np.asarray(points, dtype=np.float64).tobytes()


def _fixed(array: FloatArray) -> FloatArray:
    array.flags.writeable = False
    return array


# A scene's things are looked at again and again, one by one.
@lru_cache(maxsize=1 << 14)
def _hull_centre(points: bytes) -> FloatArray:
    return _fixed(centroid(_hull(points)[None])[0].copy())


@lru_cache(maxsize=1 << 14)
def _hull(points: bytes) -> FloatArray:
    table = np.frombuffer(points).reshape(-1, 2)
    order = sorted({(x, y) for x, y in table.tolist()})
    if len(order) < 3:
        return _fixed(np.array(order).reshape(-1, 2))

    def chain(rows: Iterable[tuple[float, float]]) -> list[tuple[float, float]]:
        hull: list[tuple[float, float]] = []
        for x, y in rows:
            while len(hull) > 1:
                (x0, y0), (x1, y1) = hull[-2:]
                if (x1 - x0) * (y - y1) - (y1 - y0) * (x - x1) > 0:
                    break
                hull.pop()
            hull.append((x, y))
        return hull[:-1]

    return _fixed(np.array(chain(order) + chain(reversed(order))))


def moved_corners(corners: FloatArray, start: FloatArray, pose: FloatArray) -> FloatArray:
    """Footprints (n, k, 2) carried rigidly from one pose to another.

    Parameters
    ----------
    corners
        Footprints at the start pose.
    start, pose
        Poses x, y, yaw, shape (n, 3).
    """
    turn = (pose[:, 2] - start[:, 2])[:, None]
    return rotate(corners - start[:, None, :2], turn) + pose[:, None, :2]


def padded(hulls: Sequence[FloatArray]) -> FloatArray:
    """Footprints as one array (n, k, 2); those with fewer corners repeat their last one."""
    size = max((len(hull) for hull in hulls), default=3)
    corners = np.empty((len(hulls), size, 2))
    for row, hull in zip(corners, hulls, strict=True):
        row[: len(hull)] = hull
        row[len(hull) :] = hull[-1]
    return corners
