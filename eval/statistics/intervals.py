"""Intervals of a share of judgments.

Those of :func:`wilson` and :func:`clopper_pearson` take judgments for independent, which they
aren't. A command is judged several times, a video has several commands, and a person judges
many. The others respect that, and are wider.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from scipy import special

from corpus_tools.runtime.parallel import Executor
from eval.statistics.estimates import (
    FEWEST_CLUSTERS,
    LEVEL,
    BoolArray,
    Estimate,
    FloatArray,
    IntArray,
    percentile_bounds,
)
from eval.statistics.resampling import resampled_sums

DRAWS = 10_000


def wilson(agreeing: int, n: int) -> Estimate:
    """Wilson's score interval (J. Am. Stat. Assoc. 22, 1927), for independent judgments."""
    return _independent(agreeing, n, "wilson")


def clopper_pearson(agreeing: int, n: int) -> Estimate:
    """Clopper and Pearson's exact interval (Biometrika 26, 1934), for independent judgments."""
    return _independent(agreeing, n, "exact")


def _independent(agreeing: int, n: int, method: Literal["wilson", "exact"]) -> Estimate:
    from scipy.stats import binomtest  # noqa: PLC0415 - heavy

    if n == 0:
        return Estimate(np.nan, np.nan, np.nan)
    found = binomtest(agreeing, n).proportion_ci(LEVEL, method)
    return Estimate(agreeing / n, float(found.low), float(found.high))


def bootstrap(
    agrees: BoolArray | FloatArray,
    cluster: IntArray,
    *,
    rng: np.random.Generator,
    draws: int = DRAWS,
    executor: Executor | None = None,
) -> Estimate:
    """Percentile interval that resamples whole clusters, such as videos.

    Parameters
    ----------
    agrees, cluster
        Each judgment's answer, or the share of several, and its cluster, shape (n,).
    executor
        Who makes the resamples (:func:`eval.statistics.resampling.resampled_sums`).
    """
    if len(agrees) == 0:
        return Estimate(np.nan, np.nan, np.nan)
    _, index = np.unique(cluster, return_inverse=True)
    counted = np.stack([np.bincount(index, weights=agrees), np.bincount(index)], axis=1)
    sums, counts = resampled_sums(counted, rng=rng, draws=draws, executor=executor).T
    return percentiles(float(agrees.mean()), sums / counts, len(counted))


def two_way(agrees: BoolArray | FloatArray, first: IntArray, second: IntArray) -> Estimate:
    """Interval for judgments in two crossed clusterings, such as of videos and of raters.

    A. C. Cameron, J. B. Gelbach and D. L. Miller (J. Bus. Econ. Stat. 29, 2011): the variance
    between clusters of the one kind and of the other, less that between clusters of both. On the
    logit scale, with Student's quantile for as many clusters as there are of the rarer kind. Where
    all agree or none does, it is Wilson's interval for as many clusters.

    Parameters
    ----------
    agrees
        Each judgment's answer, or the share of several, shape (n,).
    first, second
        Its clusters, shape (n,).
    """
    if len(agrees) == 0:
        return Estimate(np.nan, np.nan, np.nan)
    share = float(agrees.mean())
    kinds = [np.unique(kind, return_inverse=True)[1] for kind in (first, second)]
    kinds.append(np.unique(kinds[0] * len(agrees) + kinds[1], return_inverse=True)[1])
    count = min((int(kind.max()) + 1 for kind in kinds[:2] if kind.max()), default=1)
    if share in (0.0, 1.0):
        return wilson(round(share * count), count)
    if count < 2:
        return Estimate(share, np.nan, np.nan)
    deviations = agrees.astype(np.float64) - share
    one, other, both = (_between(deviations, kind) for kind in kinds)
    # The difference may be too small by chance.
    variance = max(one + other - both, one, other) / len(agrees) ** 2
    half = special.stdtrit(count - 1, (1 + LEVEL) / 2) * np.sqrt(variance) / (share * (1 - share))
    low, high = special.expit(special.logit(share) + half * np.array([-1, 1]))
    return Estimate(share, float(low), float(high))


def _between(deviations: FloatArray, cluster: IntArray) -> float:
    """Sum of squares of the clusters' sums, corrected for their number."""
    sums = np.bincount(cluster, weights=deviations)
    n = len(sums)
    return float((sums**2).sum()) * (n / (n - 1) if n > 1 else 1.0)


def gee(agrees: BoolArray, cluster: IntArray) -> Estimate:
    """Interval of generalised estimating equations with exchangeable correlation in clusters.

    K.-Y. Liang and S. L. Zeger (Biometrika 73, 1986), on the logit scale. The standard error is
    Mancl and DeRouen's (Biometrics 57, 2001) and the quantile Student's, for there are few
    clusters. The value is the model's: clusters count less for each judgment the larger they are.
    """
    import statsmodels.api as sm  # noqa: PLC0415 - an extra, and heavy

    clusters = len(np.unique(cluster))
    share = float(agrees.mean()) if len(agrees) else np.nan
    if clusters < 2 or share in (0.0, 1.0):
        return Estimate(share, np.nan, np.nan)
    model = sm.GEE(
        agrees.astype(np.float64),
        np.ones((len(agrees), 1)),
        groups=cluster,
        family=sm.families.Binomial(),
        cov_struct=sm.cov_struct.Exchangeable(),
    )
    fitted = model.fit(cov_type="bias_reduced")
    logit, error = float(fitted.params[0]), float(fitted.bse[0])
    half = float(special.stdtrit(clusters - 1, (1 + LEVEL) / 2)) * error
    value, low, high = (1 / (1 + np.exp(-x)) for x in (logit, logit - half, logit + half))
    return Estimate(float(value), float(low), float(high))


def intraclass_correlation(agrees: BoolArray, cluster: IntArray) -> float:
    """How alike judgments in a cluster are: the analysis-of-variance estimate.

    M. S. Ridout, C. G. B. Demétrio and D. Firth, Biometrics 55 (1999), equation 3.
    """
    _, index = np.unique(cluster, return_inverse=True)
    sizes, sums = np.bincount(index), np.bincount(index, weights=agrees)
    n, k = len(agrees), len(sizes)
    if not 1 < k < n:
        return np.nan
    within = float((sums - sums**2 / sizes).sum()) / (n - k)
    between = float((sums**2 / sizes).sum() - sums.sum() ** 2 / n) / (k - 1)
    typical = (n - float((sizes**2).sum()) / n) / (k - 1)
    total = between + (typical - 1) * within
    return (between - within) / total if total else np.nan


def percentiles(value: float, drawn: FloatArray, clusters: int) -> Estimate:
    """A figure with the bounds of a percentile interval; NaN where it has none.

    Parameters
    ----------
    drawn
        The same of each resample.
    clusters
        How many clusters were resampled; of fewer than `FEWEST_CLUSTERS` there is no interval.
    """
    if clusters < FEWEST_CLUSTERS:
        return Estimate(value, np.nan, np.nan)
    low, high = percentile_bounds(drawn)
    return Estimate(value, float(low), float(high))
