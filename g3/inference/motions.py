"""Trajectories of many candidate actions at once.

What the features see of an action is where it goes and what it does to its load, not how it gets
around what stands in between. So candidates follow the curves of :mod:`g3.driving` past all
obstacles, a batch in one go; the chosen plan is what physics carries out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from g3.actions import BACK_OFF_M, BACK_OUT_M, CARRY_OUT_M, LIFT_M, RUN_IN_M, SIDE_ENTRY_M
from g3.driving import CUSP_COST_M, arc, clear_cost, curve, direction
from g3.features.bodies import METRES_PER_RADIAN, SAMPLES, IntArray
from g3.geometry import rotate
from g3.groundings import FloatArray

SPEED_M_S, LIFT_M_S = 1.0, 0.1
BLOCKED_COST_M = 20.0
CLEAR_M = 1.6
"""Entering past the middle of another thing nearer than this is as good as blocked."""

_BACKWARDS = np.array([(0.0, 0.0), (2.0, 0.0), (4.0, 1.2), (4.0, -1.2)])
_TURNS = np.array([0.0, SIDE_ENTRY_M, 0.0, SIDE_ENTRY_M])
_FINE, _COARSE = np.linspace(0, 1, 21), np.linspace(0, 1, 9)


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
        Which of the things given is moved, -1 for none, shape (n,).
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


def join_motions(parts: Sequence[Motions]) -> Motions:
    """Motions one after another."""
    return Motions(*(np.concatenate([getattr(p, f.name) for p in parts]) for f in fields(Motions)))


@dataclass(frozen=True, slots=True)
class Legs:
    """n ways, each of m poses, with the forks' height over the load's first one.

    Parameters
    ----------
    poses
        x, y, yaw; shape (n, m, 3).
    rise
        Metres, shape (n, m).
    grip, drop
        At which pose a load is gripped, and at which it is let go of; m for never.
    """

    poses: FloatArray
    rise: FloatArray
    grip: int
    drop: int


def ways(start: FloatArray, finals: FloatArray, penalty: FloatArray) -> FloatArray:
    """The cheapest curve from each start to one of its final poses, after backing up if need be.

    Parameters
    ----------
    start
        Poses, shape (n, 3).
    finals
        Alternatives, shape (n, h, 3).
    penalty
        What each costs on top in metres, shape (n, h).

    Returns
    -------
    FloatArray
        Shape (n, m, 3).
    """
    back = arc(start[:, None], -_BACKWARDS[:, 0], _BACKWARDS[:, 1], _COARSE)
    n, h, v = len(start), finals.shape[1], len(_BACKWARDS)
    begin = np.broadcast_to(back[:, None, :, -1], (n, h, v, 3)).reshape(-1, 3)
    end = np.broadcast_to(finals[:, :, None], (n, h, v, 3)).reshape(-1, 3)
    ahead = curve(begin, end, np.ones(len(begin)), _FINE)
    cost = clear_cost(ahead).reshape(n, h, v) + penalty[..., None]
    cost += _BACKWARDS[:, 0] + CUSP_COST_M * (_BACKWARDS[:, 0] > 0)
    best = cost.reshape(n, h * v).argmin(axis=1)
    rows = np.arange(n)
    chosen = ahead.reshape(n, h * v, len(_FINE), 3)[rows, best]
    return np.concatenate((back[rows, best % v], chosen), axis=1)


def straights(start: FloatArray, length: float) -> FloatArray:
    """Straight ahead, or back where the length is negative, from poses (n, 3); (n, m, 3)."""
    return arc(start, np.full(len(start), length), np.zeros(len(start)), _COARSE)


def quarters(yaw: FloatArray) -> FloatArray:
    """The four headings along and across yaws (n,); shape (n, 4)."""
    result: FloatArray = yaw[:, None] + np.pi / 2 * np.arange(4)
    return result


def driven(poses: FloatArray) -> Legs:
    """Driving with whatever is on the forks, or with nothing."""
    return Legs(poses, np.zeros(poses.shape[:2]), 0, poses.shape[1])


def entries(
    middle: FloatArray, headings: FloatArray, reach: FloatArray, things: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Poses in which a load is gripped or put down, and what entering them costs.

    Parameters
    ----------
    middle
        Where the load's middle is then, shape (n, 2).
    headings
        Of the robot, shape (n, h).
    reach
        From the robot to the load's middle in the robot's frame, shape (n, 2).
    things
        Middles of what may be in the way, shape (p, 2).
    """
    n, h = headings.shape
    offset = rotate(np.broadcast_to(reach[:, None], (n, h, 2)), headings)
    finals = np.concatenate((middle[:, None] - offset, headings[..., None]), axis=2)
    back = -np.array([0.5, 1.5, RUN_IN_M])
    along = finals[:, :, None, :2] + back[:, None] * direction(headings)[:, :, None]
    if not len(things):
        return finals, np.zeros((n, h))
    apart = np.linalg.norm(along[..., None, :] - things, axis=-1)
    own = np.linalg.norm(middle[:, None] - things, axis=-1) < 0.5
    apart = np.where(own[:, None, None], np.inf, apart)
    return finals, BLOCKED_COST_M * (apart.min(axis=(2, 3)) < CLEAR_M)


def picked(
    start: FloatArray, finals: FloatArray, penalty: FloatArray, out_m: float = BACK_OUT_M
) -> Legs:
    """Drive to something, in straight, lift it, and back out."""
    before = finals.copy()
    before[..., :2] -= RUN_IN_M * direction(finals[..., 2])
    way = ways(start, before, penalty)
    into = straights(way[:, -1], RUN_IN_M)
    out = straights(into[:, -1], -out_m)
    grip = way.shape[1] + into.shape[1]
    poses = np.concatenate((way, into, out), axis=1)
    rise = np.zeros(poses.shape[:2])
    rise[:, grip:] = LIFT_M
    return Legs(poses, rise, grip - 1, poses.shape[1])


def put(
    start: FloatArray,
    finals: FloatArray,
    penalty: FloatArray,
    carried: FloatArray,
    down: FloatArray,
) -> Legs:
    """Drive a load to where it is to stand, lower it, and back off.

    Parameters
    ----------
    carried, down
        How high the load is at first, and where it is to stand, over where it was gripped; (n,).
    """
    before = finals.copy()
    before[..., :2] -= RUN_IN_M * direction(finals[..., 2])
    way = ways(start, before, penalty)
    into = straights(way[:, -1], RUN_IN_M)
    off = straights(into[:, -1], -BACK_OFF_M)
    drop = way.shape[1] + into.shape[1]
    poses = np.concatenate((way, into, off), axis=1)
    rise = np.repeat(carried[:, None], poses.shape[1], axis=1)
    over = np.maximum(carried, down + LIFT_M / 2)
    rise[:, way.shape[1] : drop - 1] = over[:, None]
    rise[:, drop - 1 :] = down[:, None]
    return Legs(poses, rise, 0, drop)


def carried(
    start: FloatArray,
    pick: tuple[FloatArray, FloatArray],
    put_at: tuple[FloatArray, FloatArray],
    down: FloatArray,
) -> Legs:
    """Pick something up and put it down elsewhere; parameters as in the functions before."""
    first = picked(start, *pick, out_m=BACK_OUT_M + CARRY_OUT_M)
    second = put(first.poses[:, -1], *put_at, first.rise[:, -1], down)
    return Legs(
        np.concatenate((first.poses, second.poses), axis=1),
        np.concatenate((first.rise, second.rise), axis=1),
        first.grip,
        first.poses.shape[1] + second.drop,
    )


def sampled(
    legs: Legs, ground: float, load: IntArray, load_pose: FloatArray, load_z: FloatArray
) -> Motions:
    """Motions of ways.

    Parameters
    ----------
    ground
        Height of the robot's position.
    load
        Which thing each way moves, -1 for none, shape (n,).
    load_pose, load_z
        Its first pose x, y, yaw and the height of its bottom, shapes (n, 3) and (n,).
    """
    poses = legs.poses.copy()
    poses[..., 2] = np.unwrap(poses[..., 2], axis=1)
    n, m = poses.shape[:2]
    step = np.linalg.norm(np.diff(poses[..., :2], axis=1), axis=2)
    step = step + METRES_PER_RADIAN * np.abs(np.diff(poses[..., 2], axis=1))
    along = np.concatenate((np.zeros((n, 1)), np.cumsum(step, axis=1)), axis=1)
    lifting = np.abs(np.diff(legs.rise, axis=1)) / LIFT_M_S
    t = np.concatenate((np.zeros((n, 1)), np.cumsum(step / SPEED_M_S + lifting, axis=1)), axis=1)
    grip = poses[:, legs.grip]
    offset = rotate(load_pose[:, :2] - grip[:, :2], -grip[:, 2])
    held = np.concatenate(
        (
            poses[..., :2] + rotate(np.repeat(offset[:, None], m, axis=1), poses[..., 2]),
            (load_z[:, None] + legs.rise)[..., None],
            (load_pose[:, 2:] + poses[..., 2] - grip[:, 2:])[..., None],
        ),
        axis=2,
    )
    held[:, : legs.grip + 1] = np.column_stack((load_pose[:, :2], load_z, load_pose[:, 2]))[:, None]
    if legs.drop < m:
        held[:, legs.drop :] = held[:, legs.drop - 1 : legs.drop]
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
    key = (along + stride * np.arange(n)[:, None]).reshape(-1)
    query = (total * np.linspace(0, 1, SAMPLES) + stride * np.arange(n)[:, None]).reshape(-1)
    flat = values.reshape(n * m, -1)
    columns = [np.interp(query, key, flat[:, c]) for c in range(flat.shape[1])]
    even = np.stack(columns, axis=1).reshape(n, SAMPLES, -1)
    # Where poses repeat, the first and the last sample are the way's own.
    even[:, 0], even[:, -1] = values[:, 0], values[:, -1]
    return even
