"""Places in line with a row of things: next to one of them, or at the row's end."""

from __future__ import annotations

import numpy as np

from g3.features.batch import FactorBatch
from g3.features.ranks import local_centres
from g3.geometry import BoolArray, cross
from g3.groundings import FloatArray
from g3.inference.facing import rows, turned
from g3.inference.sides import MISPLACED
from g3.language.concepts import concepts
from g3.language.lexicon import BETWEEN, ENDS, LATERAL

OFF_LINE = float(np.log(0.1))
"""What it costs a place not to go on with the line of what it is next to, or at the end of."""
OFF_LINE_M = 1.5
WIDE = 0.2
"""How far from the line between two things is between them, as a share of its length."""
ASTRAY = float(np.log(0.01))
"""What it costs a place not to be between the things that it is said to be between."""


def row_scores(batch: FactorBatch) -> FloatArray:
    """What it costs places (n,) to be out of line with their landmarks."""
    return _beside_one(batch) + _beyond_several(batch) + between_scores(batch)


def _beside_one(batch: FactorBatch) -> FloatArray:
    """Next to a thing in a row is in the row, neither before it nor behind it."""
    bodies, mark = batch.bodies, batch.landmark
    told = _named(batch, LATERAL) & ~_sided(batch) & (mark >= 0) & (mark != batch.agent_body)
    told &= bodies.count[mark] == 1
    if not told.any():
        return np.zeros(len(batch))
    middle, peers = local_centres(batch, mark), local_centres(batch, batch.peers)
    alike = (bodies.labels[batch.peers] == bodies.labels[mark][:, None]).all(axis=2)
    alike &= batch.peers != mark[:, None]
    points = np.concatenate((middle[:, None], peers), axis=1)
    across, straight = rows(points, np.column_stack((np.ones(len(batch), dtype=bool), alike)))
    off = turned(local_centres(batch, batch.figure) - middle, across)
    aside = np.abs(off[:, 0]) > np.abs(off[:, 1])
    return np.where(told & straight & aside, OFF_LINE, 0.0)


def _beyond_several(batch: FactorBatch) -> FloatArray:
    """At the end of several things, or left or right of them, is beyond them all and in line."""
    bodies, mark = batch.bodies, batch.landmark
    told = (_named(batch, ENDS) | _sided(batch)) & (mark >= 0) & (bodies.count[mark] > 1)
    if not told.any():
        return np.zeros(len(batch))
    members = bodies.members[mark]
    known = ~np.isnan(members).any(axis=-1, keepdims=True)
    middle = np.where(known, members, 0.0).sum(axis=1) / np.maximum(known.sum(axis=1), 1)
    offset = np.where(known, members - middle[:, None], 0.0)
    along = np.linalg.eigh(np.swapaxes(offset, 1, 2) @ offset)[1][..., 1]
    reach = np.abs((offset * along[:, None]).sum(axis=-1)).max(axis=1)
    away = bodies.centre[batch.figure] - middle
    among = np.abs((away * along).sum(axis=-1)) < reach
    aside = np.abs(cross(away, along)) > OFF_LINE_M
    cost = np.where(among, MISPLACED, 0.0) + np.where(aside, OFF_LINE, 0.0)
    return np.where(told, cost, 0.0)


def between_scores(batch: FactorBatch) -> FloatArray:
    """What it costs places (n,) not to be between the things that words say they are between."""
    bodies, mark = batch.bodies, batch.landmark
    told = _named(batch, BETWEEN) & (mark >= 0) & (mark != batch.agent_body)
    if not told.any():
        return np.zeros(len(batch))
    members = bodies.members[mark]
    one, other = np.triu_indices(members.shape[1], 1)
    way = members[:, other] - members[:, one]
    length = np.maximum(np.linalg.norm(way, axis=-1), 1e-9)
    off = bodies.centre[batch.figure][:, None] - members[:, one]
    along = (off * way).sum(axis=-1) / length**2
    aside = np.abs(cross(off, way)) / length
    among = (along > 0) & (along < 1) & (aside <= np.maximum(OFF_LINE_M, WIDE * length))
    return np.where(told & ~among.any(axis=1), ASTRAY, 0.0)


def _named(batch: FactorBatch, words: frozenset[str]) -> BoolArray:
    """Whether each row's relation has one of some words."""
    return np.array([bool(words.intersection(w.get("relation", ()))) for w in batch.words])[
        batch.factor
    ]


def _sided(batch: FactorBatch) -> BoolArray:
    """Whether each row's relation names the left or the right."""
    told = [bool({"left", "right"} & concepts(w.get("relation", ()))) for w in batch.words]
    return np.array(told)[batch.factor]
