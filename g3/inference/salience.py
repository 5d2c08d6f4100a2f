"""Which of several things alike is meant where words say no more than what kind it is.

"Next to the pallet" is at the one that is nearest to what goes there, "the lonely one" is furthest
from its like, and who swings left comes to the one on the left.
"""

from __future__ import annotations

import numpy as np

from g3.features.batch import FactorBatch
from g3.features.order import rivals
from g3.features.ranks import SAME_PLACE_M, is_robot, local_centres
from g3.groundings import FloatArray
from g3.inference.sides import MISPLACED
from g3.language.groups import noun_leaf
from g3.language.lexicon import ALONE, FARTHEST, NEAREST, SELVES
from g3.language.words import field_words
from g3.sdc import SDC, all_words

FARTHER = float(np.log(0.1))
"""What it costs that a thing alike is nearer to the load."""

OPPOSITE = 0.2
"""What lies on the other side than one that was told has a sine of its direction beyond this."""


def is_alone(sdc: SDC) -> bool:
    """Whether an OBJECT's own words say that it stands alone: "lonely", "by itself"."""
    own = field_words([*noun_leaf(sdc).words, *sdc.relation])
    marks = [word.text.lower() for mark in sdc.landmark1 for word in all_words(mark)]
    return bool(ALONE.intersection(own)) or bool(SELVES.intersection(marks))


def alone_scores(batch: FactorBatch, load: int | None) -> FloatArray:
    """What it costs each row's figure that another thing alike is further from all its like.

    Parameters
    ----------
    load
        A body that doesn't count, for it will stand elsewhere.
    """
    bodies, peers = batch.bodies, batch.peers
    alike = (bodies.labels[peers] & bodies.labels[batch.figure][:, None]).any(axis=2)
    alike &= (peers != batch.figure[:, None]) & (peers != load)
    body = np.column_stack((batch.figure, peers))
    seen = np.column_stack((batch.figure != load, alike))
    gap = np.linalg.norm(bodies.centre[body][:, :, None] - bodies.centre[body][:, None], axis=-1)
    both = seen[:, :, None] & seen[:, None] & ~np.eye(body.shape[1], dtype=bool)
    nearest = np.where(both, gap, np.inf).min(axis=2)
    nearest[np.isinf(nearest)] = -np.inf
    crowded = seen[:, 0] & (nearest[:, 0] < nearest.max(axis=1) - SAME_PLACE_M)
    return np.where(crowded, FARTHER, 0.0)


def superlative_scores(batch: FactorBatch) -> FloatArray:
    """What it costs each row's figure that another thing alike is nearer to its landmark.

    Where words say that it is the nearest, or that it is the farthest and another is farther.
    """
    relations = [words.get("relation", ()) for words in batch.words]
    sign = np.array(
        [float(bool(NEAREST.intersection(r))) - bool(FARTHEST.intersection(r)) for r in relations]
    )[batch.factor]
    told = (sign != 0) & (batch.landmark >= 0) & (batch.landmark != batch.agent_body)
    if not told.any():
        return np.zeros(len(batch))
    bodies = batch.bodies
    mark = bodies.centre[batch.landmark]
    own = np.linalg.norm(bodies.centre[batch.figure] - mark, axis=-1)
    others = np.linalg.norm(bodies.centre[batch.peers] - mark[:, None], axis=-1)
    rival = rivals(batch) & (batch.peers != batch.landmark[:, None])
    beaten = (rival & (sign[:, None] * (own[:, None] - others) > SAME_PLACE_M)).any(axis=1)
    return np.where(told & beaten & (bodies.count[batch.figure] == 1), 2 * MISPLACED, 0.0)


def side_told_scores(batch: FactorBatch, side: str) -> FloatArray:
    """What it costs each row's figure to lie on the other side than the robot is told to go to."""
    own = local_centres(batch, batch.figure)
    leftward = own[:, 1] / np.maximum(np.linalg.norm(own, axis=1), 1e-9)
    opposite = (leftward if side == "left" else -leftward) < -OPPOSITE
    return np.where(opposite & ~is_robot(batch), FARTHER, 0.0)


def near_scores(batch: FactorBatch, load: int) -> FloatArray:
    """What it costs each row's figure that another thing alike is nearer to the body ``load``."""
    labels = batch.bodies.labels
    alike = (labels[batch.peers] & labels[batch.figure][:, None]).any(axis=2)
    rival = rivals(batch) & alike & (batch.peers != load)
    middle = local_centres(batch, np.full(len(batch), load))
    own = np.linalg.norm(local_centres(batch, batch.figure) - middle, axis=-1)
    others = np.linalg.norm(local_centres(batch, batch.peers) - middle[:, None], axis=-1)
    farther = (rival & (others < own[:, None] - SAME_PLACE_M)).any(axis=1)
    farther &= (batch.bodies.count[batch.figure] == 1) & ~is_robot(batch)
    return np.where(farther, FARTHER, 0.0)
