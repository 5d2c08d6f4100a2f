"""Labelled factors with their features, computed once for all the models that learn from them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import sparse

import g3.features  # noqa: F401  (fills the catalogue)
from g3.annotation import Annotation
from g3.features.factor_batch import FactorBatch
from g3.features.feature_registry import FeatureSet
from g3.features.matrix import FeatureSpace, fit_space, joint_space
from g3.learning.examples import Example, labels, to_batch
from g3.sdc.clauses import SDC_TYPES
from g3.short_repr import short_repr

BLOCK = 2000
"""Examples whose features are computed at a time, which takes 26 KB of memory an example. Blocks of
5000 take an eighth less time, and 70 MiB more."""


@short_repr
@dataclass(frozen=True, slots=True)
class Labelled:
    """n factors of one annotation's clause, with their correspondence variables, shape (n,)."""

    annotation: Annotation
    batch: FactorBatch
    correct: npt.NDArray[np.bool_]


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class FactorMatrix:
    """Labelled factors with their features; ``factors[rows]`` are some of them.

    Parameters
    ----------
    space
        The features that are active in any of them.
    matrix
        The active features of each factor, shape (n, k).
    correct
        The correspondence variables φ, shape (n,).
    scenario
        The scenario of each, shape (n,).
    """

    space: FeatureSpace
    matrix: sparse.csr_array
    correct: npt.NDArray[np.bool_]
    scenario: npt.NDArray[Any]

    def __len__(self) -> int:
        return len(self.correct)

    def __getitem__(self, rows: npt.NDArray[np.intp] | npt.NDArray[np.bool_]) -> FactorMatrix:
        return replace(
            self,
            matrix=self.matrix[rows],
            correct=self.correct[rows],
            scenario=self.scenario[rows],
        )

    def trimmed(self) -> FactorMatrix:
        """Keep only the features that are active in one of the factors."""
        active = np.unique(self.matrix.indices)
        if len(active) == len(self.space):
            return self
        space = replace(self.space, keys=self.space.keys[active])
        return replace(self, space=space, matrix=self.matrix[:, active])


def features_of_examples(
    items: Sequence[Example], sets: Sequence[FeatureSet]
) -> tuple[FeatureSpace, sparse.csr_array]:
    """Compute the features of examples, of some at a time: their space and matrix (n, k)."""
    blocks = [items[i : i + BLOCK] for i in range(0, len(items), BLOCK)] or [items]
    fitted = [fit_space(to_batch(block), sets) for block in blocks]
    return joint_space(fitted, sets) if len(fitted) > 1 else fitted[0]


def matrix_of_examples(items: Sequence[Example], sets: Sequence[FeatureSet]) -> FactorMatrix:
    """Compute the features of examples, with what they are trained to say."""
    space, matrix = features_of_examples(items, sets)
    scenario = np.array([e.annotation.command.scenario for e in items], dtype=np.str_)
    return FactorMatrix(space, matrix, labels(items), scenario)


def matrix_of_labelled(known: Labelled, sets: Sequence[FeatureSet]) -> FactorMatrix:
    """Compute the features of labelled factors, of which some types have more wrong ones."""
    scenario = np.repeat(np.array([known.annotation.command.scenario]), len(known.correct))
    return FactorMatrix(*fit_space(known.batch, sets, biased=SDC_TYPES), known.correct, scenario)


def joined(parts: Sequence[FactorMatrix], sets: Sequence[FeatureSet]) -> FactorMatrix:
    """Join the factors of several matrices."""
    space, matrix = joint_space([(part.space, part.matrix) for part in parts], sets)
    correct = np.concatenate([np.empty(0, dtype=bool), *(part.correct for part in parts)])
    scenario = np.concatenate([np.empty(0, dtype="U1"), *(part.scenario for part in parts)])
    return FactorMatrix(space, matrix, correct, scenario)
