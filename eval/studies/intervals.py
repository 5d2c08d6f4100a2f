"""Intervals of a share of judgments.

Those of :func:`wilson` and :func:`clopper_pearson` take judgments for independent, which they
aren't: a command is judged several times, a video has several commands, and a person judges
many. The others respect that, and are wider.
"""

from __future__ import annotations

import numpy as np
from scipy import special

from eval.statistics import LEVEL, BoolArray, Estimate, FloatArray, IntArray

DRAWS = 10_000
CHUNK = 1000
"""Draws at a time, to keep memory small."""


def wilson(agreeing: int, n: int, level: float = LEVEL) -> Estimate:
    """Wilson's score interval (J. Am. Stat. Assoc. 22, 1927), for independent judgments."""
    if n == 0:
        return Estimate(np.nan, np.nan, np.nan)
    z = float(special.ndtri((1 + level) / 2))
    share = agreeing / n
    centre = (share + z**2 / (2 * n)) / (1 + z**2 / n)
    half = z / (1 + z**2 / n) * np.sqrt(share * (1 - share) / n + z**2 / (4 * n**2))
    # Rounding must not keep the share itself out.
    low = float(centre - half) if agreeing else 0.0
    high = float(centre + half) if agreeing < n else 1.0
    return Estimate(share, low, high)


def clopper_pearson(agreeing: int, n: int, level: float = LEVEL) -> Estimate:
    """Clopper and Pearson's exact interval (Biometrika 26, 1934), for independent judgments."""
    if n == 0:
        return Estimate(np.nan, np.nan, np.nan)
    tail = (1 - level) / 2
    low = special.betaincinv(agreeing, n - agreeing + 1, tail) if agreeing else 0.0
    high = special.betaincinv(agreeing + 1, n - agreeing, 1 - tail) if agreeing < n else 1.0
    return Estimate(agreeing / n, float(low), float(high))


def bootstrap(
    agrees: BoolArray,
    cluster: IntArray,
    *,
    rng: np.random.Generator,
    draws: int = DRAWS,
    level: float = LEVEL,
) -> Estimate:
    """Percentile interval that resamples whole clusters, such as videos.

    Parameters
    ----------
    agrees, cluster
        Each judgment's answer and cluster, shape (n,).
    """
    if len(agrees) == 0:
        return Estimate(np.nan, np.nan, np.nan)
    _, index = np.unique(cluster, return_inverse=True)
    counts, sums = np.bincount(index), np.bincount(index, weights=agrees)
    times = rng.multinomial(len(counts), np.full(len(counts), 1 / len(counts)), size=draws)
    return _percentiles(float(agrees.mean()), (times @ sums) / (times @ counts), level)


def two_way_bootstrap(
    agrees: BoolArray,
    first: IntArray,
    second: IntArray,
    *,
    rng: np.random.Generator,
    draws: int = DRAWS,
    level: float = LEVEL,
) -> Estimate:
    """Percentile interval that resamples two crossed clusterings at once.

    Both are drawn independently, and a judgment counts as often as its first cluster times as
    often as its second one: A. B. Owen, "The pigeonhole bootstrap", Annals of Applied Statistics
    1 (2007). It counts what only a pair of clusters shares more than once, so that it is rather
    too wide than too narrow.

    Parameters
    ----------
    agrees
        Each judgment's answer, shape (n,).
    first, second
        Its clusters, such as its video and its rater, shape (n,).
    """
    if len(agrees) == 0:
        return Estimate(np.nan, np.nan, np.nan)
    rows, row = np.unique(first, return_inverse=True)
    columns, column = np.unique(second, return_inverse=True)
    shape = len(rows), len(columns)
    cell = np.ravel_multi_index((row, column), shape)
    size = shape[0] * shape[1]
    counts = np.bincount(cell, minlength=size).reshape(shape).astype(np.float64)
    sums = np.bincount(cell, weights=agrees, minlength=size).reshape(shape)
    values = []
    for start in range(0, draws, CHUNK):
        n = min(CHUNK, draws - start)
        left, right = (
            rng.multinomial(k, np.full(k, 1 / k), size=n).astype(np.float64) for k in shape
        )
        drawn = np.einsum("dj,dj->d", left @ counts, right)
        agreeing = np.einsum("dj,dj->d", left @ sums, right)
        values.append(np.divide(agreeing, drawn, out=np.full(n, np.nan), where=drawn > 0))
    return _percentiles(float(agrees.mean()), np.concatenate(values), level)


def gee(agrees: BoolArray, cluster: IntArray, level: float = LEVEL) -> Estimate:
    """Interval of generalised estimating equations with exchangeable correlation in clusters.

    K.-Y. Liang and S. L. Zeger (Biometrika 73, 1986), on the logit scale; the standard error is
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
    half = float(special.stdtrit(clusters - 1, (1 + level) / 2)) * error
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


def _percentiles(value: float, drawn: FloatArray, level: float) -> Estimate:
    low, high = np.nanquantile(drawn, ((1 - level) / 2, (1 + level) / 2))
    return Estimate(value, float(low), float(high))
