"""A cost that prefers nothing, which shows what the search prefers by itself."""

from __future__ import annotations

import numpy as np

from g3.features.factor_batch import FactorBatch
from g3.groundings import FloatArray


class ConstantCost:
    """The same for everything."""

    def log_probability(self, batch: FactorBatch, *, true: bool = True) -> FloatArray:
        """Logarithms of a half."""
        return np.full(len(batch), np.log(0.5))
