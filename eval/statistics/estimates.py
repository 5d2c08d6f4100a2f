"""Figures of a confusion table, and intervals that respect clusters.

Examples that come from one command share its words, its video and its annotator, so
they are not independent: the intervals here resample whole clusters.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from corpus_tools.corpus.estimate import Estimate, Reason, undefined
from corpus_tools.runtime.parallel import Executor, Workers, work_in_order

BLOCK = 250
"""Draws in a block."""


@dataclass(frozen=True, slots=True, eq=False)
class _Block:
    clusters: npt.NDArray[np.float64]
    draws: int
    rng: np.random.Generator


def resampled_sums(
    clusters: npt.ArrayLike,
    *,
    rng: np.random.Generator,
    draws: int,
    executor: Executor | None = None,
) -> npt.NDArray[np.float64]:
    """Return sums over clusters drawn with replacement, shape (draws, ...).

    Davison and Hinkley (1997), Bootstrap Methods and their Application, section 3.8: the counts of
    drawn clusters are multinomial, so a block of draws is one product of matrices.

    `clusters` has the summands of each cluster, shape (clusters, ...). The same state of `rng`
    gives the same sums. The executor makes the blocks, or this process. A ValueError means that
    there is no cluster, or no draw.
    """
    values = np.asarray(clusters, dtype=np.float64)
    if not len(values):
        raise ValueError("there is no cluster to draw")
    if draws < 1:
        raise ValueError(f"draws is {draws}, expected at least 1")
    flat = values.reshape(len(values), -1)
    starts = range(0, draws, BLOCK)
    blocks = [
        _Block(flat, min(BLOCK, draws - start), generator)
        for start, generator in zip(starts, rng.spawn(len(starts)), strict=True)
    ]
    sums = work_in_order(_sums, blocks, executor or Executor(Workers()))
    return np.concatenate(sums).reshape(draws, *values.shape[1:])


def _sums(block: _Block) -> npt.NDArray[np.float64]:
    n = len(block.clusters)
    times = block.rng.multinomial(n, np.full(n, 1 / n), size=block.draws)
    return times.astype(np.float64) @ block.clusters


FloatArray: TypeAlias = npt.NDArray[np.float64]
IntArray: TypeAlias = npt.NDArray[np.int64]
BoolArray: TypeAlias = npt.NDArray[np.bool_]
EstimateArray: TypeAlias = npt.NDArray[np.object_]
"""An array of estimates."""

CELLS = ("tp", "fp", "fn", "tn")
"""Order of the last axis of every array of counts."""
FIGURES = ("precision", "recall", "f", "accuracy")
"""Order of the last axis of :func:`figures`."""
LEVEL = 0.95
"""Coverage of an interval."""
FEWEST_CLUSTERS = 10
"""Smallest number of clusters for a bootstrap's interval; of fewer it would be far too narrow."""
FEWEST_BESIDE = FEWEST_CLUSTERS
"""Smallest number of ours beside which the paper's figures are shown; fewer can't be compared."""
ALIKE = 1e-12
"""Largest difference of figures that are equal up to rounding."""


def beside(paper: float | None, n: int, *, is_authored: bool) -> float | None:
    """Return the paper's figure to show beside one of ours, or None where they aren't comparable.

    Parameters
    ----------
    paper
        The paper's figure; None where it has none.
    n
        Number of our examples, pairs or commands.
    is_authored
        True if ours is of an authored corpus, or of simulated raters.
    """
    return paper if n >= FEWEST_BESIDE and not is_authored else None


NO_PAPER = (
    "paper: not beside authored commands or simulated ratings; its figures are in docs/results.md"
)
"""Note under a table without the paper's figures."""


def ratio(numerator: FloatArray, denominator: FloatArray) -> FloatArray:
    """Divide two arrays that broadcast together; NaN where the denominator isn't positive."""
    above, below = np.broadcast_arrays(numerator, denominator)
    result = np.full(above.shape, np.nan)
    np.divide(above, below, out=result, where=below > 0)
    return result


def figures(counts: npt.ArrayLike) -> FloatArray:
    """Return precision, recall, F-score and accuracy of confusion counts.

    A figure whose denominator is 0 is NaN, never 0 or 1: precision where nothing was predicted
    true, recall where nothing is true, accuracy where there is no example. The F-score is 2 tp / (2
    tp + fp + fn). It is NaN only where nothing is true nor predicted true. It is 0 where something
    is, and no prediction is right.

    Parameters
    ----------
    counts
        Counts in the order of :data:`CELLS`, shape (..., 4).

    Returns
    -------
    ndarray
        The figures in the order of :data:`FIGURES`, shape (..., 4).
    """
    table = np.asarray(counts, dtype=np.float64)
    tp, fp, fn, tn = (table[..., cell] for cell in range(len(CELLS)))
    return np.stack(
        [
            ratio(tp, tp + fp),
            ratio(tp, tp + fn),
            ratio(2 * tp, 2 * tp + fp + fn),
            ratio(tp + tn, tp + fp + fn + tn),
        ],
        axis=-1,
    )


def confusion(
    label: BoolArray,
    predicted: BoolArray,
    *,
    cluster: IntArray,
    group: IntArray,
    shape: tuple[int, int],
) -> IntArray:
    """Count the confusions of each group within each cluster.

    Parameters
    ----------
    label, predicted
        True and predicted values, shape (n,).
    cluster, group
        Index of each example's cluster and group, shape (n,).
    shape
        Numbers of clusters and of groups.

    Returns
    -------
    ndarray
        Shape (clusters, groups, 4), the last axis in the order of :data:`CELLS`.
    """
    cell = np.where(label, np.where(predicted, 0, 2), np.where(predicted, 1, 3))
    full = (*shape, len(CELLS))
    flat = np.ravel_multi_index((cluster, group, cell), full) if len(label) else cluster
    return np.bincount(flat, minlength=int(np.prod(full))).reshape(full).astype(np.int64)


def cluster_bootstrap(
    counts: IntArray,
    statistic: Callable[[FloatArray], FloatArray],
    *,
    rng: np.random.Generator,
    draws: int = 2000,
    executor: Executor | None = None,
) -> EstimateArray:
    """Return figures of summed counts with percentile intervals, resampling clusters.

    Groups are resampled together. Clusters without an example of a group stay in the pool, as
    commands without a PLACE are part of the population of commands.

    A figure with fewer than :data:`FEWEST_CLUSTERS` informative clusters has no interval.
    Resampling
    few clusters can't show how clusters differ. With under 30 clusters or so percentile intervals
    are still somewhat too narrow. :func:`percentiles` lists the other figures without one.

    Parameters
    ----------
    counts
        Counts of each cluster, shape (clusters, ..., k).
    statistic
        Maps counts (..., k) to figures (..., m), elementwise over the leading axes.
    rng
        Source of randomness; the same state gives the same bounds.
    executor
        Executor of the resamples (:func:`eval.statistics.estimates.resampled_sums`).

    Returns
    -------
    ndarray
        Estimates, shape (..., m).

    References
    ----------
    Field and Welsh (2007), Bootstrapping clustered data, J. R. Stat. Soc. B 69.
    """
    values = statistic(counts.sum(axis=0).astype(np.float64))
    informative = (~np.isnan(statistic(counts.astype(np.float64)))).sum(axis=0)
    drawn = np.zeros((draws, values.size))
    if len(counts):
        sums = resampled_sums(counts, rng=rng, draws=draws, executor=executor)
        drawn = statistic(sums).reshape(draws, -1)
    result = np.empty(values.size, dtype=np.object_)
    for i, clusters in enumerate(informative.ravel()):
        result[i] = percentiles(float(values.flat[i]), drawn[:, i], int(clusters))
    return result.reshape(values.shape)


def percentiles(
    value: float, drawn: FloatArray, clusters: int, missing: Reason = "empty class"
) -> Estimate:
    """Return a figure with the bounds of a percentile interval.

    Where both bounds would be the same there are none. Clusters that don't differ are no evidence
    that others won't, and an interval of no width would claim that the figure is known exactly.

    Resamples in which the figure is undefined are left out and counted. There is no interval where
    more of them are undefined than an interval leaves outside, nor where all but so few are on one
    side of the figure.

    Parameters
    ----------
    value
        The figure; NaN where it is undefined.
    drawn
        The same of each resample, shape (draws,).
    clusters
        Number of resampled clusters; of fewer than :data:`FEWEST_CLUSTERS` there is no interval.
    missing
        Reason for an undefined figure.
    """
    if not np.isfinite(value):
        return undefined(missing)
    if clusters < FEWEST_CLUSTERS:
        return Estimate(value, reason="few clusters")
    defined = drawn[np.isfinite(drawn)]
    left_out = len(drawn) - len(defined)
    if len(defined) < LEVEL * len(drawn):
        return Estimate(value, reason="poor resamples", left_out=left_out)
    bounds = np.quantile(defined, ((1 - LEVEL) / 2, (1 + LEVEL) / 2))
    low, high = (float(bound) for bound in bounds)
    if not low - ALIKE <= value <= high + ALIKE:
        return Estimate(value, reason="poor resamples", left_out=left_out)
    return bounded(value, low, high, left_out)


def bounded(value: float, low: float, high: float, left_out: int = 0) -> Estimate:
    """Return an estimate with an interval, or with the reason why it has none.

    Bounds that aren't numbers result from nearly singular matrices.
    """
    if not np.isfinite([value, low, high]).all():
        return undefined("singular")
    if high - low < ALIKE:
        return Estimate(value, reason="all alike", left_out=left_out)
    # Rounding may put a bound beside the value.
    return Estimate(value, min(low, value), max(high, value), left_out=left_out)
