"""Ways for a vehicle that steers: arcs, smooth curves, and backing up where they are too tight.

Poses are rows x, y (metres), yaw (radians); obstacles are footprints as in
:mod:`g3.geometry.plane`. A way is a tuple of legs, and the vehicle stops between two legs to
change its direction. Everything is deterministic.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from g3.geometry.plane import length, point_gap, wrap
from g3.groundings import FloatArray

Way = tuple[FloatArray, ...]
"""Legs of a way, each dense poses (n, 3)."""

Obstacles = Sequence[FloatArray]
"""Footprints, each of shape (k, 2)."""

TURNING_RADIUS_M = 2.0
CLEARANCE_M = 1.3
"""How far the vehicle's middle keeps from obstacles where it can."""
NOSE_M = 1.1
"""The point this far ahead keeps clear of obstacles too: forks, and what is on them."""

CUSP_COST_M = 2.0
TIGHT_COST_M = 6.0
BUMP_COST = 10.0
BUMPED_M = 1.0
"""Collision cost from which on a detour is looked for."""

_STEP_M = 0.1
_CHUNK = 12
_REVERSES = np.array(
    [
        *((r, 0.0) for r in (0.0, 2.0, 4.0, 6.0)),
        *((r, s * a) for r, a in ((2.0, 0.8), (4.0, 1.2), (5.0, 1.7), (6.0, 2.4)) for s in (1, -1)),
    ]
)
"""Manoeuvres to begin with: metres backwards, and the turn meanwhile in radians."""
_STRETCHES = np.array([0.6, 1.0, 1.5])
_DETOURS_M = (-7.0, -4.0, 4.0, 7.0)


@dataclass(frozen=True, slots=True)
class Route:
    """A way and what it costs, in metres of clear road, and the goal it leads to."""

    way: Way
    cost: float
    bumps: float
    goal: FloatArray


def direction(yaw: FloatArray) -> FloatArray:
    """Unit vectors (..., 2) of headings (...)."""
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
        Which parts of the arc, shape (T,).
    """
    part = np.asarray(turn)[..., None] * fraction
    chord = np.asarray(length)[..., None] * fraction * np.sinc(part / (2 * np.pi))
    xy = start[..., None, :2] + chord[..., None] * direction(start[..., None, 2] + part / 2)
    return np.concatenate((xy, (start[..., None, 2] + part)[..., None]), axis=-1)


def straight(start: FloatArray, length: float) -> FloatArray:
    """One leg straight ahead, or straight back where the length is negative; (n, 3)."""
    return arc(start, np.array(length), np.array(0.0), _fractions(abs(length)))


def route(
    start: FloatArray, goals: FloatArray, obstacles: Obstacles, penalty: FloatArray | None = None
) -> Route:
    """The cheapest way from a pose to one of several.

    The way is a smooth curve, after backing up if the curve would be too tight or
    something is in the way, around a corner if that is needed. It costs its length,
    and more where it reverses, turns tightly or passes too close to an obstacle; it is
    found even where nothing is free.

    Parameters
    ----------
    start
        Pose, shape (3,).
    goals
        Poses, shape (g, 3).
    obstacles
        Footprints to keep away from.
    penalty
        What choosing each goal costs on top in metres, shape (g,).
    """
    best = _direct(start, goals, obstacles, penalty)
    if best.bumps < BUMPED_M:
        return best
    goal = best.goal[None]
    extra = 0.0
    if penalty is not None:
        extra = float(penalty[np.argmin(np.abs(goals - goal).sum(axis=1))])
    toward = goal[0, :2] - start[:2]
    yaw = np.arctan2(toward[1], toward[0])
    for side in _DETOURS_M:
        middle = (start[:2] + goal[0, :2]) / 2 + side * direction(np.array(yaw + np.pi / 2))
        first = _direct(start, np.array([[*middle, yaw]]), obstacles)
        second = _direct(first.way[-1][-1], goal, obstacles)
        cost = first.cost + second.cost + extra
        if cost < best.cost:
            bumps = first.bumps + second.bumps
            best = Route((*first.way, *second.way), cost, bumps, best.goal)
    return best


def _direct(
    start: FloatArray, goals: FloatArray, obstacles: Obstacles, penalty: FloatArray | None = None
) -> Route:
    """The cheapest of backing up in some way and one curve to some goal."""
    shape = len(goals), len(_REVERSES), len(_STRETCHES)
    back = arc(start[None], -_REVERSES[:, 0], _REVERSES[:, 1], np.linspace(0, 1, 13))
    begin = np.broadcast_to(back[None, :, -1, None], (*shape, 3)).reshape(-1, 3)
    end = np.broadcast_to(goals[:, None, None], (*shape, 3)).reshape(-1, 3)
    stretch = np.broadcast_to(_STRETCHES, shape).reshape(-1)
    ahead = curve(begin, end, stretch, np.linspace(0, 1, 41))
    extra = np.zeros(len(goals)) if penalty is None else penalty
    before = BUMP_COST * _bumps(back, obstacles) + CUSP_COST_M * (_REVERSES[:, 0] > 0)
    before += clear_cost(back)
    clear = clear_cost(ahead) + (
        before[:, None] + extra[:, None, None] + np.zeros(shape[2])
    ).reshape(-1)
    chosen, cost = _cheapest(clear, ahead, obstacles)
    i, j, n = np.unravel_index(chosen, shape)
    length, turned = _REVERSES[j]
    legs = [arc(start, -length, turned, _fractions(length))] if length > 0 else []
    fractions = _fractions(
        float(np.linalg.norm(np.diff(ahead[chosen, :, :2], axis=0), axis=1).sum())
    )
    legs.append(curve(legs[-1][-1] if legs else start, goals[i], _STRETCHES[n], fractions))
    bumps = sum(float(_bumps(leg[None], obstacles)[0]) for leg in legs)
    return Route(tuple(legs), cost, bumps, goals[i])


def _cheapest(clear: FloatArray, poses: FloatArray, obstacles: Obstacles) -> tuple[int, float]:
    """Index and cost of the cheapest leg; collisions of hopeless ones are not looked at."""
    order = np.argsort(clear, kind="stable")
    best, cost = int(order[0]), np.inf
    for first in range(0, len(order), _CHUNK):
        rows = order[first : first + _CHUNK]
        if clear[rows[0]] >= cost:
            break
        costs = clear[rows] + BUMP_COST * _bumps(poses[rows], obstacles)
        if costs.min() < cost:
            best, cost = int(rows[np.argmin(costs)]), float(costs.min())
    return best, cost


def curve(start: FloatArray, goal: FloatArray, stretch: FloatArray, u: FloatArray) -> FloatArray:
    """Cubic Hermite curves driven forwards: poses (..., T, 3) at parameters u (T,)."""
    # Coordinates come first and points last: steps along a last axis of two are slow.
    p, q = (np.moveaxis(pose[..., :2], -1, 0)[..., None] for pose in (start, goal))
    distance = np.linalg.norm(q - p, axis=0)
    pull = distance * np.asarray(stretch)[..., None]
    m, n = (
        pull * np.stack((np.cos(pose[..., 2]), np.sin(pose[..., 2])))[..., None]
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


def _bumps(poses: FloatArray, obstacles: Obstacles) -> FloatArray:
    """How deep and how far legs (n, T, 3) are too close to obstacles, in square metres."""
    step = np.linalg.norm(np.diff(poses[..., :2], axis=1), axis=2)
    nose = poses[..., :2] + NOSE_M * direction(poses[..., 2])
    points = np.stack((poses[..., :2], nose))
    bumps = np.zeros(len(poses))
    for footprint in obstacles:
        low, high = footprint.min(axis=0) - CLEARANCE_M, footprint.max(axis=0) + CLEARANCE_M
        near = ((points > low) & (points < high)).all(axis=-1).any(axis=(0, 2))
        if not near.any():
            continue
        some = points[:, near]
        gap = point_gap(some.reshape(1, -1, 2), footprint[None]).reshape(some.shape[:3])
        depth = np.maximum(CLEARANCE_M - gap, 0).sum(axis=0)
        bumps[near] += (depth[:, 1:] * step[near]).sum(axis=1)
    return bumps


def _fractions(length: float) -> FloatArray:
    return np.linspace(0, 1, max(int(np.ceil(length / _STEP_M)), 1) + 1)


def dock(
    start: FloatArray,
    finals: FloatArray,
    obstacles: Obstacles,
    *,
    around: Obstacles,
    run_in_m: float,
    penalty: FloatArray | None = None,
) -> Route:
    """The cheapest way to one of several poses that are entered straight ahead.

    Parameters
    ----------
    start, finals, penalty
        As for :func:`route`.
    obstacles
        Footprints to keep away from on the way.
    around
        Footprints to keep away from on the last metres.
    run_in_m
        How long the last leg is, which is straight.
    """
    entries = [straight(final, -run_in_m)[::-1] for final in finals]
    costs = BUMP_COST * _bumps(np.array(entries), around)
    before = np.array([entry[0] for entry in entries])
    found = route(start, before, obstacles, costs if penalty is None else costs + penalty)
    chosen = np.argmin(np.abs(before - found.goal).sum(axis=1))
    last = _turned_like(entries[chosen], found.way[-1])
    return Route((*found.way, last), found.cost, found.bumps, finals[chosen])


def _turned_like(leg: FloatArray, before: FloatArray) -> FloatArray:
    """A leg whose heading counts full turns as the leg before it does."""
    turns = np.round((before[-1, 2] - leg[0, 2]) / (2 * np.pi))
    turned: FloatArray = leg + np.array([0.0, 0.0, 2 * np.pi * turns])
    return turned
