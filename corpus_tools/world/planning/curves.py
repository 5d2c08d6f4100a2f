"""Curves that a vehicle drives: arcs, straights, and turns on the spot.

A motion is metres along an arc, negative backwards, and the turn meanwhile in radians; one
without length is a turn on the spot. Poses are x, y, yaw.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeAlias

import numpy as np

from g3.actions.courses import arc
from g3.groundings import FloatArray

Motion: TypeAlias = tuple[float, float]
Way: TypeAlias = tuple[Motion, ...]

STOP_COST_M = 1.2
"""Cost of a stop between two motions, to go on in the other direction or to turn, in metres."""
BACKWARDS_COST = 0.6
"""Additional cost of a metre backwards."""
SPIN_COST_M = 0.8
"""Cost of a radian on the spot, in metres."""

_LENGTH_M, _ANGLE = 0.15, 0.1


def end_of(pose: FloatArray, motion: Motion) -> FloatArray:
    """Return the pose at the end of a motion."""
    length, turn = motion
    half = pose[2] + turn / 2
    chord = length * (math.sin(turn / 2) / (turn / 2) if abs(turn) > 1e-9 else 1.0)
    return np.array(
        [pose[0] + chord * math.cos(half), pose[1] + chord * math.sin(half), pose[2] + turn]
    )


def poses_on(
    start: FloatArray, way: Way, spacing_m: float = _LENGTH_M, spacing: float = _ANGLE
) -> FloatArray:
    """Return poses (n, 3) on a way with both ends, at most so many metres and radians apart."""
    legs, pose = [start[None]], start
    for length, turn in way:
        n = max(math.ceil(abs(length) / spacing_m), math.ceil(abs(turn) / spacing), 1)
        leg = arc(pose, np.array(length), np.array(turn), np.arange(1, n + 1) / n)
        legs.append(leg)
        pose = leg[-1]
    return np.concatenate(legs)


def cost_of(way: Way) -> float:
    """Return the cost of a way where there is room, in metres."""
    cost, before = 0.0, None
    for length, turn in way:
        gear = (length > 0) - (length < 0)
        if before is not None and gear != before:
            cost += STOP_COST_M
        cost += length if gear > 0 else -length * (1 + BACKWARDS_COST)
        if gear == 0:
            cost += SPIN_COST_M * abs(turn)
        before = gear
    return cost


def turn_go_turn(start: FloatArray, goal: FloatArray) -> Way:
    """Turn towards the goal, drive straight there, turn to its heading."""
    dx, dy = goal[0] - start[0], goal[1] - start[1]
    length = math.hypot(dx, dy)
    yaw = math.atan2(dy, dx) if length > 1e-9 else float(start[2])
    motions = (0.0, _turn(yaw - start[2])), (length, 0.0), (0.0, _turn(goal[2] - yaw))
    return _driven(motions)


def dubins(start: FloatArray, goal: FloatArray, radius: float) -> Way | None:
    """Return the shortest curve forwards of an arc, a straight and an arc [1]_.

    Parameters
    ----------
    radius
        Of the arcs, in metres.

    References
    ----------
    .. [1] L. E. Dubins, "On curves of minimal length with a constraint on average curvature",
       American Journal of Mathematics 79(3), 1957.
    """
    best: Way | None = None
    shortest = math.inf
    for first in (1, -1):
        for last in (1, -1):
            way = _arc_straight_arc(start, goal, radius, first, last)
            if way is None:
                continue
            length = sum(motion[0] for motion in way)
            if length < shortest - 1e-9:
                best, shortest = way, length
    return best


def _arc_straight_arc(
    start: FloatArray, goal: FloatArray, radius: float, first: int, last: int
) -> Way | None:
    """Return arcs to the left (1) or right (-1), with a straight tangent between them."""
    ax, ay = _centre(start, first * radius)
    bx, by = _centre(goal, last * radius)
    dx, dy = bx - ax, by - ay
    apart = math.hypot(dx, dy)
    across = (last - first) * radius
    if apart < abs(across):
        return None
    # The tangent starts `first * radius` to the right of one centre and ends `last * radius`
    # to the right of the other.
    yaw = math.atan2(dy, dx) - math.asin(across / apart if apart > 0 else 0.0)
    straight = math.sqrt(max(apart**2 - across**2, 0.0))
    one = _around(yaw - start[2], first)
    two = _around(goal[2] - yaw, last)
    return _driven(((radius * abs(one), one), (straight, 0.0), (radius * abs(two), two)))


def _centre(pose: FloatArray, left: float) -> tuple[float, float]:
    return pose[0] - left * math.sin(pose[2]), pose[1] + left * math.cos(pose[2])


def _around(angle: float, side: int) -> float:
    """Turn an angle to one side only; a full turn by rounding is none."""
    turn = (side * angle) % (2 * math.pi)
    return side * (0.0 if turn > 2 * math.pi - 1e-6 else turn)


def _turn(angle: float) -> float:
    return (angle + math.pi) % (2 * math.pi) - math.pi


def _driven(motions: Sequence[Motion]) -> Way:
    return tuple((float(m), float(t)) for m, t in motions if abs(m) > 1e-6 or abs(t) > 1e-6)
