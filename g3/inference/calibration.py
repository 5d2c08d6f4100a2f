"""How probably a plan is what was meant.

Factors are not independent, and the search takes the best of many: the product of their
probabilities says less than it seems. A logistic curve over what tells right plans from wrong ones
is fitted on plans for commands of held-out scenarios.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.special import expit, logsumexp

from g3.groundings import FloatArray
from g3.inference.search import Hypothesis

WEIGHTS = np.array([1.5, 0.7, 0.1, 1.3])
"""Bias, mean and least log-probability of the factors, log share of the plan among its rivals:
fitted to plans for the paper's commands, each by a model that has not seen its scenario."""


def evidence(hypothesis: Hypothesis, rivals: Sequence[Hypothesis]) -> FloatArray:
    """What the curve sees of a plan, shape (4,)."""
    scores = np.array([score for _, score in hypothesis.nodes.values()] or [0.0])
    share = hypothesis.score - logsumexp([r.score for r in rivals])
    return np.array([1.0, scores.mean(), scores.min(), float(share)])


def plan_probability(hypothesis: Hypothesis, rivals: Sequence[Hypothesis]) -> float:
    """Calibrated probability of a plan among those that the search has kept."""
    return float(expit(evidence(hypothesis, rivals) @ WEIGHTS))
