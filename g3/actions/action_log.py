"""Logs of actions: what moves a vehicle and its load through the stages of an action."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from g3.geometry.plane import rotate
from g3.groundings import Context, FloatArray, PhysicalObject, Trajectory


@dataclass(frozen=True, slots=True)
class Pace:
    """How fast things go, and how often they are logged.

    Parameters
    ----------
    cruise_m_s
        Greatest speed.
    creep_m_s, ramp
        Speed at a stop, and by how much it grows with each metre away from it.
    turn_m
        Metres that a radian of turning counts for.
    lift_m_s
        Speed of the forks.
    waits
        How long the vehicle waits where the corpus' vehicle plans its next step, as a
        share of what that takes; nothing is logged meanwhile.
    period_s
        Time between log entries.
    """

    cruise_m_s: float = 1.2
    creep_m_s: float = 0.1
    ramp: float = 0.2
    turn_m: float = 1.0
    lift_m_s: float = 0.1
    waits: float = 1.0
    period_s: float = 1.0


DEFAULT_PACE = Pace()


@dataclass(frozen=True, slots=True)
class Outcome:
    """The log of an action.

    Parameters
    ----------
    agent
        The agent with its trajectory.
    objects
        Every other object of the context, in its order: those moved with the poses that
        they had while they moved, on the agent's clock, the others with one pose.
    """

    agent: PhysicalObject
    objects: tuple[PhysicalObject, ...]


def recorded(context: Context) -> Outcome:
    """What the context's own log did."""
    return Outcome(context.agent, tuple(o for o in context.objects if o.id != context.agent_id))


@dataclass(frozen=True, slots=True)
class Stage:
    """A piece of an action between two stops.

    Parameters
    ----------
    poses
        The agent's, shape (n, 3).
    rise
        How high the load is over where it was first, in metres, shape (n,); None where
        nothing is on the forks.
    wait_s
        How long the corpus' vehicle waits first.
    """

    poses: FloatArray
    rise: FloatArray | None
    wait_s: float = 0.0


def drive(poses: FloatArray, rise: float | None, wait_s: float = 0.0) -> Stage:
    """Follow poses (n, 3) with a load at one height, or with nothing on the forks."""
    return Stage(poses, None if rise is None else np.full(len(poses), rise), wait_s)


def lift(before: Stage, rise: float, wait_s: float = 0.0) -> Stage:
    """Move the forks from where a stage left them."""
    now = 0.0 if before.rise is None else before.rise[-1]
    return Stage(np.repeat(before.poses[-1:], 2, axis=0), np.array([now, rise]), wait_s)


def action_log(
    context: Context, stages: Sequence[Stage], load: PhysicalObject | None, pace: Pace
) -> Outcome:
    """Do stages one after another and log who is where.

    Parameters
    ----------
    stages
        Each begins where the one before it ends.
    load
        What is on the forks in the stages that have a rise, gripped in the first of them.
    """
    agent = context.agent
    clock = float(agent.trajectory.t[0])
    agent_log = [np.array([[clock, *start_pose(context), 0.0]])]
    held_log: list[FloatArray] = []
    for stage in stages:
        rows = _timed(stage, clock, pace)
        agent_log.append(rows[1:] if rows[0, 0] == clock else rows)
        if stage.rise is not None:
            held_log.append(rows)
        clock = float(rows[-1, 0])
    rows = np.concatenate(agent_log)
    height = np.full(len(rows), agent.trajectory.xyz[0, 2])
    driven = Trajectory(rows[:, 0], np.column_stack((rows[:, 1:3], height)), rows[:, 3])
    objects = [
        replace(o, trajectory=_carried(context, o, np.concatenate(held_log)))
        if load is not None and o.id == load.id and held_log
        else replace(o, trajectory=at_rest(o.trajectory))
        for o in recorded(context).objects
    ]
    return Outcome(replace(agent, trajectory=driven), tuple(objects))


def _timed(stage: Stage, clock: float, pace: Pace) -> FloatArray:
    """Log entries of a stage from a time on: t, x, y, yaw, rise; shape (m, 5)."""
    rise = np.zeros(len(stage.poses)) if stage.rise is None else stage.rise
    step = np.diff(stage.poses, axis=0)
    length = np.linalg.norm(step[:, :2], axis=1) + pace.turn_m * np.abs(step[:, 2])
    along = np.concatenate(([0.0], np.cumsum(length)))
    to_stop = np.minimum(along, along[-1] - along)
    speed = np.minimum(
        pace.creep_m_s + pace.ramp * (to_stop[1:] + to_stop[:-1]) / 2, pace.cruise_m_s
    )
    lifting = np.abs(np.diff(rise)) / pace.lift_m_s
    begin = clock + pace.waits * stage.wait_s
    t = begin + np.concatenate(([0.0], np.cumsum(length / speed + lifting)))
    count = max(int(np.ceil((t[-1] - begin) / pace.period_s)), 1)
    logged = np.minimum(begin + pace.period_s * np.arange(count + 1), t[-1])
    values = np.column_stack((stage.poses, rise))
    return np.column_stack((logged, *(np.interp(logged, t, column) for column in values.T)))


def _carried(context: Context, load: PhysicalObject, held: FloatArray) -> Trajectory:
    """Where a load is while it is on the forks; `held` are log entries as in `_timed`."""
    first, grip = load.trajectory, held[0, 1:4]
    offset = rotate(first.xyz[:1, :2] - grip[:2], -grip[2:])
    xy = held[:, 1:3] + rotate(np.repeat(offset, len(held), axis=0), held[:, 3])
    z = first.xyz[0, 2] + held[:, 4]
    yaw = first.yaw[0] + held[:, 3] - grip[2]
    start = context.agent.trajectory.t[0]
    rest = np.diff(held[:, 0], prepend=start) > 0
    return Trajectory(
        np.concatenate(([start], held[rest, 0])),
        np.vstack((first.xyz[:1], np.column_stack((xy, z))[rest])),
        np.concatenate((first.yaw[:1], yaw[rest])),
    )


def start_pose(context: Context) -> FloatArray:
    """The agent's first x, y, yaw."""
    first = context.agent.trajectory
    return np.array([*first.xyz[0, :2], first.yaw[0]])


def at_rest(trajectory: Trajectory) -> Trajectory:
    """The first pose alone."""
    return Trajectory(trajectory.t[:1], trajectory.xyz[:1], trajectory.yaw[:1])
