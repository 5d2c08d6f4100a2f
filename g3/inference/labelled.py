"""Labelled batches of factors, which the model is trained on besides a corpus's own examples."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from g3.annotation import Annotation
from g3.features.batch import FactorBatch


@dataclass(frozen=True, slots=True)
class Labelled:
    """A batch of factors with their labels.

    Parameters
    ----------
    annotation
        Where they come from.
    batch
        n factors of one clause.
    correct
        Correspondence variables, shape (n,).
    """

    annotation: Annotation
    batch: FactorBatch
    correct: npt.NDArray[np.bool_]
