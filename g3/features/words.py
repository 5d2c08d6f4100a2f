"""Words of an SDC and labels of the semantic map (section 3.3, last paragraph)."""

from __future__ import annotations

import numpy as np

from g3.features.batch import FactorBatch
from g3.features.registry import Column, Columns, feature_set
from g3.groundings import FloatArray
from g3.language.similarity import MEASURES, best_match


def label_columns(batch: FactorBatch) -> Columns:
    """A binary column for each label of the batch."""
    return tuple(Column(name, "bool") for name in batch.bodies.label_names)


@feature_set(
    "labels",
    types=("OBJECT",),
    roles=("figure",),
    words=("figure", "relation"),
    columns=label_columns,
)
def labels(batch: FactorBatch) -> FloatArray:
    """Labels that the semantic map gives the figure: all of it, for a plural."""
    return batch.bodies.shared_labels[batch.figure].astype(float)


def _mixed_columns(batch: FactorBatch) -> Columns:
    return tuple(Column(f"{name}.some", "bool") for name in batch.bodies.label_names)


@feature_set(
    "mixed-labels",
    types=("OBJECT",),
    roles=("figure",),
    words=("figure",),
    columns=_mixed_columns,
    scale=0.7,
)
def mixed_labels(batch: FactorBatch) -> FloatArray:
    """Labels that some, but not all, things of a plural have."""
    bodies = batch.bodies
    return (bodies.labels & ~bodies.shared_labels)[batch.figure].astype(float)


@feature_set(
    "landmark-labels",
    types=("OBJECT", "PLACE", "PATH"),
    roles=("landmark",),
    words=("relation",),
    columns=label_columns,
    scale=0.5,
)
def landmark_labels(batch: FactorBatch) -> FloatArray:
    """Labels of the landmark: what can carry, contain or be near things."""
    return batch.bodies.labels[batch.landmark].astype(float)


@feature_set(
    "theme-labels",
    types=("EVENT",),
    roles=("theme",),
    words=("relation",),
    columns=label_columns,
    scale=0.2,
)
def theme_labels(batch: FactorBatch) -> FloatArray:
    """Labels of the object acted on: what can be picked up, moved, loaded."""
    return batch.bodies.labels[batch.theme].astype(float)


def _measure_columns(_: FactorBatch) -> Columns:
    return tuple(
        Column(f"{name}.{side}", "1", 0, 1, 5) for name in MEASURES for side in ("own", "other")
    )


@feature_set(
    "word-label",
    types=("OBJECT",),
    roles=("figure",),
    words=(),
    columns=_measure_columns,
)
def word_label(batch: FactorBatch) -> FloatArray:
    """Similarity of the figure's words to its labels, and to others in its scene."""
    factor_words = [factor.get("figure", ()) for factor in batch.words]
    vocabulary = sorted({word for words in factor_words for word in words})
    row = {word: i for i, word in enumerate(vocabulary)}
    indices = [[row[word] for word in words] for words in factor_words]
    labels = batch.bodies.labels
    own = labels[batch.figure]
    peers = labels[batch.peers] & (batch.peers >= 0)[..., None]
    other = (peers.any(axis=1) | labels[batch.agent_body]) & ~own
    columns = []
    for measure in MEASURES.values():
        similarity = measure(vocabulary, batch.bodies.label_names)
        columns += [best_match(similarity, indices, batch.factor, side) for side in (own, other)]
    return np.column_stack(columns)
