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
from threadpoolctl import threadpool_limits

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

    Most products of base features and words occur in the same few factors, so many
    columns are equal. At the optimum equal columns with equal penalties have equal
    weights. Hence d copies with weights w act as one column times sqrt(d) with the
    weight sqrt(d) w, and have the same penalty: the problem shrinks to the distinct
    columns, and L-BFGS takes the steps that it would take in the full one.

    Parameters
    ----------
    matrix
        Features, shape (n, k).
    correct
        Correspondence variables, shape (n,).
    l2
        Strength of the regularisation, one number or one a feature (k,).
    tolerance
        Stop when no component of the gradient exceeds it. (scikit-learn's objective is
        the mean over factors: its ``tol`` is this divided by n.)
    max_iterations
        Stop after so many steps all the same.

    Returns
    -------
    FloatArray
        Shape (k,).
    """
    penalty = np.broadcast_to(np.asarray(l2, dtype=np.float64), (matrix.shape[1],))
    columns = sparse.csc_array(matrix)
    columns.sum_duplicates()
    first, copy_of = _distinct_columns(columns, penalty)
    if not len(first):
        return np.zeros(0)
    root = np.sqrt(np.bincount(copy_of))
    shrunk = sparse.csr_array(columns[:, first] * root)
    # The vectors are short: BLAS threads cost more than they bring, twentyfold on a busy machine.
    with threadpool_limits(limits=1, user_api="blas"):
        result = optimize.minimize(
            Objective(shrunk, correct, penalty[first]),
            np.zeros(len(first)),
            jac=True,
            method="L-BFGS-B",
            options={
                "maxiter": max_iterations,
                "gtol": tolerance,
                "ftol": 64 * np.finfo(np.float64).eps,
                "maxcor": 10,
                "maxls": 50,
            },
        )
    weights: FloatArray = (result.x / root)[copy_of]
    return weights


def _distinct_columns(
    columns: sparse.csc_array, penalty: FloatArray
) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Where each distinct pair of a column and a penalty comes first, and which of them each is."""
    rows = columns.indices.astype(np.int64).tobytes()
    data = columns.data.astype(np.float64).tobytes()
    ends = (columns.indptr * 8).tolist()
    number: dict[tuple[bytes, bytes, float], int] = {}
    first: list[int] = []
    copy_of = np.empty(len(penalty), dtype=np.intp)
    for column, strength in enumerate(penalty.tolist()):
        cells = slice(ends[column], ends[column + 1])
        index = number.setdefault((rows[cells], data[cells], strength), len(first))
        if index == len(first):
            first.append(column)
        copy_of[column] = index
    return np.array(first, dtype=np.intp), copy_of


def probabilities(matrix: sparse.csr_array, weights: FloatArray) -> FloatArray:
    """p(φ = True) of factors with features (n, k); shape (n,)."""
    chance: FloatArray = expit(matrix @ weights)
    return chance
