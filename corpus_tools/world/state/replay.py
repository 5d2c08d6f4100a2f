"""Kinematic replay of a context's log.

The logs of the AAAI-11 corpus have a pose about every second while something moves, and
nothing while it stands. Replays have one at every moment of a regular clock, and forks. The load on
them is derived from the poses of things.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy.interpolate import PchipInterpolator

from corpus_tools.world.state.dimensions import ENTRY_HEIGHT, LOW
from corpus_tools.world.state.recording import NS_PER_S, Recording, heading, upright
from corpus_tools.world.state.shapes import Shape, shape_of
from corpus_tools.world.state.thing_kinds import kind_of
from g3.actions.logged_actions import REACH_M, at_rest, loaded
from g3.geometry.plane import BoolArray, rotate, wrap
from g3.groundings import Context, FloatArray, PhysicalObject, Trajectory

PERIOD_S = 1.0
"""Time between the poses of a log. Where it has none for longer, nothing moved but in the
last such time."""
SAME_S = 0.001
"""Poses nearer in time than this are one: the first one at the log's start, else the last."""
FORK_SPEED_M_S = 0.3
ENTER_M = 2.3
"""From here on the forks may be in a load, or in front of what it stands on."""


@dataclass(frozen=True, slots=True, eq=False)
class _Poses:
    """Poses at the moments of a replay: t (n,), xyz (n, 3), yaw (n,)."""

    t: FloatArray
    xyz: FloatArray
    yaw: FloatArray


def replay(context: Context, rate_hz: float) -> Recording:
    """Play a context's trajectories again, with a number of moments a second.

    The robot passes through its poses smoothly, a load keeps to the robot while it is carried, and
    what has one pose stands still. The forks aren't in the log. They are in a load that moves with
    the robot, under its deck while the robot drives in and out, and down elsewhere. There is one
    moment only if nothing has a trajectory. Times are true to the log's.
    """
    moving = [item.trajectory for item in context.objects if len(item.trajectory) > 1]
    begin = min((way.t[0] for way in moving), default=0.0)
    duration = max((way.t[-1] for way in moving), default=begin) - begin
    count = int(np.ceil(round(duration * rate_hz, 6))) + 1
    t_ns = np.rint(np.arange(count) * (NS_PER_S / rate_hz)).astype(np.int64)
    t = np.minimum(t_ns / NS_PER_S, duration)
    t[-1] = duration  # also where the count was rounded down
    loaded_id = loaded(context)
    robot = _driven(_knots(context.agent.trajectory, begin), t)
    forks = _Forks(t, robot.xyz[:, 2])
    poses = []
    for item in context.objects:
        if item.id == context.agent_id:
            poses.append(robot)
        elif len(item.trajectory) == 1:
            poses.append(_still(item.trajectory, t))
        else:
            poses.append(
                _moved(item, _knots(item.trajectory, begin), robot, forks, item.id == loaded_id)
            )
    # At the recording's own time 0: that of the log may be hours on a clock of its own.
    poses_then = (at_rest(item.trajectory) for item in context.objects)
    still = (
        replace(item, trajectory=replace(pose, t=np.zeros(1)))
        for item, pose in zip(context.objects, poses_then, strict=True)
    )
    return Recording(
        start=replace(context, objects=tuple(still)),
        t_ns=t_ns,
        position=np.stack([pose.xyz for pose in poses], axis=1),
        orientation=upright(np.stack([pose.yaw for pose in poses], axis=1)),
        fork_height_m=forks.height(),
    )


class _Forks:
    """Gathers how high the forks must be, and fills in the rest."""

    def __init__(self, t: FloatArray, ground: FloatArray) -> None:
        self._t, self._ground = t, ground
        self._least = np.full(len(t), LOW)
        self._in_load = np.full(len(t), np.nan)

    def enter(self, at: BoolArray, bottom: FloatArray) -> None:
        """Keep clear under the deck of a load with its bottom at these heights (n,)."""
        self._least[at] = np.maximum(self._least, bottom - self._ground + LOW)[at]

    def carry(self, at: BoolArray, bottom: FloatArray) -> None:
        """Hold a load."""
        self._in_load[at] = (bottom - self._ground + ENTRY_HEIGHT)[at]

    def height(self) -> FloatArray:
        """Return heights above the ground (n,): the required ones, else as low as speed allows."""
        least = np.fmax(self._least, self._in_load)
        way = FORK_SPEED_M_S * self._t
        after = np.maximum.accumulate(least + way) - way
        before = np.maximum.accumulate((least - way)[::-1])[::-1] + way
        free = np.maximum(after, before)
        # Down is exactly down, in spite of rounding.
        free = np.where(free - least > 1e-9, free, least)
        held = np.maximum(self._in_load, LOW)
        height: FloatArray = np.where(np.isnan(self._in_load), free, held)
        return height


def _still(trajectory: Trajectory, t: FloatArray) -> _Poses:
    n = len(t)
    return _Poses(t, np.repeat(trajectory.xyz[:1], n, axis=0), np.repeat(trajectory.yaw[:1], n))


def _knots(trajectory: Trajectory, begin: float) -> _Poses:
    """Return the poses of a log by the replay's clock, with waits where it has gaps."""
    t = trajectory.t - begin
    same = np.floor((t - t[0]) / SAME_S)
    use = (np.diff(same, append=np.inf) > 0) & (same > 0)
    use[0] = True
    t, xyz, yaw = t[use], trajectory.xyz[use], trajectory.yaw[use]
    yaw = yaw[0] + np.concatenate(([0.0], np.cumsum(wrap(np.diff(yaw)))))
    gap = np.flatnonzero(np.diff(t) > 2 * PERIOD_S)
    return _Poses(
        np.insert(t, gap + 1, t[gap + 1] - PERIOD_S),
        np.insert(xyz, gap + 1, xyz[gap], axis=0),
        np.insert(yaw, gap + 1, yaw[gap]),
    )


def _driven(knots: _Poses, t: FloatArray) -> _Poses:
    """Return poses along a smooth way through knots that overshoots none of them."""
    if len(knots.t) == 1:
        return _Poses(t, np.repeat(knots.xyz, len(t), axis=0), np.repeat(knots.yaw, len(t)))
    values = np.column_stack((knots.xyz, knots.yaw))
    # Slopes near 0 have an inverse that is infinite; they count as 0 then.
    with np.errstate(over="ignore"):
        smooth = PchipInterpolator(knots.t, values)(np.clip(t, knots.t[0], knots.t[-1]))
    return _Poses(t, smooth[:, :3], smooth[:, 3])


def _moved(
    item: PhysicalObject, knots: _Poses, robot: _Poses, forks: _Forks, from_start: bool
) -> _Poses:
    """Return the poses of an object that the log moves, and their demands on the forks."""
    shape = shape_of(item)
    if len(knots.t) == 1:
        return _driven(knots, robot.t)
    at_knots = _sampled(robot, knots.t)
    local = _Poses(
        knots.t,
        np.column_stack(
            (
                rotate(knots.xyz[:, :2] - at_knots.xyz[:, :2], -at_knots.yaw),
                knots.xyz[:, 2] - at_knots.xyz[:, 2],
            )
        ),
        knots.yaw - at_knots.yaw,
    )
    held = _held(knots, at_knots, shape, from_start)
    here = _sampled(local, robot.t)
    along = np.column_stack(
        (robot.xyz[:, :2] + rotate(here.xyz[:, :2], robot.yaw), robot.xyz[:, 2] + here.xyz[:, 2])
    )
    alone = _sampled(knots, robot.t)
    leg = np.clip(np.searchsorted(knots.t, robot.t, side="right") - 1, 0, len(held) - 1)
    inside = (robot.t >= knots.t[0]) & (robot.t <= knots.t[-1])
    on_forks = held[leg] & inside
    poses = _Poses(
        robot.t,
        np.where(on_forks[:, None], along, alone.xyz),
        np.where(on_forks, robot.yaw + here.yaw, alone.yaw),
    )
    _ask(forks, poses, robot, shape, on_forks)
    return poses


def _sampled(knots: _Poses, t: FloatArray) -> _Poses:
    """Return poses on straight lines between knots, the first and the last one outside of them."""
    columns = (*knots.xyz.T, knots.yaw)
    x, y, z, yaw = (np.interp(t, knots.t, column) for column in columns)
    return _Poses(t, np.column_stack((x, y, z)), yaw)


def _held(knots: _Poses, robot: _Poses, shape: Shape, from_start: bool) -> BoolArray:
    """Mark the gaps between knots (k - 1,) in which a load is on the forks.

    Where it is within reach at both ends and moves, and in the waits between such moves;
    from the start if the log starts loaded.
    """
    near = within_reach(from_robot(knots.xyz, knots.yaw, shape, robot.xyz, robot.yaw))
    reach = near[1:] & near[:-1]
    moves = reach & ((np.diff(knots.xyz, axis=0) != 0).any(axis=1) | (np.diff(knots.yaw) != 0))
    # A wait counts if the load moves before and after it without leaving the reach.
    run = np.cumsum(~reach)
    first, last = np.full(len(run) + 1, len(run)), np.full(len(run) + 1, -1)
    where = np.flatnonzero(moves)
    np.minimum.at(first, run[where], where)
    np.maximum.at(last, run[where], where)
    if from_start and reach[0]:
        first[0] = 0
    leg = np.arange(len(run))
    return np.asarray(reach & (leg >= first[run]) & (leg <= last[run]))


def _ask(forks: _Forks, load: _Poses, robot: _Poses, shape: Shape, on_forks: BoolArray) -> None:
    """Set the forks where a load needs them: while it is carried, and on the way in and out."""
    if not on_forks.any():
        return
    bottom = load.xyz[:, 2] + shape.low[2]
    middle = from_robot(load.xyz, load.yaw, shape, robot.xyz, robot.yaw)
    close = on_forks | (np.linalg.norm(middle, axis=1) < ENTER_M)
    # Only such closeness as begins or ends with carrying; the robot also drives past loads.
    run = np.cumsum(~close)
    forks.enter(close & np.isin(run, run[on_forks]), bottom)
    forks.carry(on_forks, bottom)


NEAR_M = (0.5, REACH_M + 0.3)
"""Distance ahead of the robot of the middle of a load on the forks, from and to, in metres."""
ASIDE_M = 0.4
TOUCH_M = 0.01
"""Forks this near to the underside of a pallet's deck are taken to touch it."""

NOTHING = -1


def carried(recording: Recording) -> npt.NDArray[np.int64]:
    """Return the object on the forks at every moment: its index into ``start.objects``, (n,).

    One that can be carried, is straight ahead within reach, and touches the forks; :data:`NOTHING`
    where they are empty.
    """
    start = recording.start
    robot = [item.id for item in start.objects].index(start.agent_id)
    yaw = heading(recording.orientation)
    pose = recording.position[:, robot], yaw[:, robot]
    forks = recording.position[:, robot, 2] + recording.fork_height_m
    load = np.full(len(recording.t_ns), NOTHING, dtype=np.int64)
    for i, item in enumerate(start.objects):
        if i == robot or not kind_of(item.labels).carriable:
            continue
        shape = shape_of(item)
        opening = recording.position[:, i, 2] + shape.low[2] + ENTRY_HEIGHT
        near = within_reach(from_robot(recording.position[:, i], yaw[:, i], shape, *pose))
        load[near & (np.abs(opening - forks) < TOUCH_M)] = i
    return load


def from_robot(
    xyz: FloatArray, yaw: FloatArray, shape: Shape, robot_xyz: FloatArray, robot_yaw: FloatArray
) -> FloatArray:
    """Return the middles of an object's footprint in the robot's frame, shape (n, 2).

    `xyz` and `yaw` are the object's poses, shapes (n, 3) and (n,), `shape` its box in its own
    frame, `robot_xyz` and `robot_yaw` the robot's poses at the same times.
    """
    middle = xyz[:, :2] + rotate(np.broadcast_to(shape.middle[:2], (len(yaw), 2)), yaw)
    return rotate(middle - robot_xyz[:, :2], -robot_yaw)


def within_reach(middle: FloatArray) -> BoolArray:
    """Mark the things with middles (n, 2) in the robot's frame that can be on the forks."""
    near: BoolArray = (
        (middle[:, 0] > NEAR_M[0]) & (middle[:, 0] < NEAR_M[1]) & (np.abs(middle[:, 1]) < ASIDE_M)
    )
    return near
