"""The execution of a log or a plan in a world, and of another world's log in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from g3.actions.action_kinds import Action, move, result
from g3.actions.logged_actions import RELEASED_M, loaded, moved, recorded
from g3.actions.robot_state import State, moved_to, start_state, with_moved
from g3.geometry.footprints import centre
from g3.groundings import Context, FloatArray, PhysicalObject
from g3.short_repr import short_repr

LEAVES_M = 0.3
"""Distance in metres from its start beyond which a load has been lifted; also from its end, for
setting it down."""


@dataclass(frozen=True, slots=True)
class Carried:
    """A load that was moved, or that stayed on the forks."""

    id: str
    lifted: int
    """Row of the robot's path at which the load leaves its place; 0 if on the forks at first."""
    lowered: int | None
    """Row at which the load comes to its last place; None if on the forks at the end."""


@short_repr
@dataclass(frozen=True, slots=True)
class Execution:
    """The course of a log or a plan: start, end, path and loads moved."""

    start: State
    end: State
    way: FloatArray
    """The robot's x, y, yaw over time, shape (n, 3)."""
    carried: tuple[Carried, ...]
    """Loads that were moved, in the order in which they were lifted."""
    whole: bool = False
    """True if the execution covers all of a command, as a plan does. A log may start late, stop
    early, or last longer."""


def logged(context: Context) -> Execution:
    """Return the execution of a context's own log."""
    start, log = start_state(context), recorded(context)
    end = replayed(context, context) or start
    track = log.agent.trajectory
    loads = moved(log) | ({end.held} if end.held else set())
    carried = [_of_log(o, track.t, start, end) for o in log.objects if o.id in loads]
    return Execution(start, end, np.column_stack((track.xyz[:, :2], track.yaw)), _in_order(carried))


def planned(context: Context, actions: Sequence[Action]) -> Execution:
    """Return the execution of a plan in a context's start state."""
    start = state = start_state(context)
    ways = [start.pose[None]]
    lifted: dict[str, int] = {} if start.held is None else {start.held: 0}
    lowered: dict[str, int | None] = {}
    for action in actions:
        motion = move(state, [action])
        before = sum(len(way) for way in ways)
        ways.append(np.column_stack((motion.xyz[0, :, :2], motion.yaw[0])))
        held, state = state.held, result(state, action, motion, 0)
        for load in {action.object_id, held or ""} - {""}:
            if action.kind.takes:
                lifted.setdefault(load, before)
            lowered[load] = None if state.held == load else before + len(ways[-1]) - 1
    carried = [Carried(load, lifted[load], lowered.get(load)) for load in lifted]
    return Execution(start, state, np.concatenate(ways), _in_order(carried), whole=True)


def _in_order(carried: Sequence[Carried]) -> tuple[Carried, ...]:
    return tuple(sorted(carried, key=lambda c: (c.lifted, c.id)))


def _of_log(thing: PhysicalObject, t: FloatArray, start: State, end: State) -> Carried:
    track = thing.trajectory
    away = np.linalg.norm(track.xyz - track.xyz[0], axis=1) > LEAVES_M
    back = np.linalg.norm(track.xyz - track.xyz[-1], axis=1) > LEAVES_M
    first = float(track.t[np.argmax(away)]) if thing.id != start.held else float(t[0])
    last = float(track.t[len(back) - 1 - np.argmax(back[::-1])])
    row = np.clip(np.searchsorted(t, [first, last]), 0, len(t) - 1)
    lowered = None if thing.id == end.held else int(row[1])
    return Carried(thing.id, int(row[0]), lowered)


def replayed(world: Context, shown: Context) -> State | None:
    """Return the state of a world after the log of another world, or its own.

    The things that the log moves, and the robot, end where the log has them end; all others stay
    where they are in the world. Both must be maps of the same site.
    None if the log moves something that isn't in the world.
    """
    start, log = start_state(world), recorded(shown)
    same = counterparts(shown, world)
    held = _held_at_end(shown)
    carried = moved(log) | ({held} if held else frozenset())
    if not carried <= same.keys():
        return None
    ends = {o.id: o for o in log.objects if o.id in carried}
    placed = {same[key]: _at_end(start.thing(same[key]), thing) for key, thing in ends.items()}
    placed[world.agent_id] = _at_end(start.context.agent, log.agent)
    return with_moved(start, placed, same[held] if held else None)


def counterparts(one: Context, other: Context) -> dict[str, str]:
    """Map objects of one context to another's: same labels, nearest starts overall.

    Ids don't correspond where the logs were recorded at different times.
    """
    matches: dict[str, str] = {}
    kinds = {o.labels for o in one.objects if o.id != one.agent_id}
    for labels in sorted(kinds):
        mine = [o for o in one.objects if o.labels == labels and o.id != one.agent_id]
        theirs = [o for o in other.objects if o.labels == labels and o.id != other.agent_id]
        ends = (np.array([centre(o.prism) for o in objects]) for objects in (mine, theirs))
        if theirs:
            here, there = ends
            apart = np.linalg.norm(here[:, None] - there[None], axis=-1)
            for i, j in zip(*linear_sum_assignment(apart), strict=True):
                matches[mine[i].id] = theirs[j].id
    return matches


def _held_at_end(shown: Context) -> str | None:
    """Return the id of the load on the forks when a log ends."""
    log = recorded(shown)
    held = loaded(shown)
    end = log.agent.trajectory.xyz[-1, :2]
    near = [
        o.id
        for o in log.objects
        if (o.id in moved(log) or o.id == held)
        and float(np.linalg.norm(o.trajectory.xyz[-1, :2] - end)) <= RELEASED_M
    ]
    return near[0] if near else None


def _at_end(thing: PhysicalObject, logged: PhysicalObject) -> PhysicalObject:
    track = logged.trajectory
    pose = np.array([*track.xyz[-1, :2], track.yaw[-1]])
    rise = float(track.xyz[-1, 2] - track.xyz[0, 2])
    return moved_to(thing, pose, logged.prism.z_min + rise)
