"""The conditional random field over correspondence variables (section 3.2, equation 4).

With the groundings given, the factors of a grounding graph share no unobserved variable,
so the likelihood factors over clauses and each φ_i has a logistic distribution in the
weights of its active features. Training maximises the L2-regularised likelihood with
L-BFGS; the objective is convex, so the optimum is unique.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy import optimize, sparse
from scipy.special import expit

from g3.groundings import FloatArray

BoolArray = npt.NDArray[np.bool_]


class Objective:
    """Negative log-likelihood of labelled factors plus an L2 penalty on the weights.

    Parameters
    ----------
    matrix
        Features of the factors, shape (n, k).
    correct
        Correspondence variables, shape (n,).
    l2
        The penalty is ``sum(l2 * weights ** 2) / 2``; one number, or one a weight (k,).
    """

    def __init__(
        self, matrix: sparse.csr_array, correct: BoolArray, l2: float | FloatArray
    ) -> None:
        self._matrix = matrix
        self._transposed = sparse.csr_array(matrix.T)
        self._correct = correct.astype(np.float64)
        self._l2 = l2

    def __call__(self, weights: FloatArray) -> tuple[float, FloatArray]:
        """Value and gradient at some weights (k,)."""
        score = self._matrix @ weights
        loss = np.logaddexp(0.0, score).sum() - self._correct @ score
        gradient = self._transposed @ (expit(score) - self._correct) + self._l2 * weights
        return float(loss + (self._l2 * weights) @ weights / 2), gradient


def train(
    matrix: sparse.csr_array,
    correct: BoolArray,
    *,
    l2: float | FloatArray = 1.0,
    tolerance: float = 1e-4,
    max_iterations: int = 1000,
) -> FloatArray:
    """Weights that maximise the regularised likelihood, by L-BFGS.

    Parameters
    ----------
    matrix
        Features, shape (n, k).
    correct
        Correspondence variables, shape (n,).
    l2
        Strength of the regularisation, one number or one a feature (k,).
    tolerance
        Stop when no component of the gradient exceeds it.
    max_iterations
        Stop after so many steps all the same.

    Returns
    -------
    FloatArray
        Shape (k,).
    """
    result = optimize.minimize(
        Objective(matrix, correct, l2),
        np.zeros(matrix.shape[1]),
        jac=True,
        method="L-BFGS-B",
        options={"maxiter": max_iterations, "gtol": tolerance, "ftol": 1e-12, "maxcor": 10},
    )
    weights: FloatArray = result.x
    return weights


def probabilities(matrix: sparse.csr_array, weights: FloatArray) -> FloatArray:
    """p(φ = True) of factors with features (n, k); shape (n,)."""
    chance: FloatArray = expit(matrix @ weights)
    return chance
