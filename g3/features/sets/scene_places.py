"""Situation of a place in the scene: support, neighbours, freedom."""

from __future__ import annotations

import numpy as np

from g3.features.factor_batch import FactorBatch
from g3.features.feature_registry import Column, feature_set
from g3.features.sets.prisms import PRISM_COLUMNS, prism_pair, size
from g3.groundings import FloatArray

PAIR = {column.name: i for i, column in enumerate(PRISM_COLUMNS)}


def peer_pairs(batch: FactorBatch) -> FloatArray:
    """Prism features of figures with each object of their scenes; NaN where there are fewer.

    Shape (n, p, len(PRISM_COLUMNS)).
    """
    n, p = batch.peers.shape
    row, column = np.nonzero((batch.peers >= 0) & (batch.peers != batch.figure[:, None]))
    prisms = batch.all_boxes()
    pairs = np.full((n, p, len(PRISM_COLUMNS)), np.nan)
    pairs[row, column] = prism_pair(prisms, prisms, (batch.figure[row], batch.peers[row, column]))
    return pairs


@feature_set(
    "scene",
    types=("PLACE",),
    roles=("figure",),
    words=("relation", "figure"),
    columns=(
        Column("on_ground", "bool"),
        Column("supported", "bool"),
        Column("occupied", "bool"),
        Column("nearest_gap", "1", 0, 3, 6),
        Column("near_count", "1", 0, 4, 4),
    ),
    scale=0.3,
    wordless=True,
)
def place_in_scene(batch: FactorBatch) -> FloatArray:
    """Situation of a place: on the ground or on a thing, free or taken, near things."""
    box = batch.boxes("figure")
    pairs = peer_pairs(batch)
    missing = np.isnan(pairs[..., 0])
    gaps = np.where(missing, np.inf, pairs[..., PAIR["gap"]])
    level = np.abs(np.nan_to_num(pairs[..., PAIR["height_difference"]], nan=9.0)) < 0.5
    overlap = np.nan_to_num(pairs[..., PAIR["figure_overlap"]])
    supported = np.nan_to_num(pairs[..., PAIR["supports"]]) > 0.5
    nearest = np.minimum(gaps.min(axis=1, initial=np.inf), 9.0)
    return np.column_stack(
        (
            box.z_min < 0.25 * size(box),
            supported.any(axis=1),
            (level & (overlap > 0.2)).any(axis=1),
            nearest,
            (gaps < 1.0).sum(axis=1),
        )
    )
