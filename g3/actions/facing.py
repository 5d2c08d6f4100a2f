"""Which way people look who speak of things alike: straight at a row, or at their middle."""

from __future__ import annotations

import numpy as np

from g3.geometry.plane import BoolArray
from g3.groundings import FloatArray

ROW, NARROW, BEFORE = 3, 0.4, 0.25
"""So many things are a row if they spread no more across it, as a share of along it. Who stands
before it is at least so far from its line, as a share of how far beyond its end."""
ONE_SIDE = 0.2
"""Things lie on one side if no direction to them has a smaller cosine to the middle one."""


def facing(own: FloatArray, others: FloatArray, rival: BoolArray) -> tuple[FloatArray, BoolArray]:
    """Which way people look who speak of things, unit vectors in the robot's frame (n, 2).

    At a row straight on; else to the middle of things that lie on one side, or ahead if they are
    all around: that is told too, shape (n,).

    Parameters
    ----------
    own
        Centres of the figures in the robot's frame, shape (n, 2).
    others, rival
        Centres of their peers (n, p, 2), and which of these are looked at too, shape (n, p).
    """
    points = np.concatenate((own[:, None], others), axis=1)
    seen = np.column_stack((np.ones(len(own), dtype=bool), rival))
    unit = points / np.maximum(np.linalg.norm(points, axis=-1, keepdims=True), 1e-9)
    mean = np.where(seen[..., None], unit, 0.0).sum(axis=1)
    length = np.linalg.norm(mean, axis=1, keepdims=True)
    mean = mean / np.maximum(length, 1e-9)
    cosine = np.where(seen, (unit * mean[:, None]).sum(axis=-1), 1.0).min(axis=1)
    aside = (cosine >= ONE_SIDE) & (length[:, 0] > 1e-6)
    across, straight = rows(points, seen)
    chosen = np.where(aside[:, None], mean, np.array([1.0, 0.0]))
    return np.where(straight[:, None], across, chosen), ~(straight | aside)


def lines(points: FloatArray, seen: BoolArray) -> tuple[FloatArray, FloatArray, BoolArray]:
    """The lines along which points spread most.

    Parameters
    ----------
    points, seen
        Shape (n, p, 2), and which of them count, shape (n, p).

    Returns
    -------
    middle, axes : FloatArray
        The points' middles (n, 2), and unit vectors across and along the lines in the columns of
        (n, 2, 2).
    straight : BoolArray
        Where the points are a row, shape (n,).
    """
    weight = seen / seen.sum(axis=1)[:, None]
    middle = (points * weight[..., None]).sum(axis=1)
    offset = (points - middle[:, None]) * np.sqrt(weight)[..., None]
    spread, axes = np.linalg.eigh(np.swapaxes(offset, 1, 2) @ offset)
    return middle, axes, (seen.sum(axis=1) >= ROW) & (spread[:, 0] < NARROW**2 * spread[:, 1])


def rows(points: FloatArray, seen: BoolArray) -> tuple[FloatArray, BoolArray]:
    """Unit vectors from the robot straight at rows (n, 2), and whether the points are rows.

    A row that the robot is in, or that it looks along, isn't faced.

    Parameters
    ----------
    points, seen
        In the robot's frame, shape (n, p, 2), and which of them are looked at, shape (n, p).
    """
    middle, axes, straight = lines(points, seen)
    across = axes[..., 0]
    offset = np.where(seen[..., None], points - middle[:, None], 0.0)
    thick, reach = np.abs(offset @ axes).max(axis=1).T
    away, along = (middle[:, None] @ axes)[:, 0].T
    beyond = np.maximum(np.abs(along) - reach, 0.0)
    straight &= np.abs(away) > np.maximum(thick, BEFORE * beyond)
    return across * np.where(away < 0, -1.0, 1.0)[:, None], straight


def turned(points: FloatArray, ahead: FloatArray) -> FloatArray:
    """Points (..., 2) in the frame of who looks along unit vectors (..., 2)."""
    forward = (points * ahead).sum(axis=-1)
    leftward = points[..., 1] * ahead[..., 0] - points[..., 0] * ahead[..., 1]
    return np.stack((forward, leftward), axis=-1)
