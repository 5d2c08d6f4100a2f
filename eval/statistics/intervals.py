"""Intervals of a share of judgments.

Those of :func:`wilson` and :func:`clopper_pearson` take judgments for independent, which they
aren't. A command is judged several times, a video has several commands, and a person judges
many. The others respect that, and are wider.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from scipy import special

from corpus_tools.corpus.estimate import Estimate, undefined
from corpus_tools.runtime.parallel import Executor
from eval.statistics.estimates import (
    LEVEL,
    BoolArray,
    FloatArray,
    IntArray,
    bounded,
    percentiles,
)
from eval.statistics.model_fits import Fit, fitted
from eval.statistics.resampling import resampled_sums

DRAWS = 10_000


def wilson(agreeing: int, n: int) -> Estimate:
    """Return Wilson's score interval (J. Am. Stat. Assoc. 22, 1927), for independent judgments."""
    return _independent(agreeing, n, "wilson")


def clopper_pearson(agreeing: int, n: int) -> Estimate:
    """Return Clopper and Pearson's exact interval (Biometrika 26, 1934), for independence."""
    return _independent(agreeing, n, "exact")


def _independent(agreeing: int, n: int, method: Literal["wilson", "exact"]) -> Estimate:
    from scipy.stats import binomtest  # noqa: PLC0415 - heavy

    if n == 0:
        return undefined("no data")
    found = binomtest(agreeing, n).proportion_ci(LEVEL, method)
    return bounded(agreeing / n, float(found.low), float(found.high))


def bootstrap(
    agrees: BoolArray | FloatArray,
    cluster: IntArray,
    *,
    rng: np.random.Generator,
    draws: int = DRAWS,
    executor: Executor | None = None,
) -> Estimate:
    """Return a percentile interval that resamples whole clusters, such as videos.

    Parameters
    ----------
    agrees, cluster
        Each judgment's answer, or the share of several, and its cluster, shape (n,).
    executor
        Executor of the resamples (:func:`eval.statistics.resampling.resampled_sums`).
    """
    if len(agrees) == 0:
        return undefined("no data")
    _, index = np.unique(cluster, return_inverse=True)
    counted = np.stack([np.bincount(index, weights=agrees), np.bincount(index)], axis=1)
    sums, counts = resampled_sums(counted, rng=rng, draws=draws, executor=executor).T
    return percentiles(float(agrees.mean()), sums / counts, len(counted))


def two_way(agrees: BoolArray | FloatArray, first: IntArray, second: IntArray) -> Estimate:
    """Return an interval for judgments in two crossed clusterings, such as videos and raters.

    A. C. Cameron, J. B. Gelbach and D. L. Miller (J. Bus. Econ. Stat. 29, 2011): the variance
    between clusters of the one kind and of the other, less that between clusters of both. On the
    logit scale, with Student's quantile for as many clusters as there are of the rarer kind. Where
    all agree or none does, it is Wilson's interval for as many clusters. With one cluster of a
    kind, such as one rater, there is no interval: others of that kind can't be spoken for.

    Parameters
    ----------
    agrees
        Each judgment's answer, or the share of several, shape (n,).
    first, second
        Its clusters, shape (n,).
    """
    if len(agrees) == 0:
        return undefined("no data")
    share = float(agrees.mean())
    kinds = [np.unique(kind, return_inverse=True)[1] for kind in (first, second)]
    kinds.append(np.unique(kinds[0] * len(agrees) + kinds[1], return_inverse=True)[1])
    count = min(int(kind.max()) + 1 for kind in kinds[:2])
    if count < 2:
        return Estimate(share, reason="one cluster")
    if share in (0.0, 1.0):
        return wilson(round(share * count), count)
    deviations = agrees.astype(np.float64) - share
    one, other, both = (_between(deviations, kind) for kind in kinds)
    # The difference may be too small by chance.
    variance = max(one + other - both, one, other) / len(agrees) ** 2
    half = special.stdtrit(count - 1, (1 + LEVEL) / 2) * np.sqrt(variance) / (share * (1 - share))
    low, high = special.expit(special.logit(share) + half * np.array([-1, 1]))
    return bounded(share, float(low), float(high))


def _between(deviations: FloatArray, cluster: IntArray) -> float:
    """Return the sum of squares of the clusters' sums, corrected for their number."""
    sums = np.bincount(cluster, weights=deviations)
    n = len(sums)
    return float((sums**2).sum()) * (n / (n - 1) if n > 1 else 1.0)


def gee(agrees: BoolArray, cluster: IntArray) -> Estimate:
    """Return an interval by generalised estimating equations, with exchangeable correlation.

    K.-Y. Liang and S. L. Zeger (Biometrika 73, 1986), on the logit scale. The standard error is
    Mancl and DeRouen's (Biometrics 57, 2001) and the quantile Student's, for there are few
    clusters. The value is the model's: clusters count less for each judgment the larger they are.
    """
    import statsmodels.api as sm  # noqa: PLC0415 - an extra, and heavy

    if len(agrees) == 0:
        return undefined("no data")
    clusters = len(np.unique(cluster))
    share = float(agrees.mean())
    if clusters < 2:
        return Estimate(share, reason="one cluster")
    if share in (0.0, 1.0):
        return Estimate(share, reason="all alike")
    model = sm.GEE(
        agrees.astype(np.float64),
        np.ones((len(agrees), 1)),
        groups=cluster,
        family=sm.families.Binomial(),
        cov_struct=sm.cov_struct.Exchangeable(),
    )

    def fit() -> Fit:
        result = model.fit(cov_type="bias_reduced")
        return Fit(result.params, result.bse, bool(result.converged))

    found = fitted(fit)
    if isinstance(found, str):
        return undefined(found)
    logit, error = float(found.parameters[0]), float(found.errors[0])
    half = float(special.stdtrit(clusters - 1, (1 + LEVEL) / 2)) * error
    value, low, high = special.expit([logit, logit - half, logit + half])
    return bounded(float(value), float(low), float(high))


def intraclass_correlation(agrees: BoolArray, cluster: IntArray) -> Estimate:
    """Estimate the correlation of judgments in a cluster by analysis of variance.

    M. S. Ridout, C. G. B. Demétrio and D. Firth, Biometrics 55 (1999), equation 3.
    """
    _, index = np.unique(cluster, return_inverse=True)
    sizes, sums = np.bincount(index), np.bincount(index, weights=agrees)
    n, k = len(agrees), len(sizes)
    if n == 0:
        return undefined("no data")
    if k == n:
        return undefined("no overlap")
    if k == 1:
        return undefined("one cluster")
    if np.ptp(np.asarray(agrees, dtype=np.float64)) == 0:
        return undefined("all alike")
    within = float((sums - sums**2 / sizes).sum()) / (n - k)
    between = float((sums**2 / sizes).sum() - sums.sum() ** 2 / n) / (k - 1)
    typical = (n - float((sizes**2).sum()) / n) / (k - 1)
    total = between + (typical - 1) * within
    return Estimate(min((between - within) / total, 1.0)) if total > 0 else undefined("all alike")
