"""Costs of a factor's groundings: learned, or random as in the paper's baseline."""

from __future__ import annotations

import hashlib
from typing import Protocol

import numpy as np

from g3.features.factor_batch import FactorBatch
from g3.groundings import FloatArray
from g3.inference.problem.scoring import Scorer


class Cost(Protocol):
    """Gives each row of a batch log p(φ = true), or of φ = false; shape (n,)."""

    def log_probability(self, batch: FactorBatch, *, true: bool = True) -> FloatArray:
        """The logarithm of the probability of each row."""
        ...


class RandomCost:
    """Probabilities that have nothing to do with words or groundings (Table 3, first row).

    Each factor of each command has its own numbers, the same whenever it is asked again.
    """

    def __init__(self, seed: int = 0) -> None:
        self._seed = seed

    def log_probability(self, batch: FactorBatch, *, true: bool = True) -> FloatArray:
        """Logarithms of uniform numbers."""
        words = repr([sorted(w.items()) for w in batch.words]).encode()
        digest = int.from_bytes(hashlib.sha256(words).digest()[:8], "big")
        kind = int(batch.type[0]) if len(batch) else 0
        rng = np.random.default_rng([self._seed, digest, kind, len(batch)])
        result: FloatArray = np.log(rng.uniform(1e-6, 1.0, len(batch)))
        return result


__all__ = ["Cost", "RandomCost", "Scorer"]
