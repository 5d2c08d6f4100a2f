"""A trained model: its feature sets, its feature space and its weights."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

import g3.features  # noqa: F401  (fills the catalogue)
from g3 import crf
from g3.examples import Example, labels, to_batch
from g3.features.batch import FactorBatch
from g3.features.matrix import FeatureSpace, fit_space, prior_scale, transform
from g3.features.registry import CATALOGUE_VERSION, FeatureSet, select
from g3.groundings import FloatArray


@dataclass(frozen=True, slots=True)
class Model:
    """What training gives and inference needs.

    Parameters
    ----------
    space
        The binary features.
    weights
        One for each feature, shape (k,).
    l2
        Strength of the regularisation that it was trained with.
    catalogue_version
        :data:`g3.features.registry.CATALOGUE_VERSION` at training.
    corpus_hash
        Hash of the corpus that it was trained on.
    """

    space: FeatureSpace
    weights: FloatArray
    l2: float
    catalogue_version: int
    corpus_hash: str

    @property
    def sets(self) -> tuple[FeatureSet, ...]:
        """The feature sets that it uses."""
        names = set(self.space.sets)
        return tuple(s for s in select(plus=names) if s.name in names)


DEFAULT_L2 = 1.0


def train_model(
    items: Sequence[Example],
    sets: Sequence[FeatureSet],
    *,
    l2: float = DEFAULT_L2,
    corpus_hash: str = "",
    batch: FactorBatch | None = None,
    optimizer: crf.Optimizer = "newton",
) -> Model:
    """Train on labelled examples.

    Parameters
    ----------
    items
        The examples.
    sets
        Feature sets, from :func:`g3.features.registry.select`.
    l2
        Strength of the regularisation.
    corpus_hash
        Recorded in the model.
    batch
        The examples packed, if that has been done already.
    optimizer
        As in :func:`g3.crf.train`.
    """
    space, matrix = fit_space(batch if batch is not None else to_batch(items), sets)
    prior = l2 / prior_scale(space) ** 2
    weights = crf.train(matrix, labels(items), l2=prior, optimizer=optimizer)
    return Model(space, weights, l2, CATALOGUE_VERSION, corpus_hash)


def predict(
    model: Model, items: Sequence[Example], *, batch: FactorBatch | None = None
) -> FloatArray:
    """p(φ = True) of each example, shape (n,)."""
    if not items:
        return np.zeros(0)
    matrix = transform(batch if batch is not None else to_batch(items), model.sets, model.space)
    return crf.probabilities(matrix, model.weights)
