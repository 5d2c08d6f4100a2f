"""Trajectories of many candidate actions at once.

Features see where an action goes and what it does to its load. They don't see how it gets around
what stands in between. So candidates follow the curves of :mod:`g3.actions.courses` past all
obstacles, a batch in one go; the chosen plan is what physics carries out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from g3.actions.courses import CUSP_COST_M, NEVER, Course, arc, clear_cost, curve, direction
from g3.geometry.plane import METRES_PER_RADIAN, SAMPLES, IntArray, length, rotate
from g3.groundings import FloatArray
from g3.short_repr import short_repr

SPEED_M_S, LIFT_M_S = 1.0, 0.1
LIFT_M = 0.3
"""Height to which loads are lifted off their support, and carried over the ground."""

_BACKWARDS = np.array([(0.0, 0.0), (2.0, 0.0), (4.0, 1.2), (4.0, -1.2)])
_FINE, _COARSE = np.linspace(0, 1, 21), np.linspace(0, 1, 9)


@short_repr
@dataclass(frozen=True, slots=True)
class Motions:
    """n trajectories of the robot and of what it moves, evenly sampled along the robot's way.

    Parameters
    ----------
    t
        Times, shape (n, SAMPLES).
    xyz, yaw
        The robot's poses, shapes (n, SAMPLES, 3) and (n, SAMPLES).
    load
        Index of the moved one of the given things, -1 for none, shape (n,).
    load_xyz, load_yaw
        Poses of the middle of its bottom, shaped as the robot's; the robot's where there is none.
    """

    t: FloatArray
    xyz: FloatArray
    yaw: FloatArray
    load: IntArray
    load_xyz: FloatArray
    load_yaw: FloatArray

    def __len__(self) -> int:
        return len(self.t)


def legs(course: Course) -> tuple[FloatArray, FloatArray, IntArray, IntArray]:
    """Drive courses: to each stop, in straight, and back out.

    Returns
    -------
    poses, rise, grip, drop
        Poses x, y, yaw, shape (n, m, 3); the forks' height in metres over the load's first one,
        shape (n, m); at which pose a load is gripped, and at which it is let go of, m for never,
        shape (n,).
    """
    parts, here, ends = [course.lead], course.lead[:, -1], [0]
    for stop in course.stops:
        before = stop.finals.copy()
        before[..., :2] -= stop.run_in[:, None, None] * direction(stop.finals[..., 2])
        way = ways(here, before, stop.penalty)
        into = straights(way[:, -1], stop.run_in)
        out = straights(into[:, -1], -stop.out)
        parts += [way, into, out]
        here = out[:, -1]
        ends.append(sum(part.shape[1] for part in parts[:-1]) - 1)
    poses = np.concatenate(parts, axis=1)
    m = poses.shape[1]
    grips, drops = course.grip != NEVER, course.drop != NEVER
    grip = np.where(grips, np.array(ends)[course.grip + 1], 0)
    drop = np.where(drops, np.array(ends)[course.drop + 1], m)
    pose = np.arange(m)
    carried, down = np.where(grips, LIFT_M, course.lift)[:, None], course.down[:, None]
    rise = np.where(pose > grip[:, None], carried, 0.0)
    over = np.maximum(carried, down + LIFT_M / 2)
    lowering = np.where(drops, drop - len(_COARSE), m)[:, None]
    rise = np.where(pose > lowering, over, rise)
    rise = np.where(pose >= drop[:, None], down, rise)
    return poses, rise, grip, drop


def ways(start: FloatArray, finals: FloatArray, penalty: FloatArray) -> FloatArray:
    """Return the cheapest curve from each start to a final pose, after backing up if need be.

    Parameters
    ----------
    start
        Poses, shape (n, 3).
    finals
        Alternatives, shape (n, h, 3).
    penalty
        Extra cost of each in metres, infinite for one that isn't there, shape (n, h).

    Returns
    -------
    FloatArray
        Shape (n, m, 3); the start where there is no alternative.
    """
    way = np.repeat(start[:, None], len(_COARSE) + len(_FINE), axis=1)
    rows = np.flatnonzero(np.isfinite(penalty).any(axis=1))
    poses = np.concatenate((start, finals.reshape(len(start), -1), penalty), axis=1)[rows]
    number: dict[bytes, int] = {}
    which = [number.setdefault(row.tobytes(), len(number)) for row in poses]
    _, first = np.unique(which, return_index=True)
    different = rows[first]
    way[rows] = _ways(start[different], finals[different], penalty[different])[which]
    return way


def _ways(start: FloatArray, finals: FloatArray, penalty: FloatArray) -> FloatArray:
    """Ways of rows that all differ and have an alternative."""
    reverse = _BACKWARDS[:, 0]
    extra = reverse + CUSP_COST_M * (reverse > 0)
    back = arc(start[:, None], -reverse, _BACKWARDS[:, 1], _COARSE)
    straight = length(finals[:, :, None, :2] - back[:, None, :, -1, :2])
    least = straight + penalty[..., None] + extra - 1e-9
    cost = np.full(least.shape, np.inf)
    number = np.zeros(least.shape, dtype=np.intp)
    curves = np.zeros((0, len(_FINE), 3))
    # First ahead from where it stands, then the manoeuvres that could still be cheaper.
    tried = np.isfinite(least) & (reverse == 0)
    for _ in range(2):
        row, option, manoeuvre = np.nonzero(tried)
        ahead = curve(back[row, manoeuvre, -1], finals[row, option], _FINE)
        cost[tried] = clear_cost(ahead) + penalty[row, option] + extra[manoeuvre]
        number[tried] = len(curves) + np.arange(len(row))
        curves = np.concatenate((curves, ahead))
        tried = np.isinf(cost) & (least <= cost.min(axis=(1, 2), keepdims=True))
    rows = np.arange(len(start))
    option, manoeuvre = np.divmod(cost.reshape(len(start), -1).argmin(axis=1), len(reverse))
    ahead = curves[number[rows, option, manoeuvre]]
    return np.concatenate((back[rows, manoeuvre], ahead), axis=1)


def straights(start: FloatArray, metres: FloatArray) -> FloatArray:
    """Straight ahead, or back where the metres (n,) is negative, from poses (n, 3); (n, m, 3)."""
    poses = np.repeat(start[:, None], len(_COARSE), axis=1)
    poses[..., :2] += (metres[:, None] * _COARSE)[..., None] * direction(start[:, 2])[:, None]
    return poses


def sampled(course: Course, ground: float, load: IntArray, first: FloatArray) -> Motions:
    """Motions of courses.

    Parameters
    ----------
    ground
        Height of the robot's position.
    load
        Index of the thing that each course moves, -1 for none, shape (n,).
    first
        Its first pose x, y, z, yaw with the height of its bottom, shape (n, 4).
    """
    poses, rise, grip_at, drop_at = legs(course)
    poses[..., 2] = np.unwrap(poses[..., 2], axis=1)
    n, m = poses.shape[:2]
    step = np.linalg.norm(np.diff(poses[..., :2], axis=1), axis=2)
    step = step + METRES_PER_RADIAN * np.abs(np.diff(poses[..., 2], axis=1))
    along = np.concatenate((np.zeros((n, 1)), np.cumsum(step, axis=1)), axis=1)
    lifting = np.abs(np.diff(rise, axis=1)) / LIFT_M_S
    t = np.concatenate((np.zeros((n, 1)), np.cumsum(step / SPEED_M_S + lifting, axis=1)), axis=1)
    rows, pose = np.arange(n), np.arange(m)
    grip = poses[rows, grip_at]
    offset = rotate(first[:, :2] - grip[:, :2], -grip[:, 2])
    held = np.concatenate(
        (
            poses[..., :2] + rotate(offset[:, None], poses[..., 2]),
            (first[:, 2:3] + rise)[..., None],
            (first[:, 3:] + poses[..., 2] - grip[:, 2:])[..., None],
        ),
        axis=2,
    )
    left = held[rows, np.minimum(drop_at, m - 1)]
    held = np.where((pose <= grip_at[:, None])[..., None], first[:, None], held)
    held = np.where((pose > drop_at[:, None])[..., None], left[:, None], held)
    values = np.concatenate((t[..., None], poses, held), axis=2)
    even = _evenly(along, values)
    height = np.full((n, SAMPLES, 1), ground)
    return Motions(
        t=even[..., 0],
        xyz=np.concatenate((even[..., 1:3], height), axis=2),
        yaw=even[..., 3],
        load=load,
        load_xyz=even[..., 4:7],
        load_yaw=even[..., 7],
    )


def _evenly(along: FloatArray, values: FloatArray) -> FloatArray:
    """Values (n, m, c) at SAMPLES places, even along their ways (n, m)."""
    n, m = along.shape
    total = along[:, -1:]
    stride = float(total.max(initial=0.0)) + 1.0
    shift = stride * np.arange(n)[:, None]
    key = (along + shift).reshape(-1)
    query = (total * np.linspace(0, 1, SAMPLES) + shift).reshape(-1)
    flat = values.reshape(n * m, -1)
    before = np.searchsorted(key, query, side="right") - 1
    after = np.minimum(before + 1, n * m - 1)
    gap = key[after] - key[before]
    part = (query - key[before]) / np.where(gap > 0, gap, 1.0)
    between = flat[before] + part[:, None] * (flat[after] - flat[before])
    even: FloatArray = between.reshape(n, SAMPLES, -1)
    # Where poses repeat, the first and the last sample are the way's own.
    even[:, 0], even[:, -1] = values[:, 0], values[:, -1]
    return even
