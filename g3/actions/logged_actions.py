"""Actions of a context's log: moved things, their ends, handled loads."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from g3.geometry.footprints import centre, covers
from g3.geometry.plane import rotate
from g3.groundings import Context, FloatArray, PhysicalObject, Trajectory
from g3.short_repr import short_repr

REACH_M = 1.1
"""From the robot's position straight ahead to the middle of what is on the forks."""
MOVED_M = 0.15
"""Moves of the middle shorter than this are noise of the logs."""
RELEASED_M = 2.0
"""A load further than this from the robot is no longer on the forks."""
HANGING_M = 0.1
MOVED_OFF_M = 0.5


class Handling(NamedTuple):
    """Effects of an action on a load: picked up, put down."""

    takes: bool = False
    leaves: bool = False


NOTHING = Handling()
"""Loads are left alone: the action only drives."""


@short_repr
@dataclass(frozen=True, slots=True)
class Outcome:
    """The log of an action.

    Parameters
    ----------
    objects
        Every other object of the context, in its order: what is moved with a trajectory, the
        others with one pose.
    """

    agent: PhysicalObject
    objects: tuple[PhysicalObject, ...]


def recorded(context: Context) -> Outcome:
    """Return the outcome of the context's own log."""
    return Outcome(context.agent, tuple(o for o in context.objects if o.id != context.agent_id))


def handling(context: Context) -> Handling:
    """Return the handling of the first load that the context's own log moves."""
    log = recorded(context)
    held = loaded(context)
    away = [o for o in log.objects if o.id in moved(log)]
    if not away:
        return NOTHING
    load = next((o for o in away if o.id == held), away[0])
    gap = load.trajectory.xyz[-1, :2] - log.agent.trajectory.xyz[-1, :2]
    released = float(np.linalg.norm(gap)) > RELEASED_M
    return Handling(takes=load.id != held, leaves=released)


def moved(outcome: Outcome) -> frozenset[str]:
    """Ids of the objects that end elsewhere than they start."""
    return frozenset(
        o.id
        for o in outcome.objects
        if float(np.linalg.norm(o.trajectory.xyz[-1] - o.trajectory.xyz[0])) > MOVED_M
    )


def end_of(thing: PhysicalObject) -> FloatArray:
    """Return the middle of an object's footprint at its end, shape (2,).

    Exact for objects whose position is their middle; the others' turn is ignored.
    """
    shift: FloatArray = thing.trajectory.xyz[-1, :2] - thing.trajectory.xyz[0, :2]
    return centre(thing.prism) + shift


def path_length(outcome: Outcome) -> float:
    """Return the length of the robot's way, in metres."""
    step = np.diff(outcome.agent.trajectory.xyz[:, :2], axis=0)
    return float(np.linalg.norm(step, axis=1).sum())


def at_rest(trajectory: Trajectory) -> Trajectory:
    """Return the first pose alone."""
    return Trajectory(trajectory.t[:1], trajectory.xyz[:1], trajectory.yaw[:1])


def loaded(context: Context) -> str | None:
    """Return the object on the forks when the log starts, if any.

    One that is straight ahead within reach and either stands on nothing, or moves with
    the robot when the robot first moves.
    """
    agent = context.agent.trajectory
    things = recorded(context).objects
    middles = np.array([centre(thing.prism) for thing in things]).reshape(-1, 2)
    offsets = rotate(middles - agent.xyz[0, :2], np.full(len(things), -agent.yaw[0]))
    for thing, offset in zip(things, offsets.tolist(), strict=True):
        near = 0.5 < offset[0] < REACH_M + 0.3 and abs(offset[1]) < 0.4
        if near and (_hangs(context, thing) or _goes_along(thing.trajectory, agent)):
            return thing.id
    return None


def _hangs(context: Context, thing: PhysicalObject) -> bool:
    """Check that an object stands neither on the ground nor on another object."""
    middle = centre(thing.prism)
    tops = [
        o.prism.z_max
        for o in recorded(context).objects
        if o.id != thing.id and covers(o.prism, middle)
    ]
    ground = float(context.agent.trajectory.xyz[0, 2])
    return bool((np.abs(thing.prism.z_min - np.array([ground, *tops])) > HANGING_M).all())


def _goes_along(thing: Trajectory, agent: Trajectory) -> bool:
    """Check that an object keeps its place relative to the robot when that first moves off."""
    travelled = np.linalg.norm(agent.xyz[:, :2] - agent.xyz[0, :2], axis=1)
    if len(thing) == 1 or travelled.max() < MOVED_OFF_M:
        return False
    i = int(np.argmax(travelled >= MOVED_OFF_M))
    j = max(int(np.searchsorted(thing.t, agent.t[i], side="right")) - 1, 0)
    before = rotate(thing.xyz[0, :2] - agent.xyz[0, :2], -agent.yaw[0])
    after = rotate(thing.xyz[j, :2] - agent.xyz[i, :2], -agent.yaw[i])
    return bool(np.linalg.norm(after - before) < MOVED_OFF_M / 2)
