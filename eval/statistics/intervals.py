"""Intervals of a share of judgments.

Those of :func:`wilson` and :func:`clopper_pearson` take judgments for independent, which they
aren't. A command is judged several times, a video has several commands, and a person judges
many. The others respect that, and are wider.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Literal, NamedTuple

import numpy as np
from scipy import special

from corpus_tools.corpus.estimate import Estimate, Reason, undefined
from corpus_tools.runtime.parallel import Executor
from eval.statistics.estimates import (
    LEVEL,
    BoolArray,
    FloatArray,
    IntArray,
    bounded,
    percentiles,
    resampled_sums,
)


class Fit(NamedTuple):
    """A model's parameters and their standard errors, each of shape (k,)."""

    parameters: FloatArray
    errors: FloatArray
    converged: bool


def fitted(fit: Callable[[], Fit]) -> Fit | Reason:
    """Run a fit, and return it or the reason why it can't be used."""
    # The libraries' warnings say the same as the reason, and would stand among results.
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        try:
            result = fit()
        except (ArithmeticError, ValueError):  # of which LinAlgError is one
            return "singular"
    if not result.converged:
        return "no convergence"
    numbers = np.concatenate([np.atleast_1d(result.parameters), np.atleast_1d(result.errors)])
    return result if np.isfinite(numbers).all() else "singular"


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
    result = binomtest(agreeing, n).proportion_ci(LEVEL, method)
    return bounded(agreeing / n, float(result.low), float(result.high))


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
        Executor of the resamples (:func:`eval.statistics.estimates.resampled_sums`).
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

    fit_result = fitted(fit)
    if isinstance(fit_result, str):
        return undefined(fit_result)
    logit, error = float(fit_result.parameters[0]), float(fit_result.errors[0])
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


def crossed(agrees: BoolArray, *clusters: IntArray) -> Estimate:
    """Estimate a share by a linear mixed model with crossed random effects.

    R. H. Baayen, D. J. Davidson and D. M. Bates (J. Mem. Lang. 59, 2008), fitted by restricted
    maximum likelihood. It is linear in the share, so that its intercept is the share over all
    videos and raters. Its bounds are on the logit scale, with Student's quantile for as many
    clusters as there are of the rarer kind.

    Parameters
    ----------
    agrees
        Each judgment's answer, shape (n,).
    clusters
        Its cluster of each kind, shape (n,).

    Returns
    -------
    Estimate
        Without bounds where all agree or none does, or some kind has fewer than two clusters; the
        share is that of the judgments then.
    """
    from statsmodels.regression.mixed_linear_model import (  # noqa: PLC0415 - an extra, and heavy
        MixedLM,
        VCSpec,
    )

    if len(agrees) == 0:
        return undefined("no data")
    share = float(agrees.mean())
    members = [np.unique(kind, return_inverse=True)[1] for kind in clusters]
    sizes = [int(kind.max(initial=-1)) + 1 for kind in members]
    if min(sizes) < 2:
        return Estimate(share, reason="one cluster")
    if share in (0.0, 1.0):
        return Estimate(share, reason="all alike")
    names = [f"kind {number}" for number in range(len(members))]
    columns = [[[str(member) for member in range(size)]] for size in sizes]
    designs = [[np.eye(size)[kind]] for kind, size in zip(members, sizes, strict=True)]
    model = MixedLM(
        agrees.astype(np.float64),
        np.ones((len(agrees), 1)),
        groups=np.zeros(len(agrees), dtype=np.int64),
        exog_vc=VCSpec(names, columns, designs),
        exog_re=None,
    )

    def fit() -> Fit:
        # Methods with gradients, which are the default, stop early here.
        result = model.fit(reml=True, method=["powell", "nm"])
        return Fit(result.fe_params, result.bse_fe, bool(result.converged))

    fit_result = fitted(fit)
    if isinstance(fit_result, str):
        return undefined(fit_result)
    value, error = float(fit_result.parameters[0]), float(fit_result.errors[0])
    if not 0 < value < 1:
        return undefined("no convergence")
    half = special.stdtrit(min(sizes) - 1, (1 + LEVEL) / 2) * error / (value * (1 - value))
    low, high = special.expit(special.logit(value) + half * np.array([-1, 1]))
    return bounded(value, float(low), float(high))
