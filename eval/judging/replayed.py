"""What the log of one video would lead to in the world of another."""

from __future__ import annotations

import numpy as np
from scipy.optimize import linear_sum_assignment

from g3.actions.logged_actions import RELEASED_M, loaded, moved, recorded
from g3.actions.robot_state import State, moved_to, start_state, with_moved
from g3.geometry.footprints import centre
from g3.groundings import Context, PhysicalObject


def replayed(world: Context, shown: Context) -> State | None:
    """The state of a world after the log of another one, or its own, has happened in it.

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
    """Which object of another context is which of one: same labels, starting nearest in all.

    Their ids say nothing where the logs were recorded at different times.
    """
    found: dict[str, str] = {}
    kinds = {o.labels for o in one.objects if o.id != one.agent_id}
    for labels in sorted(kinds):
        mine = [o for o in one.objects if o.labels == labels and o.id != one.agent_id]
        theirs = [o for o in other.objects if o.labels == labels and o.id != other.agent_id]
        ends = (np.array([centre(o.prism) for o in objects]) for objects in (mine, theirs))
        if theirs:
            here, there = ends
            apart = np.linalg.norm(here[:, None] - there[None], axis=-1)
            for i, j in zip(*linear_sum_assignment(apart), strict=True):
                found[mine[i].id] = theirs[j].id
    return found


def _held_at_end(shown: Context) -> str | None:
    """What is on the forks when a log ends."""
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
