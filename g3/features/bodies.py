"""Groundings packed into arrays, so that features see a whole batch at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from g3.geometry.plane import (
    METRES_PER_RADIAN,
    SAMPLES,
    IntArray,
    area,
    centroid,
    convex_hull,
    cross,
    hull_centre,
    moved_corners,
    padded,
    rotate,
    wrap,
)
from g3.groundings import FloatArray, Grounding, Path, PhysicalObject, Place, Trajectory
from g3.short_repr import short_repr

Singles = npt.NDArray[np.float32]

__all__ = [
    "MAX_CORNERS",
    "MAX_MEMBERS",
    "METRES_PER_RADIAN",
    "SAMPLES",
    "Bodies",
    "IntArray",
    "moved_corners",
    "pack",
    "padded",
    "positions_at",
]

MAX_CORNERS = 8
"""Footprints with more corners lose those that matter least to their area."""

MAX_MEMBERS = 8
"""Things of a plural that "between" looks at."""

CLOCK_RESOLUTION_S = 1e-3
"""Times that differ by less are the same; sums of time stamps are no more exact."""


@short_repr
@dataclass(frozen=True, slots=True)
class Bodies:
    """m groundings as arrays; a plural's groundings form one body.

    Parameters
    ----------
    corners
        Convex footprints at the first pose, counter-clockwise, shape (m, k, 2).
    centre, area
        Centres and areas of the footprints, shapes (m, 2) and (m,).
    z_min, z_max
        Heights of bottom and top at the first pose, shape (m,).
    count
        Number of things in the body, shape (m,).
    members
        Centres of up to MAX_MEMBERS of its things, NaN where there are fewer,
        shape (m, MAX_MEMBERS, 2).
    labels
        True for labels of any thing in the body, shape (m, number of labels).
    shared_labels
        True for labels of all things in the body, shape (m, number of labels).
    label_names
        The labels' names, sorted.
    t, xyz, yaw
        Resampled trajectories, shapes (m, SAMPLES), (m, SAMPLES, 3), (m, SAMPLES).
    moves
        True if the body has more than one pose, shape (m,).
    raw_t, raw_xyz, raw_yaw, offsets
        The trajectories as they are, one after another; body i's poses are
        ``offsets[i]:offsets[i + 1]``.
    """

    corners: FloatArray
    centre: FloatArray
    area: FloatArray
    z_min: FloatArray
    z_max: FloatArray
    count: FloatArray
    members: FloatArray
    labels: npt.NDArray[np.bool_]
    shared_labels: npt.NDArray[np.bool_]
    label_names: tuple[str, ...]
    t: FloatArray
    xyz: FloatArray
    yaw: FloatArray
    moves: npt.NDArray[np.bool_]
    raw_t: FloatArray
    raw_xyz: FloatArray
    raw_yaw: FloatArray
    offsets: IntArray


def pack(groups: Sequence[tuple[Grounding, ...]]) -> Bodies:
    """Pack groundings into arrays, in the same order.

    Parameters
    ----------
    groups
        One non-empty tuple of groundings for each body.
    """
    label_sets = [
        [set(g.labels if isinstance(g, PhysicalObject) else ()) for g in group] for group in groups
    ]
    label_names = tuple(sorted({label for sets in label_sets for s in sets for label in s}))
    column = {name: i for i, name in enumerate(label_names)}
    labels = np.zeros((len(groups), len(label_names)), dtype=bool)
    shared_labels = labels.copy()
    for i, sets in enumerate(label_sets):
        labels[i, [column[name] for name in set.union(*sets)]] = True
        shared_labels[i, [column[name] for name in set.intersection(*sets)]] = True
    things = [[convex_hull(_outline(g)) for g in group] for group in groups]
    hulls = [_footprint(hulls) for hulls in things]
    trajectories = [_trajectory(group) for group in groups]
    lengths = np.array([len(t) for t in trajectories], dtype=np.intp)
    offsets = np.concatenate(([0], np.cumsum(lengths))).astype(np.intp)
    raw_t = np.concatenate([t.t for t in trajectories]) if groups else np.zeros(0)
    raw_xyz = np.concatenate([t.xyz for t in trajectories]) if groups else np.zeros((0, 3))
    raw_yaw = np.concatenate([t.yaw for t in trajectories]) if groups else np.zeros(0)
    raw_yaw = _unwrap(raw_yaw, offsets)
    t, xyz, yaw = _resample(raw_t, raw_xyz, raw_yaw, offsets)
    heights = np.array([_heights(group) for group in groups]).reshape(len(groups), 2)
    corners = padded(hulls)
    return Bodies(
        corners=corners,
        centre=centroid(corners),
        area=area(corners),
        z_min=heights[:, 0],
        z_max=heights[:, 1],
        count=np.array([len(group) for group in groups], dtype=float),
        members=_members(things),
        labels=labels,
        shared_labels=shared_labels,
        label_names=label_names,
        t=t,
        xyz=xyz,
        yaw=yaw,
        moves=lengths > 1,
        raw_t=raw_t,
        raw_xyz=raw_xyz,
        raw_yaw=raw_yaw,
        offsets=offsets,
    )


def positions_at(bodies: Bodies, index: IntArray, t: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Positions (n, T, 3) and headings (n, T) of bodies: at the last pose logged by a time.

    Things are logged when they move, so between two poses they stood at the first one;
    before its log a body is at its first pose.

    Parameters
    ----------
    index
        Bodies to look up, shape (n,).
    t
        Times in seconds, shape (n, T).
    """
    first, last = bodies.offsets[index], bodies.offsets[index + 1] - 1
    begin, end = bodies.raw_t[first][:, None], bodies.raw_t[last][:, None]
    key, scale = _keys(bodies.raw_t, bodies.offsets)
    query = index[:, None] * scale + np.clip(t, begin, end) - begin
    pose = np.searchsorted(key, query + CLOCK_RESOLUTION_S, side="right") - 1
    return bodies.raw_xyz[pose], bodies.raw_yaw[pose]


def _keys(values: FloatArray, offsets: IntArray) -> tuple[FloatArray, float]:
    """Make per-body increasing values increase over all bodies, to interpolate in one call."""
    lengths = np.diff(offsets)
    begin = np.repeat(values[offsets[:-1]], lengths)
    relative = values - begin
    scale = 2 * float(relative.max(initial=0.0)) + 1.0
    return np.repeat(np.arange(len(lengths)), lengths) * scale + relative, scale


def _unwrap(yaw: FloatArray, offsets: IntArray) -> FloatArray:
    """Headings without jumps of a full turn inside a trajectory."""
    step = wrap(np.diff(yaw, prepend=yaw[:1]))
    step[offsets[:-1]] = 0.0
    total = np.cumsum(step)
    lengths = np.diff(offsets)
    return total + np.repeat(yaw[offsets[:-1]] - total[offsets[:-1]], lengths)


def _resample(
    t: FloatArray, xyz: FloatArray, yaw: FloatArray, offsets: IntArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Poses evenly spread along each trajectory, however densely it was logged."""
    if len(t) == 0:
        return np.zeros((0, SAMPLES)), np.zeros((0, SAMPLES, 3)), np.zeros((0, SAMPLES))
    step = np.linalg.norm(np.diff(xyz, axis=0, prepend=xyz[:1]), axis=1)
    step += METRES_PER_RADIAN * np.abs(np.diff(yaw, prepend=yaw[:1]))
    step[offsets[:-1]] = 0.0
    along = np.cumsum(step)
    first, last = offsets[:-1], offsets[1:] - 1
    key, scale = _keys(along, offsets)
    total = along[last] - along[first]
    query = np.arange(len(first))[:, None] * scale + total[:, None] * np.linspace(0, 1, SAMPLES)
    return (
        np.interp(query, key, t),
        np.stack([np.interp(query, key, xyz[:, axis]) for axis in range(3)], axis=-1),
        np.interp(query, key, yaw),
    )


def _footprint(hulls: Sequence[FloatArray]) -> FloatArray:
    hull = hulls[0] if len(hulls) == 1 else convex_hull(np.concatenate(hulls))
    while len(hull) > MAX_CORNERS:
        before, after = np.roll(hull, 1, axis=0), np.roll(hull, -1, axis=0)
        hull = np.delete(hull, np.argmin(cross(hull - before, after - hull)), axis=0)
    return hull


def _outline(grounding: Grounding) -> FloatArray:
    if isinstance(grounding, Path):
        # The box around the path along its own first heading, which turns as the path does.
        heading = grounding.trajectory.yaw[0]
        xy = rotate(grounding.trajectory.xyz[:, :2], -heading)
        (x0, y0), (x1, y1) = xy.min(axis=0), xy.max(axis=0)
        return rotate(np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]]), heading)
    return grounding.prism.xy


def _heights(group: tuple[Grounding, ...]) -> tuple[float, float]:
    bounds = [
        (g.trajectory.xyz[:, 2].min(), g.trajectory.xyz[:, 2].max())
        if isinstance(g, Path)
        else (g.prism.z_min, g.prism.z_max)
        for g in group
    ]
    return float(min(low for low, _ in bounds)), float(max(high for _, high in bounds))


def _trajectory(group: tuple[Grounding, ...]) -> Trajectory:
    """Return the trajectory of the body: of the thing in it that moves most."""
    trajectories = [_own_trajectory(g) for g in group]
    return trajectories[0] if len(trajectories) == 1 else max(trajectories, key=_length)


def _length(trajectory: Trajectory) -> float:
    if len(trajectory) == 1:
        return 0.0
    turned = METRES_PER_RADIAN * np.abs(wrap(np.diff(trajectory.yaw)))
    return float((np.linalg.norm(np.diff(trajectory.xyz, axis=0), axis=1) + turned).sum())


def _own_trajectory(grounding: Grounding) -> Trajectory:
    if not isinstance(grounding, Place):
        return grounding.trajectory
    prism = grounding.prism
    return Trajectory(np.zeros(1), np.array([[*hull_centre(prism.xy), prism.z_min]]), np.zeros(1))


def _members(things: Sequence[Sequence[FloatArray]]) -> FloatArray:
    centres = np.full((len(things), MAX_MEMBERS, 2), np.nan)
    place = [(row, i) for row, hulls in enumerate(things) for i in range(len(hulls[:MAX_MEMBERS]))]
    if place:
        row, member = np.array(place).T
        centres[row, member] = centroid(padded([things[i][j] for i, j in place]))
    return centres
