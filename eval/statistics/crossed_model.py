"""A mixed model of judgments in crossed clusters: of videos and of raters."""

from __future__ import annotations

import numpy as np
from scipy import special

from corpus_tools.corpus.estimate import Estimate, undefined
from eval.statistics.estimates import LEVEL, BoolArray, IntArray, bounded
from eval.statistics.model_fits import Fit, fitted


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

    found = fitted(fit)
    if isinstance(found, str):
        return undefined(found)
    value, error = float(found.parameters[0]), float(found.errors[0])
    if not 0 < value < 1:
        return undefined("no convergence")
    half = special.stdtrit(min(sizes) - 1, (1 + LEVEL) / 2) * error / (value * (1 - value))
    low, high = special.expit(special.logit(value) + half * np.array([-1, 1]))
    return bounded(value, float(low), float(high))
