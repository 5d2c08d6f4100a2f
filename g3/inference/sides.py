"""What words single out among things alike: "the leftmost pallet", "the second from the right".

People turn to face what they speak of: the leftmost pallet of a row behind the robot is the
leftmost for who faces the row, not for who looks ahead and has it at the back. Of things all
around they speak as they stand.
"""

from __future__ import annotations

import numpy as np

from g3.features.batch import FactorBatch, WordField
from g3.features.named import named
from g3.features.order import DIRECTIONS, extents, ordinals, rivals
from g3.features.ranks import SAME_PLACE_M, is_robot, local_centres
from g3.geometry import BoolArray
from g3.groundings import FloatArray
from g3.language.concepts import CONCEPTS

MISPLACED = float(np.log(0.05))
"""What it costs that a thing isn't the one that words single out."""
ROW, NARROW, BEFORE_M = 3, 0.4, 2.0
"""So many things are a row if they spread no more across it, as a share of along it, and it runs
at least so far from the robot."""
ONE_SIDE = 0.2
"""Things lie on one side if no direction to them has a smaller cosine to the middle one."""
_FIELDS: tuple[WordField, ...] = ("figure", "relation")


def side_scores(batch: FactorBatch) -> FloatArray:
    """What it costs each row of a batch that its figure isn't the one singled out; shape (n,).

    Words do so that have no landmark but the robot. "The second from the left" isn't the leftmost,
    "the second on the left" is counted from there too, and on "the far left" it's the side that
    counts.
    """
    free = (batch.landmark < 0) | (batch.landmark == batch.agent_body)
    wanted = named(batch, ("figure",)) | (named(batch, _FIELDS) & free[:, None])
    direction = wanted[:, [CONCEPTS.index(c) for c in DIRECTIONS]]
    direction[:, DIRECTIONS.index("far")] |= wanted[:, CONCEPTS.index("last")]
    aside = direction[:, :4].any(axis=1)
    direction[:, 4:] &= ~aside[:, None]
    number = np.where(free, ordinals(batch, _FIELDS), ordinals(batch, ("figure",)))
    if not (np.any(direction) or np.any(number)):
        return np.zeros(len(batch))
    rival = rivals(batch)
    ahead = _further(batch, rival)
    first = (direction & (ahead > 0)).any(axis=1)
    counted = direction.copy()
    counted[:, DIRECTIONS.index("near")] |= ~aside
    other = ~(counted & (ahead == number[:, None] - 1)).any(axis=1)
    wrong = np.where(number > 0, other, first) & rival.any(axis=1)
    wrong &= ~is_robot(batch) & (batch.bodies.count[batch.figure] == 1)
    return np.where(wrong, MISPLACED, 0.0)


def _further(batch: FactorBatch, rival: BoolArray) -> FloatArray:
    """How many rivals are further in each direction for who faces all of them, (n, directions)."""
    own, others = local_centres(batch, batch.figure), local_centres(batch, batch.peers)
    faced = facing(own, others, rival)
    near = _extents(own, turned(own, faced))
    far = _extents(others, turned(others, faced[:, None]))
    further: BoolArray = rival[..., None] & (far > near[:, None] + SAME_PLACE_M)
    count: FloatArray = further.sum(axis=1, dtype=float)
    return count


def _extents(local: FloatArray, faced: FloatArray) -> FloatArray:
    """How far points lie in each direction; ahead is where the robot looks, not how far.

    Parameters
    ----------
    local, faced
        Points in the robot's frame and in that of who faces them, shape (..., 2).
    """
    extent = extents(faced)
    angle = np.arctan2(np.abs(local[..., 1]), local[..., 0])
    extent[..., DIRECTIONS.index("front")] = -angle
    extent[..., DIRECTIONS.index("back")] = angle
    return extent


def facing(own: FloatArray, others: FloatArray, rival: BoolArray) -> FloatArray:
    """Which way people look who speak of things, unit vectors in the robot's frame (n, 2).

    At a row straight on; else to the middle of things that lie on one side, or ahead.

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
    across, straight = _row(points, seen)
    chosen = np.where(aside[:, None], mean, np.array([1.0, 0.0]))
    return np.where(straight[:, None], across, chosen)


def _row(points: FloatArray, seen: BoolArray) -> tuple[FloatArray, BoolArray]:
    """Unit vectors from the robot straight at rows (n, 2), and whether the points are rows."""
    count = seen.sum(axis=1)
    weight = seen / count[:, None]
    middle = (points * weight[..., None]).sum(axis=1)
    offset = (points - middle[:, None]) * np.sqrt(weight)[..., None]
    spread, axes = np.linalg.eigh(np.swapaxes(offset, 1, 2) @ offset)
    across = axes[..., 0]
    away = (across * middle).sum(axis=1)
    row = (count >= ROW) & (spread[:, 0] < NARROW**2 * spread[:, 1]) & (np.abs(away) > BEFORE_M)
    return across * np.where(away < 0, -1.0, 1.0)[:, None], row


def turned(points: FloatArray, ahead: FloatArray) -> FloatArray:
    """Points (..., 2) in the frame of who looks along unit vectors (..., 2)."""
    forward = (points * ahead).sum(axis=-1)
    leftward = points[..., 1] * ahead[..., 0] - points[..., 0] * ahead[..., 1]
    return np.stack((forward, leftward), axis=-1)
