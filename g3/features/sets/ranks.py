"""Rank of a thing among the other things of its scene: "furthest", "left-most"."""

from __future__ import annotations

from functools import partial

import numpy as np

from g3.features.bodies import IntArray
from g3.features.factor_batch import FactorBatch
from g3.features.feature_registry import Column, Columns, feature_set
from g3.geometry.plane import BoolArray, length, rotate
from g3.groundings import FloatArray
from g3.language.similarity.word_similarity import label_patterns

ORDERS = ("ahead", "leftward", "far")
"""Along the agent's starting heading, across it to the left, by distance from the agent."""

SAME_PLACE_M = 0.1
"""Things this close in an order share their rank."""

RANK_COLUMNS: Columns = tuple(
    Column(f"{order}.{rank}", "bool")
    for order in ORDERS
    for rank in ("first", "second", "middle", "second_last", "last")
)

BEARING_COLUMNS: Columns = (
    Column("ahead", "1", -1, 1, 6),
    Column("leftward", "1", -1, 1, 6),
    Column("among_peers.ahead", "1", -2, 2, 6),
    Column("among_peers.leftward", "1", -2, 2, 6),
)


def local_centres(batch: FactorBatch, index: IntArray) -> FloatArray:
    """Centres of bodies (n, ...) in the frame of the agent's start pose, shape (n, ..., 2)."""
    agent, shape = batch.agent, (*index.shape, 2)
    if len(index) and index.strides[0] == agent.strides[0] == 0:
        index, agent = index[:1], agent[:1]  # as at inference, where all rows have one scene
    centres = batch.bodies.centre[index]
    lead = (slice(None),) + (None,) * (index.ndim - 1)
    offset = centres - agent[:, :2][lead]
    local = rotate(offset, -np.broadcast_to(agent[:, 2][lead], index.shape))
    return np.broadcast_to(local, shape)


def peer_centres(batch: FactorBatch) -> FloatArray:
    """Centres of the context's objects, in the frame of the agent's start pose, (n, p, 2)."""
    return local_centres(batch, batch.peers)


def _peers(batch: FactorBatch) -> tuple[FloatArray, BoolArray]:
    """Centres of the context's objects that share the figure's labels (n, p, 2), and which."""
    _, pattern = label_patterns(batch.bodies.labels)
    same = pattern[batch.peers] == pattern[batch.figure][:, None]
    return batch.once(peer_centres, peer_centres), same & (batch.peers >= 0)


rank_set = partial(feature_set, roles=("figure",), words=("figure", "relation"), wordless=True)


@rank_set("ranks", types=("OBJECT",), columns=RANK_COLUMNS, scale=0.2)
def ranks(batch: FactorBatch) -> FloatArray:
    """Rank among the scene's things with the same labels, seen from the agent's start."""
    centres, peer = batch.once(_peers, _peers)
    local = local_centres(batch, batch.figure)
    columns = []
    for own_value, values in zip(_orders(local), _orders(centres), strict=True):
        before = (peer & (values < own_value[:, None] - SAME_PLACE_M)).sum(axis=1)
        after = (peer & (values > own_value[:, None] + SAME_PLACE_M)).sum(axis=1)
        several = np.asarray(before + after > 0)
        columns += [
            several & (before == 0),
            several & (before == 1),
            np.asarray(before > 0) & (after > 0),
            several & (after == 1),
            several & (after == 0),
        ]
    table = np.column_stack(columns).astype(float)
    table[is_robot(batch)] = np.nan
    return table


def is_member(batch: FactorBatch) -> BoolArray:
    """Check that each row's figure is one of its landmark's several things; shape (n,)."""
    several = (batch.landmark >= 0) & (batch.bodies.count[batch.landmark] > 1)
    members = batch.bodies.members[batch.landmark]
    away = np.linalg.norm(members - batch.bodies.centre[batch.figure][:, None], axis=-1)
    result: BoolArray = several & (away < SAME_PLACE_M).any(axis=1)
    return result


def is_robot(batch: FactorBatch) -> BoolArray:
    """Check that the figure is a robot like the context's own, shape (n,).

    Where the robot is seen from the robot means nothing; and a random robot from another
    log is never where the command's own robot is, so it would give such negatives away.
    """
    labels = batch.bodies.shared_labels
    robot_labels = labels[batch.agent_body]
    same: BoolArray = (labels[batch.figure] == robot_labels).all(axis=1) & robot_labels.any(axis=1)
    return same


def _orders(local: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    return local[..., 0], local[..., 1], length(local)


@rank_set(
    "bearing",
    types=("OBJECT", "PLACE"),
    columns=BEARING_COLUMNS,
    scale=0.3,
    optional=("PLACE",),
)
def bearing(batch: FactorBatch) -> FloatArray:
    """Direction of the figure from the agent's start, absolute and among its peers."""
    local = local_centres(batch, batch.figure)
    unit = local / np.maximum(length(local), 1e-9)[:, None]
    centres, peer = batch.once(_peers, _peers)
    weight = peer / np.maximum(peer.sum(axis=1), 1)[:, None]
    mean = np.einsum("np,npc->nc", weight, centres)
    offset = centres - mean[:, None]
    spread = np.sqrt(np.einsum("np,npc,npc->n", weight, offset, offset))
    relative = (local - mean) / np.maximum(spread, 0.5)[:, None]
    relative[~peer.any(axis=1)] = np.nan
    table = np.column_stack((unit, relative))
    table[is_robot(batch)] = np.nan
    return table
