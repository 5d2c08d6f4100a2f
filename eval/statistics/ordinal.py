"""All five points of ratings: a cumulative-link model, and an effect size without one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import special

from eval.statistics.estimates import LEVEL, Estimate, FloatArray, IntArray
from g3.short_repr import short_repr


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class CumulativeLink:
    """A proportional-odds model: logit P(rating ≤ j) = θ_j − β·x."""

    coefficients: tuple[Estimate, ...]
    """β with bounds, one for each predictor: the logarithm of an odds ratio."""
    errors: FloatArray
    """Their standard errors, shape (k,)."""
    thresholds: FloatArray
    """θ, increasing, one less than there are points."""

    def odds_ratio(self, index: int = 0) -> Estimate:
        """By how much a predictor multiplies the odds of a higher rating."""
        return Estimate(*(float(np.exp(bound)) for bound in self.coefficients[index]))


def cumulative_link(
    rating: IntArray,
    predictors: FloatArray,
    cluster: IntArray | None = None,
) -> CumulativeLink:
    """Fit a proportional-odds model (P. McCullagh, J. R. Stat. Soc. B 42, 1980).

    Ratings have points, shape (n,), and predictors without an intercept, shape (n, k). With
    clusters, shape (n,), standard errors let ratings in a cluster be alike; None is for independent
    ratings.
    """
    from statsmodels.miscmodels.ordinal_model import OrderedModel  # noqa: PLC0415 - an extra

    _, points = np.unique(rating, return_inverse=True)
    robust = {} if cluster is None else {"cov_type": "cluster", "cov_kwds": {"groups": cluster}}
    fitted = OrderedModel(points, predictors, distr="logit").fit(
        method="bfgs", disp=False, **robust
    )
    k = predictors.shape[1]
    errors = np.asarray(fitted.bse[:k], dtype=np.float64)
    half = float(special.ndtri((1 + LEVEL) / 2)) * errors
    return CumulativeLink(
        tuple(
            Estimate(float(b), float(b - h), float(b + h))
            for b, h in zip(fitted.params[:k], half, strict=True)
        ),
        errors,
        np.asarray(fitted.model.transform_threshold_params(fitted.params)[1:-1]),
    )


def cliffs_delta(one: IntArray, other: IntArray) -> float:
    """How much more often a rating of `one` is above one of `other` than below it, −1 to 1.

    N. Cliff, Psychological Bulletin 114 (1993).
    """
    from scipy.stats import mannwhitneyu  # noqa: PLC0415 - heavy

    above = float(mannwhitneyu(one, other, method="asymptotic").statistic)
    return 2 * above / (len(one) * len(other)) - 1
