"""How a vehicle that steers gets from pose to pose: arcs and smooth curves.

Poses are rows x, y (metres), yaw (radians). Everything is deterministic.
"""

from __future__ import annotations

import numpy as np

from g3.geometry.plane import length, wrap
from g3.groundings import FloatArray

TURNING_RADIUS_M = 2.0
CUSP_COST_M = 2.0
TIGHT_COST_M = 6.0


def quarters(yaw: FloatArray | float) -> FloatArray:
    """The four headings along and across headings (...); shape (..., 4)."""
    result: FloatArray = np.asarray(yaw)[..., None] + np.pi / 2 * np.arange(4)
    return result


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
