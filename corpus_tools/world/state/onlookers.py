"""People in a recording, who look at the robot, step aside for it and come back.

They are no part of the simulation: their motion is added to what it recorded. Films and the logs
beside them are made of the same recording, so a log has every step of theirs.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from corpus_tools.world.state.recording import Recording, heading, upright
from corpus_tools.world.state.shapes import shape_of
from corpus_tools.world.state.thing_kinds import PERSON, kind_of
from g3.geometry.plane import rotate, wrap
from g3.groundings import FloatArray

LOOK_M = 12.0
"""Distance to the robot within which people look at it, in metres."""
WALKS = 0.1
"""Speed from which people look where they go, in m/s."""
TURN_RATE, TURN_S = 1.5, 0.5
"""Fastest turn of people, in radians a second, and the time in which they close in on it."""
NEAR_M = 1.8
"""Distance to the robot within which people step aside, in metres."""
ASIDE_M = 0.6
"""Length of the way aside."""
WALK_S = 1.4
"""Time that the way aside takes."""
FREE_M = 0.45
"""Least distance of a person's middle to other things, in metres."""


def with_onlookers(recording: Recording) -> Recording:
    """Return a recording in which people watch the robot.

    Everything else stays as it is. People begin and end at their own place, so that nothing has
    moved from where it was. Those who have no room to step aside, or who move already, stay.
    """
    start = recording.start
    robot = [item.id for item in start.objects].index(start.agent_id)
    position, orientation = recording.position.copy(), recording.orientation.copy()
    for i, item in enumerate(start.objects):
        still = (recording.position[:, i] == recording.position[0, i]).all()
        if kind_of(item.labels) is not PERSON or not still:
            continue
        aside = _aside(recording, i, robot)
        position[:, i, :2] += aside
        yaw = _gaze(recording, position[:, i, :2], heading(orientation[:, i]), robot)
        orientation[:, i] = upright(yaw)
    return replace(recording, position=position, orientation=orientation)


def _gaze(recording: Recording, place: FloatArray, yaw: FloatArray, robot: int) -> FloatArray:
    """Return the headings (n,) of a person at places (n, 2).

    The person looks where the way leads while walking, and else to a robot that is near.
    """
    towards = recording.position[:, robot, :2] - place
    near = np.linalg.norm(towards, axis=1) < LOOK_M
    if len(place) > 1:
        step = np.gradient(place, recording.t_s, axis=0)
        walks = np.linalg.norm(step, axis=1) > WALKS
        towards[walks], near[walks] = step[walks], True
    wanted = np.where(near, np.arctan2(towards[:, 1], towards[:, 0]), yaw)
    gaze: FloatArray = yaw.copy()
    for k, step_s in enumerate(np.diff(recording.t_s), start=1):
        turn = float(wrap(wanted[k] - gaze[k - 1])) * min(1.0, step_s / TURN_S)
        gaze[k] = gaze[k - 1] + np.clip(turn, -TURN_RATE * step_s, TURN_RATE * step_s)
    return gaze


def _aside(recording: Recording, person: int, robot: int) -> FloatArray:
    """Return how far a person steps aside at each moment, (n, 2), from the first place."""
    t = recording.t_s
    place = recording.position[0, person, :2]
    nothing = np.zeros((len(t), 2))
    gap = _gaps(recording, robot, place)
    closest = int(np.argmin(gap))
    away = place - recording.position[closest, robot, :2]
    if not 0 < gap[closest] < NEAR_M:
        return nothing
    # Aside is square to where the robot is heading, on the person's own side.
    yaw = heading(recording.orientation[closest, robot])
    aside = np.array([-np.sin(yaw), np.cos(yaw)])
    aside *= np.sign(aside @ away) or 1.0
    there = place + ASIDE_M * aside
    others = [j for j in range(len(recording.start.objects)) if j not in (person, robot)]
    is_free = all(_gaps(recording, j, there).min() > FREE_M for j in others)
    if not is_free or (_gaps(recording, robot, there) < np.minimum(gap, NEAR_M)).any():
        return nothing
    calls = np.flatnonzero(gap < NEAR_M)
    leaves, returns = t[calls[0]] - WALK_S, t[calls[-1]]
    leaves = max(leaves, 0.0)
    returns = min(returns, t[-1] - WALK_S)
    if returns < leaves + WALK_S:
        return nothing
    share = _eased((t - leaves) / WALK_S) - _eased((t - returns) / WALK_S)
    way: FloatArray = ASIDE_M * share[:, None] * aside
    return way


def _eased(x: FloatArray) -> FloatArray:
    """Return a smooth step from 0 to 1 (n,) for x from 0 to 1."""
    x = np.clip(x, 0.0, 1.0)
    eased: FloatArray = x * x * (3 - 2 * x)
    return eased


def _gaps(recording: Recording, thing: int, place: FloatArray) -> FloatArray:
    """Return the distances of a place (2,) from a thing's box at all moments, (n,)."""
    shape = shape_of(recording.start.objects[thing])
    yaw = heading(recording.orientation[:, thing])
    local = rotate(place - recording.position[:, thing, :2], -yaw)
    beyond = np.maximum(np.maximum(shape.low[:2] - local, local - shape.high[:2]), 0.0)
    gaps: FloatArray = np.linalg.norm(beyond, axis=1)
    return gaps
