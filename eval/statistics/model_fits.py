"""Fits of statsmodels, which warn or raise where there is no estimate; here they give a reason."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from corpus_tools.corpus.estimate import Reason
from eval.statistics.estimates import FloatArray


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
