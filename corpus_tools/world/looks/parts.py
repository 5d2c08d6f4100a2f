"""Surfaces that looks are made of: plain arrays, joined to one mesh a thing.

Without a GPU, every geom and every vertex takes time. So a thing is drawn as one mesh whose colours
come from one picture (:mod:`corpus_tools.world.looks.atlas`). Lengths are in metres, in the frame
of the body that the parts go to.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from corpus_tools.world.looks.atlas import Finish
from g3.geometry.plane import rotate
from g3.groundings import FloatArray
from g3.short_repr import short_repr

Point: TypeAlias = Sequence[float] | FloatArray
Span: TypeAlias = tuple[float, float]


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """A surface of triangles."""

    at: FloatArray
    """Corners, shape (n, 3)."""
    normal: FloatArray
    """Unit normals there, shape (n, 3)."""
    uv: FloatArray
    """Places of their colours in the atlas, shape (n, 2)."""
    face: npt.NDArray[np.int32]
    """Triangles as indices of corners, counter-clockwise from outside, shape (m, 3)."""


def join(parts: Iterable[Part]) -> Part:
    """Join parts into one."""
    parts = list(parts)
    starts = np.cumsum([0, *(len(part.at) for part in parts)])
    faces = [part.face + start for part, start in zip(parts, starts, strict=False)]
    return Part(
        np.concatenate([part.at for part in parts]),
        np.concatenate([part.normal for part in parts]),
        np.concatenate([part.uv for part in parts]),
        np.concatenate(faces).astype(np.int32),
    )


def moved(part: Part, by: Point, yaw: float = 0.0) -> Part:
    """Return a part turned about the z axis, then moved."""

    def turned(xyz: FloatArray) -> FloatArray:
        xy = rotate(xyz[:, :2], np.full(len(xyz), yaw))
        return np.concatenate((xy, xyz[:, 2:]), axis=1)

    return replace(part, at=turned(part.at) + np.asarray(by), normal=turned(part.normal))


_SIDES = {
    "-x": ((0, 1, 0), (0, 0, 0), (0, 0, 1), (0, 1, 1)),
    "+x": ((1, 0, 0), (1, 1, 0), (1, 1, 1), (1, 0, 1)),
    "-y": ((0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1)),
    "+y": ((1, 1, 0), (0, 1, 0), (0, 1, 1), (1, 1, 1)),
    "-z": ((1, 0, 0), (0, 0, 0), (0, 1, 0), (1, 1, 0)),
    "+z": ((0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)),
}
"""Corners of a block's sides, counter-clockwise from outside, from the lower left."""


def block(
    corners: FloatArray,
    finish: Finish,
    *,
    tops: Finish | None = None,
    without: str = "",
    along: bool = False,
) -> Part:
    """Return a body with six flat sides.

    Parameters
    ----------
    corners
        Shape (2, 2, 2, 3): the corner at each end of x, of y and of z.
    tops
        Finish of the upper and lower side where it differs.
    without
        Sides that nobody sees, such as ``"-z +x"``.
    along
        True if the finish follows the longer edges, as grain does.
    """
    seen = [side for side in _SIDES if side not in without.split()]
    flat = [side for side in seen if tops and "z" in side]
    upright = [side for side in seen if side not in flat]
    bottom, top = corners[..., 2].min(), corners[..., 2].max()

    def sides(names: list[str], finish: Finish) -> Part:
        end = np.array([_SIDES[name] for name in names])
        at = corners[end[..., 0], end[..., 1], end[..., 2]]
        return quads(at, finish, up=(at[..., 2] - bottom) / max(top - bottom, 1e-9), along=along)

    parts = [sides(upright, finish)] if upright else []
    return join([*parts, sides(flat, tops)] if tops and flat else parts)


def box(
    low: Point,
    high: Point,
    finish: Finish,
    *,
    tops: Finish | None = None,
    without: str = "",
    along: bool = False,
) -> Part:
    """Return an upright box between opposite corners; see :func:`block`."""
    return tapered(low, high, low[:2], high[:2], finish, tops=tops, without=without, along=along)


def inside(low: FloatArray, high: FloatArray) -> Callable[..., Part]:
    """Return a function that makes boxes in parts of a room.

    Returns
    -------
    Callable
        Takes from and to along x, y and z as parts of the room between its corners, then what
        :func:`box` takes.
    """

    def part(x: Span, y: Span, z: Span, finish: Finish, **options: Any) -> Part:
        start, end = low + (high - low) * np.array((x, y, z)).T
        return box(start, end, finish, **options)

    return part


def tapered(
    low: Point,
    high: Point,
    top_low: Point,
    top_high: Point,
    finish: Finish,
    *,
    tops: Finish | None = None,
    without: str = "",
    along: bool = False,
) -> Part:
    """Return a box whose top lies between other corners in x and y; see :func:`block`."""
    corners = np.empty((2, 2, 2, 3))
    bottom = np.sort(np.array([low, high], dtype=float), axis=0)
    top = np.sort(np.array([top_low, top_high], dtype=float), axis=0)
    for x, y in np.ndindex(2, 2):
        corners[x, y, 0] = bottom[x][0], bottom[y][1], bottom[0][2]
        corners[x, y, 1] = top[x][0], top[y][1], bottom[1][2]
    return block(corners, finish, tops=tops, without=without, along=along)


def quad(corners: npt.ArrayLike, finish: Finish) -> Part:
    """Return a flat surface with four corners, shape (4, 3); see :func:`quads`."""
    return quads(np.asarray(corners, dtype=float)[None], finish)


def quads(
    corners: FloatArray, finish: Finish, *, up: npt.ArrayLike = 1.0, along: bool = False
) -> Part:
    """Build flat surfaces with four corners each.

    Parameters
    ----------
    corners
        Counter-clockwise from outside, beginning at the finish's lower left, shape (n, 4, 3).
    up
        Light that reaches each corner, from 0 to 1, shape (n, 4).
    """
    n = len(corners)
    st = np.tile(np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]), (n, 1, 1))
    if along:
        edges = np.linalg.norm(corners[:, 1:3] - corners[:, :2], axis=2)
        tall = edges[:, 1] > edges[:, 0]
        st[tall] = np.roll(st[tall], 1, axis=1)
    diagonals = corners[:, 2:] - corners[:, :2]
    normal = _unit(np.cross(diagonals[:, 0], diagonals[:, 1]))
    face = np.array([[0, 1, 2], [0, 2, 3]]) + 4 * np.arange(n)[:, None, None]
    return Part(
        corners.reshape(-1, 3),
        np.repeat(normal, 4, axis=0),
        finish.uv(st.reshape(-1, 2), np.broadcast_to(up, (n, 4)).ravel()),
        face.reshape(-1, 3).astype(np.int32),
    )


def turned(
    profile: npt.ArrayLike,
    finish: Finish,
    *,
    centre: Point = (0.0, 0.0, 0.0),
    axis: str = "z",
    segments: int = 16,
    smooth: bool = False,
    squash: float = 1.0,
) -> Part:
    """Return a surface of revolution, like something from a lathe.

    Parameters
    ----------
    profile
        Radius and height along the axis, from the bottom up along the outside, shape (k, 2).
        Begin and end with radius 0 for a closed end.
    centre
        Point of radius and height zero.
    axis
        ``"x"``, ``"y"`` or ``"z"``.
    smooth
        True if the edges of the profile are rounded off by the shading.
    squash
        Factor on the lengths along the second direction across the axis.
    """
    profile = np.asarray(profile, dtype=float)
    steps = np.diff(profile, axis=0)
    length = np.concatenate(([0.0], np.cumsum(np.hypot(*steps.T))))
    out = _unit(np.stack((steps[:, 1], -steps[:, 0]), axis=1))
    if smooth:
        rows = profile, _unit(np.pad(out, ((0, 1), (0, 0))) + np.pad(out, ((1, 0), (0, 0)))), length
        starts = range(len(steps))
    else:
        ends = np.stack((np.arange(len(steps)), np.arange(1, len(steps) + 1)), axis=1).ravel()
        rows = profile[ends], np.repeat(out, 2, axis=0), length[ends]
        starts = range(0, 2 * len(steps), 2)
    (points, normals, along), n = rows, segments + 1
    angle = 2 * np.pi * np.arange(n) / segments
    round_ = np.stack((np.cos(angle), squash * np.sin(angle)), axis=1)
    bulge = _unit(np.stack((squash * np.cos(angle), np.sin(angle)), axis=1))

    def sweep(ring: FloatArray, rows: FloatArray) -> FloatArray:
        xy = rows[:, None, :1] * ring
        z = np.broadcast_to(rows[:, None, 1:], (*xy.shape[:2], 1))
        return np.concatenate((xy, z), axis=2).reshape(-1, 3)

    st = np.stack(
        np.broadcast_arrays(np.arange(n) / segments, along[:, None] / max(length[-1], 1e-9)), axis=2
    ).reshape(-1, 2)
    order = {"x": [2, 0, 1], "y": [1, 2, 0], "z": [0, 1, 2]}[axis]
    at = sweep(round_, points)[:, order]
    up = (at[:, 2] - at[:, 2].min()) / max(float(np.ptp(at[:, 2])), 1e-9)
    a = np.array([row * n + i for row in starts for i in range(segments)])
    face = np.stack((a, a + 1, a + n + 1, a, a + n + 1, a + n), axis=1).reshape(-1, 3)
    first, second, third = np.moveaxis(at[face], 1, 0)
    has_area = np.linalg.norm(np.cross(second - first, third - first), axis=1) > 1e-9
    return Part(
        at + np.asarray(centre),
        sweep(bulge, normals)[:, order],
        finish.uv(st, up),
        face[has_area].astype(np.int32),
    )


def mirrored(profile: Sequence[Span]) -> list[Span]:
    """Return a profile below height 0 for :func:`turned`, and the same above it."""
    return [*profile, *((radius, -height) for radius, height in reversed(profile))]


def disc(
    centre: Point, radius: float, finish: Finish, *, facing: str = "+z", segments: int = 16
) -> Part:
    """Return a round flat surface that faces along an axis, with the finish laid flat on it."""
    angle = 2 * np.pi * np.arange(segments) / segments
    sign = 1.0 if facing[0] == "+" else -1.0
    ring = np.stack((np.cos(angle), sign * np.sin(angle), np.zeros(segments)), axis=1)
    order = {"x": [2, 0, 1], "y": [1, 2, 0], "z": [0, 1, 2]}[facing[1]]
    normal = np.broadcast_to(np.array([0.0, 0.0, sign])[order], (segments, 3))
    fan = np.array([[0, i, i + 1] for i in range(1, segments - 1)], dtype=np.int32)
    at = radius * ring[:, order] + np.asarray(centre)
    return Part(at, normal, finish.uv(0.5 + 0.5 * ring[:, :2], (ring[:, order[2]] + 1) / 2), fan)


def ball(centre: Point, radii: Point, finish: Finish, *, segments: int = 10) -> Part:
    """Return an ellipsoid; the radii along x and z, and the one along y."""
    x, y, z = radii
    angle = np.linspace(-np.pi / 2, np.pi / 2, segments // 2 + 1)
    profile = np.stack((x * np.cos(angle), z * np.sin(angle)), axis=1)
    return turned(
        profile, finish, centre=centre, segments=segments, smooth=True, squash=y / max(x, 1e-9)
    )


def rod(
    start: Point,
    end: Point,
    radius: float | tuple[float, float],
    finish: Finish,
    *,
    segments: int = 6,
) -> Part:
    """Return a round bar between two points, without ends; two radii make it taper."""
    a, b = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    at_a, at_b = radius if isinstance(radius, tuple) else (radius, radius)
    way = _unit(b - a)
    side = _unit(np.cross(way, (0.0, 1.0, 0.0) if abs(way[1]) < 0.9 else (1.0, 0.0, 0.0)))
    frame = np.array([side, np.cross(way, side), way])
    part = turned([[at_a, 0.0], [at_b, float(np.linalg.norm(b - a))]], finish, segments=segments)
    return replace(part, at=part.at @ frame + a, normal=part.normal @ frame)


def extruded(outline: npt.ArrayLike, y: tuple[float, float], finish: Finish) -> Part:
    """Return a convex outline in x and z, pulled along y.

    Parameters
    ----------
    outline
        Corners x, z, counter-clockwise seen from -y (x to the right, z up), shape (k, 2).
    """
    xz = np.asarray(outline, dtype=float)
    k, (low, high) = len(xz), y
    up = (xz[:, 1] - xz[:, 1].min()) / max(float(np.ptp(xz[:, 1])), 1e-9)
    ends = [np.insert(xz, 1, value, axis=1) for value in (low, high)]
    i, j = np.arange(k), np.roll(np.arange(k), -1)
    around = np.stack((ends[0][i], ends[1][i], ends[1][j], ends[0][j]), axis=1)
    parts = [quads(around, finish, up=np.stack((up[i], up[i], up[j], up[j]), axis=1))]
    fan = np.array([[0, i, i + 1] for i in range(1, k - 1)], dtype=np.int32)
    st = (xz - xz.min(axis=0)) / np.maximum(np.ptp(xz, axis=0), 1e-9)
    for end, sign in zip(ends, (-1, 1), strict=True):
        normal = np.tile((0.0, float(sign), 0.0), (k, 1))
        parts.append(Part(end, normal, finish.uv(st, up), fan if sign < 0 else fan[:, ::-1]))
    return join(parts)


def _unit(vectors: FloatArray) -> FloatArray:
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    unit: FloatArray = vectors / np.maximum(lengths, 1e-12)
    return unit
