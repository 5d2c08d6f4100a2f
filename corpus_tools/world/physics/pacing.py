"""Timing of the robot's ways: speeds and accelerations within limits."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from corpus_tools.world.planning.curves import Way, poses_on
from g3.groundings import FloatArray
from g3.short_repr import short_repr


@dataclass(frozen=True, slots=True)
class Pace:
    """Largest speed, and the acceleration up to it."""

    speed: float
    acceleration: float


@short_repr
@dataclass(frozen=True, slots=True)
class Limits:
    """Paces of the robot: in m/s and m/s², and on the spot in rad/s and rad/s²."""

    drive: Pace
    turn: Pace


EMPTY = Limits(Pace(2.0, 1.0), Pace(1.0, 1.2))
LOADED = Limits(Pace(1.7, 0.7), Pace(0.8, 0.7))
CAREFUL = Limits(Pace(0.7, 0.5), Pace(0.3, 0.3))
LIFT = Pace(0.45, 0.6)

SMOOTH_S = 0.4
"""Accelerations are spread over this long."""

_SPACING_M, _ANGLE = 0.02, 0.01


def references(start: FloatArray, way: Way, limits: Limits, timestep_s: float) -> FloatArray:
    """Return poses (n, 3) of a way at every timestep, stopping where the direction changes."""
    legs, pose = [], start
    for _, motions in groupby(
        way, key=lambda motion: math.copysign(1, motion[0]) * bool(motion[0])
    ):
        leg = poses_on(pose, tuple(motions), _SPACING_M, _ANGLE)
        legs.append(_paced(leg, limits, timestep_s))
        pose = leg[-1]
    return np.concatenate(legs) if legs else start[None]


def ramp(start: float, end: float, pace: Pace, timestep_s: float) -> FloatArray:
    """Return values (n,) from one to another at every timestep."""
    along = np.linspace(0, abs(end - start), max(math.ceil(abs(end - start) / 0.005), 1) + 1)
    moved = _at_timesteps(along, np.full(len(along), pace.speed), pace.acceleration, timestep_s)
    return _smooth(start + math.copysign(1, end - start) * moved[:, None], timestep_s)[:, 0]


def _paced(leg: FloatArray, limits: Limits, timestep_s: float) -> FloatArray:
    step = np.hypot(*np.diff(leg[:, :2], axis=0).T)
    turn = np.abs(np.diff(leg[:, 2]))
    pace = limits.drive
    if step.sum() < 1e-9:
        step, turn, pace = turn, np.zeros(len(turn)), limits.turn
    bend = turn / np.maximum(step, 1e-9)
    speed = np.minimum(pace.speed, limits.turn.speed / np.maximum(bend, 1e-9))
    at_nodes = np.minimum(np.append(speed, np.inf), np.insert(speed, 0, np.inf))
    along = np.insert(np.cumsum(step), 0, 0.0)
    moved = _at_timesteps(along, at_nodes, pace.acceleration, timestep_s)
    poses = np.column_stack([np.interp(moved, along, leg[:, i]) for i in range(3)])
    return _smooth(poses, timestep_s)


def _at_timesteps(
    along: FloatArray, limit: FloatArray, acceleration: float, timestep_s: float
) -> FloatArray:
    """Return the distance covered at every timestep, starting and ending at rest.

    `along` are points of the way, shape (n,), `limit` the highest speeds there.
    """
    if len(along) == 2:
        # Between rest and rest there must be a point at which it moves.
        along, limit = np.insert(along, 1, along.mean()), np.insert(limit, 1, limit.max())
    gained = 2 * acceleration * np.diff(along)
    square = limit**2
    square[0] = square[-1] = 0.0
    for i in range(len(gained)):
        square[i + 1] = min(square[i + 1], square[i] + gained[i])
    for i in reversed(range(len(gained))):
        square[i] = min(square[i], square[i + 1] + gained[i])
    speed = np.sqrt(square)
    t = np.insert(np.cumsum(2 * np.diff(along) / np.maximum(speed[1:] + speed[:-1], 1e-6)), 0, 0.0)
    times = np.arange(math.ceil(t[-1] / timestep_s) + 1) * timestep_s
    return np.interp(times, t, along)


def _smooth(values: FloatArray, timestep_s: float) -> FloatArray:
    """Return a moving average of rows with a smooth window; first and last values stay."""
    half = max(round(SMOOTH_S / 2 / timestep_s), 1)
    window = np.hanning(2 * half + 3)[1:-1]
    window /= window.sum()
    padded = np.pad(values, ((2 * half, 2 * half), (0, 0)), mode="edge")
    rows = [np.convolve(column, window, mode="valid") for column in padded.T]
    return np.column_stack(rows)
