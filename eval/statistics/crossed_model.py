"""A mixed model of judgments whose clusters cross: of videos, which raters see several of."""

from __future__ import annotations

import warnings

import numpy as np
from scipy import special

from eval.statistics.estimates import LEVEL, BoolArray, Estimate, IntArray


def crossed(agrees: BoolArray, *clusters: IntArray) -> Estimate:
    """The share by a linear mixed model with crossed random effects, such as of videos and raters.

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
        Without bounds where all agree or none does, some kind has fewer than two clusters, or the
        fit doesn't converge.
    """
    from statsmodels.regression.mixed_linear_model import (  # noqa: PLC0415 - an extra, and heavy
        MixedLM,
        VCSpec,
    )

    share = float(agrees.mean()) if len(agrees) else np.nan
    members = [np.unique(kind, return_inverse=True)[1] for kind in clusters]
    sizes = [int(kind.max(initial=-1)) + 1 for kind in members]
    if min(sizes) < 2 or share in (0.0, 1.0):
        return Estimate(share, np.nan, np.nan)
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
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of deviations at zero, which is an answer
        # Methods with gradients, which are the default, stop early here.
        fitted = model.fit(reml=True, method=["powell", "nm"])
    value, error = float(fitted.fe_params[0]), float(fitted.bse_fe[0])
    if not (fitted.converged and 0 < value < 1):
        return Estimate(value, np.nan, np.nan)
    half = special.stdtrit(min(sizes) - 1, (1 + LEVEL) / 2) * error / (value * (1 - value))
    low, high = special.expit(special.logit(value) + half * np.array([-1, 1]))
    return Estimate(value, float(low), float(high))
