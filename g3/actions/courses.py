"""Courses of candidate actions: the poses that they drive to, one after the other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from g3.geometry.plane import IntArray, length, rotate, wrap
from g3.groundings import FloatArray
from g3.short_repr import short_repr

TURNING_RADIUS_M = 2.0
CUSP_COST_M = 2.0
TIGHT_COST_M = 6.0


def quarters(yaw: FloatArray | float) -> FloatArray:
    """Return the four headings along and across headings (...); shape (..., 4)."""
    result: FloatArray = np.asarray(yaw)[..., None] + np.pi / 2 * np.arange(4)
    return result


def direction(yaw: FloatArray) -> FloatArray:
    """Return unit vectors (..., 2) of headings (...)."""
    return np.stack((np.cos(yaw), np.sin(yaw)), axis=-1)


def arc(
    start: FloatArray, length: FloatArray, turn: FloatArray, fraction: FloatArray
) -> FloatArray:
    """Poses (..., T, 3) on circular arcs from poses (..., 3).

    Parameters
    ----------
    length
        Metres along the arc, negative backwards; shape (...).
    turn
        Radians that the heading changes by, shape (...).
    fraction
        Parts of the arc, shape (T,).
    """
    part = np.asarray(turn)[..., None] * fraction
    chord = np.asarray(length)[..., None] * fraction * np.sinc(part / (2 * np.pi))
    xy = start[..., None, :2] + chord[..., None] * direction(start[..., None, 2] + part / 2)
    return np.concatenate((xy, (start[..., None, 2] + part)[..., None]), axis=-1)


def curve(start: FloatArray, goal: FloatArray, u: FloatArray) -> FloatArray:
    """Cubic Hermite curves driven forwards: poses (..., T, 3) at parameters u (T,)."""
    # Coordinates come first and points last: steps along a last axis of two are slow.
    p, q = (np.moveaxis(pose[..., :2], -1, 0)[..., None] for pose in (start, goal))
    distance = np.linalg.norm(q - p, axis=0)
    m, n = (
        distance * np.stack((np.cos(pose[..., 2]), np.sin(pose[..., 2])))[..., None]
        for pose in (start, goal)
    )
    xy = (
        (2 * u**3 - 3 * u**2 + 1) * p
        + (u**3 - 2 * u**2 + u) * m
        + (3 * u**2 - 2 * u**3) * q
        + (u**3 - u**2) * n
    )
    slope = (6 * u**2 - 6 * u) * (p - q) + (3 * u**2 - 4 * u + 1) * m + (3 * u**2 - 2 * u) * n
    yaw = np.arctan2(slope[1], slope[0])
    turn = wrap(goal[..., 2] - start[..., 2])[..., None]
    yaw = np.where(distance < 1e-6, start[..., 2, None] + u * turn, yaw)
    # Headings go on from the start's, without jumps of a full turn.
    onward = wrap(yaw[..., :1] - start[..., 2, None])
    yaw = start[..., 2, None] + onward + np.unwrap(yaw, axis=-1) - yaw[..., :1]
    return np.stack((*xy, yaw), axis=-1)


def clear_cost(poses: FloatArray) -> FloatArray:
    """Costs of legs (n, T, 3) where nothing is in the way, in metres."""
    step = length(poses[:, 1:, :2] - poses[:, :-1, :2])
    turn = np.abs(np.diff(poses[..., 2], axis=1))
    tight = np.maximum(turn - step / TURNING_RADIUS_M, 0).sum(axis=1)
    cost: FloatArray = step.sum(axis=1) + TIGHT_COST_M * tight
    return cost


RUN_IN_M = 2.5
"""Length of the straight way into a load."""
BLOCKED_COST_M = 20.0
CLEAR_M = 1.6
"""Entering past the middle of another thing nearer than this is as good as blocked."""


@short_repr
@dataclass(frozen=True, slots=True)
class Stops:
    """Next stops of n actions, each the cheapest of h poses.

    Parameters
    ----------
    finals
        The poses, shape (n, h, 3).
    penalty
        Extra cost of each in metres, infinite for one that isn't there, shape (n, h). Actions that
        have none stay where they are.
    run_in, out
        Distances that the pose is entered straight ahead, and backed out of, in metres; shape (n,).
    """

    finals: FloatArray
    penalty: FloatArray
    run_in: FloatArray
    out: FloatArray


NEVER = -1


@short_repr
@dataclass(frozen=True, slots=True)
class Course:
    """Successive stops of n actions.

    Parameters
    ----------
    lead
        Poses x, y, yaw to begin with, shape (n, m, 3).
    load
        Ids of what they move, empty for nothing.
    stops
        Poses that they drive to then.
    grip, drop
        At which of the stops the load is gripped, NEVER for one that is on the forks already, and
        at which it is let go of; shape (n,).
    down
        Height at which it is put down, over that of the grip, in metres, shape (n,).
    lift
        Height that a load already on the forks goes up at first, in metres, shape (n,).
    """

    lead: FloatArray
    load: tuple[str, ...]
    stops: tuple[Stops, ...]
    grip: IntArray
    drop: IntArray
    down: FloatArray
    lift: FloatArray


def course(
    lead: FloatArray,
    load: Sequence[str],
    *stops: Stops,
    grip: int = NEVER,
    drop: int = NEVER,
    down: FloatArray | float = 0.0,
    lift: FloatArray | float = 0.0,
) -> Course:
    """Make a course of n actions of one kind; parameters as of :class:`Course`."""
    n = len(lead)
    return Course(
        lead,
        tuple(load),
        stops,
        np.full(n, grip),
        np.full(n, drop),
        np.broadcast_to(down, n),
        np.broadcast_to(lift, n),
    )


def stops(
    finals: FloatArray, penalty: FloatArray | None = None, *, run_in: float = 0.0, out: float = 0.0
) -> Stops:
    """Make stops that are all entered and left alike; parameters as of :class:`Stops`."""
    n, h = finals.shape[:2]
    free = np.zeros((n, h)) if penalty is None else penalty
    return Stops(finals, free, np.full(n, run_in), np.full(n, out))


def join_courses(parts: Sequence[Course]) -> Course:
    """Courses one after another."""
    longest = max(part.lead.shape[1] for part in parts)
    most = max(len(part.stops) for part in parts)
    return Course(
        np.concatenate([_longer(part.lead, longest) for part in parts]),
        tuple(i for part in parts for i in part.load),
        tuple(_join_stops(parts, number) for number in range(most)),
        *(
            np.concatenate([getattr(p, name) for p in parts])
            for name in ("grip", "drop", "down", "lift")
        ),
    )


def _longer(poses: FloatArray, length: int) -> FloatArray:
    """Poses (n, m, 3) with the last one repeated."""
    missing = length - poses.shape[1]
    return np.concatenate((poses, np.repeat(poses[:, -1:], missing, axis=1)), axis=1)


def _join_stops(parts: Sequence[Course], number: int) -> Stops:
    """Return the stops with a number; courses that have fewer stay in place."""
    stops = [part.stops[number] if number < len(part.stops) else None for part in parts]
    n = sum(len(part.lead) for part in parts)
    most = max(stop.penalty.shape[1] for stop in stops if stop)
    joined = Stops(np.zeros((n, most, 3)), np.full((n, most), np.inf), np.zeros(n), np.zeros(n))
    row = 0
    for part, stop in zip(parts, stops, strict=True):
        if stop:
            rows = slice(row, row + len(part.lead))
            h = stop.penalty.shape[1]
            joined.finals[rows, :h], joined.penalty[rows, :h] = stop.finals, stop.penalty
            joined.run_in[rows], joined.out[rows] = stop.run_in, stop.out
        row += len(part.lead)
    return joined


def entries(
    middle: FloatArray, headings: FloatArray, reach: FloatArray, things: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Poses in which a load is gripped or put down, and what entering them costs.

    Parameters
    ----------
    middle
        The load's middle then, shape (n, 2).
    headings
        Headings of the robot, shape (n, h).
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
    is_load = np.linalg.norm(middle[:, None] - things, axis=-1) < 0.5
    apart = np.where(is_load[:, None, None], np.inf, apart)
    return finals, BLOCKED_COST_M * (apart.min(axis=(2, 3)) < CLEAR_M)
