"""How probably a plan is what was meant.

Factors are not independent, and the search takes the best of many: the product of their
probabilities says less than it seems. A logistic curve over what tells right plans from wrong ones
is fitted on plans for commands of held-out scenarios.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import minimize
from scipy.special import expit, log_expit, logsumexp

from g3.geometry import BoolArray
from g3.groundings import FloatArray
from g3.inference.search import Hypothesis

WEIGHTS = np.array([0.93, 0.97, 0.62])
"""Bias, mean log-probability of the factors, log share of the plan among its rivals: fitted to
plans for the paper's commands, each by a model that has not seen its scenario."""
SLOPES_L2 = 1.0
"""How far slopes are kept from large values where a curve is fitted to few plans."""


def evidence(hypothesis: Hypothesis, rivals: Sequence[Hypothesis]) -> FloatArray:
    """What the curve sees of a plan, shape (3,)."""
    scores = np.array([score for _, score in hypothesis.nodes.values()] or [0.0])
    share = hypothesis.score - logsumexp([r.score for r in rivals])
    return np.array([1.0, scores.mean(), float(share)])


def plan_probability(seen: FloatArray) -> float:
    """Calibrated probability of a plan from its evidence, shape (3,)."""
    return float(expit(seen @ WEIGHTS))


def fit_curve(seen: FloatArray, correct: BoolArray) -> FloatArray:
    """The weights of a curve that fits plans best, shape (3,).

    Parameters
    ----------
    seen
        Evidence of the plans, shape (n, 3).
    correct
        Which of them are right, shape (n,).
    """
    sign = np.where(correct, 1.0, -1.0)

    def loss(weights: FloatArray) -> tuple[float, FloatArray]:
        odds = sign * (seen @ weights)
        slopes = np.array([0.0, *weights[1:]])
        value = -log_expit(odds).sum() + SLOPES_L2 * (slopes**2).sum() / 2
        return float(value), -(sign * expit(-odds)) @ seen + SLOPES_L2 * slopes

    weights: FloatArray = minimize(loss, np.zeros(seen.shape[1]), jac=True).x
    return weights
