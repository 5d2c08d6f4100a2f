"""All five points of ratings: a cumulative-link model, and an effect size without one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import special

from corpus_tools.corpus.estimate import Estimate, Reason, undefined
from eval.statistics.estimates import FEWEST_CLUSTERS, LEVEL, FloatArray, IntArray, bounded
from eval.statistics.intervals import Fit, fitted
from g3.short_repr import short_repr

SLACK = 1e-6
"""Largest optimum of a linear programme that is zero up to rounding."""
FLAT = 1e-5
"""Largest slope for each rating at which a log-likelihood is at its maximum."""


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class CumulativeLink:
    """A proportional-odds model: logit P(rating ≤ j) = θ_j − β·x."""

    coefficients: tuple[Estimate, ...]
    """β with bounds, one for each predictor: the logarithm of an odds ratio. Where the model can't
    be fitted, each has the reason."""
    errors: FloatArray
    """Standard errors of the coefficients, shape (k,); NaN where the model can't be fitted."""
    thresholds: FloatArray
    """θ, increasing, one less than there are points; empty where the model can't be fitted."""

    def odds_ratio(self, index: int = 0) -> Estimate:
        """Return the factor of a predictor on the odds of a higher rating."""
        beta = self.coefficients[index]
        with np.errstate(over="ignore"):
            value, low, high = (float(np.exp(bound)) for bound in beta[:3])
        if beta.has_interval or np.isinf(value):
            return bounded(value, low, high)
        return beta._replace(value=value)


def no_link(reason: Reason, predictors: int = 1) -> CumulativeLink:
    """Return a model that can't be fitted, with the reason."""
    none = np.full(predictors, np.nan)
    return CumulativeLink((undefined(reason),) * predictors, none, np.zeros(0))


def cumulative_link(
    rating: IntArray,
    predictors: FloatArray,
    cluster: IntArray | None = None,
) -> CumulativeLink:
    """Fit a proportional-odds model (P. McCullagh, J. R. Stat. Soc. B 42, 1980).

    Ratings have points, shape (n,), and predictors without an intercept, shape (n, k). With
    clusters, shape (n,), standard errors let ratings in a cluster be alike; None is for independent
    ratings. Of fewer than :data:`~eval.statistics.estimates.FEWEST_CLUSTERS` clusters there are no
    bounds: these errors are far too small then.
    """
    from statsmodels.miscmodels.ordinal_model import OrderedModel  # noqa: PLC0415 - an extra

    k = predictors.shape[1]
    if reason := _no_fit(rating, predictors, cluster):
        return no_link(reason, k)
    _, points = np.unique(rating, return_inverse=True)
    robust = {} if cluster is None else {"cov_type": "cluster", "cov_kwds": {"groups": cluster}}
    model = OrderedModel(points, predictors, distr="logit")

    def fit() -> Fit:
        result = model.fit(method="bfgs", disp=False, **robust)
        # The search may stop for want of precision at the top, and say that it didn't converge.
        slope = np.abs(model.score(result.params)).max() / len(points)
        return Fit(
            np.asarray(result.params, dtype=np.float64),
            np.asarray(result.bse[:k], dtype=np.float64),
            bool(result.mle_retvals["converged"] or slope < FLAT),
        )

    fit_result = fitted(fit)
    if isinstance(fit_result, str):
        return no_link(fit_result, k)
    half = float(special.ndtri((1 + LEVEL) / 2)) * fit_result.errors
    few = cluster is not None and len(np.unique(cluster)) < FEWEST_CLUSTERS
    return CumulativeLink(
        tuple(
            Estimate(float(b), reason="few clusters")
            if few
            else bounded(float(b), float(b - h), float(b + h))
            for b, h in zip(fit_result.parameters[:k], half, strict=True)
        ),
        fit_result.errors,
        np.asarray(model.transform_threshold_params(fit_result.parameters)[1:-1]),
    )


def _no_fit(rating: IntArray, predictors: FloatArray, cluster: IntArray | None) -> Reason:
    """Return why the likelihood of a proportional-odds model has no single maximum, or ""."""
    n, k = predictors.shape
    if n == 0:
        return "no data"
    _, points = np.unique(rating, return_inverse=True)
    if points.max() == 0:
        return "all alike"
    if np.linalg.matrix_rank(np.column_stack([np.ones(n), predictors])) < k + 1:
        return "singular"
    if cluster is not None and len(np.unique(cluster)) < 2:
        return "one cluster"
    return "separated" if _is_separated(points, predictors) else ""


def _is_separated(points: IntArray, predictors: FloatArray) -> bool:
    """Check that the likelihood grows without bound in some direction.

    K. Konis (Computational algorithms for detecting separated data, 2007) finds such a direction
    with a linear programme. Here it is one of thresholds δ and coefficients β. Of a rating j with
    predictors x it must not lower δ_j − β·x, nor raise δ_(j−1) − β·x, and must change one of them.
    """
    from scipy.optimize import linprog  # noqa: PLC0415 - heavy

    scaled = predictors / np.maximum(np.abs(predictors).max(axis=0), np.finfo(np.float64).tiny)
    different = np.unique(np.column_stack([points, scaled]), axis=0)
    x, below = different[:, 1:], np.eye(int(points.max()) + 2)[different[:, 0].astype(np.int64)]
    # Columns are thresholds below each point: there is none below the first, nor above the last.
    lower, upper = below[:, 1:-1], below[:, :-2]
    rows = np.vstack(
        [
            np.column_stack([lower, -x])[lower.any(axis=1)],
            np.column_stack([-upper, x])[upper.any(axis=1)],
        ]
    )
    result = linprog(rows.sum(axis=0), A_ub=rows, b_ub=np.zeros(len(rows)), bounds=(-1, 1))
    return result.fun is not None and result.fun < -SLACK


def cliffs_delta(one: IntArray, other: IntArray) -> Estimate:
    """Return Cliff's δ: how much more often `one` rates above `other` than below, −1 to 1.

    N. Cliff, Psychological Bulletin 114 (1993). It has no interval.
    """
    from scipy.stats import rankdata  # noqa: PLC0415 - heavy

    n, m = len(one), len(other)
    if not n or not m:
        return undefined("empty class")
    # Mann and Whitney's statistic, whose test isn't needed and isn't defined for ties only.
    above = float(rankdata(np.concatenate([one, other]))[:n].sum()) - n * (n + 1) / 2
    return Estimate(2 * above / (n * m) - 1)
