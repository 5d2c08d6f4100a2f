"""Reliability of stated probabilities: their agreement with observed shares."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from corpus_tools.corpus.estimate import Estimate, Reason, undefined
from eval.statistics.intervals import bootstrap
from eval.statistics.ratings import codes
from eval.table_1.correspondence import Predictions

BINS = 10


@dataclass(frozen=True, slots=True)
class Bin:
    """Examples with about the same stated probability."""

    stated: float
    """Their mean probability."""
    true: float
    """Share of them that is correct."""
    low: float
    high: float
    """Bounds of its 95% interval with whole commands resampled; NaN where there is a reason."""
    n: int
    reason: Reason = ""


def bins(predictions: Predictions, *, seed: int, draws: int) -> tuple[Bin, ...]:
    """Return the reliability diagram of predicted correspondences, in bins of equal width."""
    rng = np.random.default_rng(seed)
    place = np.minimum((predictions.probability * BINS).astype(int), BINS - 1)
    found = []
    for i in np.unique(place):
        own = place == i
        commands = codes(predictions.command[own].tolist())
        share = bootstrap(predictions.label[own], commands, rng=rng, draws=draws)
        stated = float(predictions.probability[own].mean())
        found.append(Bin(stated, *share[:3], int(own.sum()), share.reason))
    return tuple(found)


def calibration_error(found: Sequence[Bin]) -> Estimate:
    """Return the expected calibration error: the mean gap of stated and observed.

    It has no interval.
    """
    n = sum(b.n for b in found)
    if not n:
        return undefined("no data")
    return Estimate(sum(b.n * abs(b.stated - b.true) for b in found) / n)
