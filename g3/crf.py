"""The conditional random field over correspondence variables (section 3.2, equation 4).

With the groundings given, the factors of a grounding graph share no unobserved variable,
so the likelihood factors over clauses and each φ_i has a logistic distribution in the
weights of its active features. Training maximises the L2-regularised likelihood with
L-BFGS; the objective is convex, so the optimum is unique.
"""

from __future__ import annotations

from collections.abc import Callable
from hashlib import blake2b

import numpy as np
import numpy.typing as npt
from scipy import optimize, sparse
from scipy.special import expit
from threadpoolctl import threadpool_limits

from g3.groundings import FloatArray

BoolArray = npt.NDArray[np.bool_]


LossAndGradient = Callable[[FloatArray], tuple[float, FloatArray]]
"""Value and gradient of what is minimised, at some weights (k,)."""


class Objective:
    """Negative log-likelihood of labelled factors plus an L2 penalty on the weights.

    Parameters
    ----------
    matrix
        Features of the factors, shape (n, k).
    correct
        Correspondence variables, shape (n,); how often they are true, if a row stands for
        several factors.
    l2
        The penalty is ``sum(l2 * weights ** 2) / 2``; one number, or one a weight (k,).
    times
        How many factors each row stands for, shape (n,); one if left out.
    """

    def __init__(
        self,
        matrix: sparse.csr_array,
        correct: BoolArray | FloatArray,
        l2: float | FloatArray,
        *,
        times: FloatArray | None = None,
    ) -> None:
        self._matrix = matrix
        self._transposed = sparse.csr_array(matrix.T)
        self._correct = correct.astype(np.float64)
        self._l2 = l2
        self._times = np.ones(len(correct)) if times is None else times

    def __call__(self, weights: FloatArray) -> tuple[float, FloatArray]:
        """Value and gradient at some weights (k,)."""
        loss, gradient = _likelihood(
            self._matrix, self._transposed, self._correct, self._times, weights
        )
        gradient += self._l2 * weights
        return loss + float((self._l2 * weights) @ weights) / 2, gradient


def loss(
    matrix: sparse.csr_array, right: FloatArray, wrong: FloatArray, weights: FloatArray
) -> tuple[float, FloatArray]:
    """Negative log-likelihood of factors, some of which occur often, and its gradient.

    Sums over parts of the factors, and the penalty, make the whole objective.

    Parameters
    ----------
    matrix
        Features of different factors, shape (n, k).
    right, wrong
        How often each occurs with φ true and with φ false, shape (n,).
    weights
        Shape (k,).
    """
    return _likelihood(matrix, matrix.T, right, right + wrong, weights)


def _likelihood(
    matrix: sparse.csr_array,
    transposed: sparse.csr_array | sparse.csc_array,
    right: FloatArray,
    times: FloatArray,
    weights: FloatArray,
) -> tuple[float, FloatArray]:
    score = matrix @ weights
    value = times @ np.logaddexp(0.0, score) - right @ score
    return float(value), transposed @ (times * expit(score) - right)


def minimise(
    objective: LossAndGradient,
    size: int,
    *,
    unit: float | FloatArray = 1.0,
    tolerance: float = 1e-4,
    max_iterations: int = 1000,
) -> FloatArray:
    """Where a convex function of `size` weights is least, by L-BFGS from 0.

    Parameters
    ----------
    unit
        What the components of the gradient are divided by before they are compared, at least 1.
    tolerance
        Stop when no component of the gradient exceeds it.
    max_iterations
        Stop after so many steps all the same.
    """
    slope = np.zeros(size)

    def remembered(weights: FloatArray) -> tuple[float, FloatArray]:
        nonlocal slope
        value, slope = objective(weights)
        return value, slope

    def stop_if_flat(xk: FloatArray) -> None:
        if np.abs(slope / unit).max() <= tolerance:
            raise StopIteration

    # The vectors are short: BLAS threads cost more than they bring, twentyfold on a busy machine.
    with threadpool_limits(limits=1, user_api="blas"):
        result = optimize.minimize(
            remembered,
            np.zeros(size),
            jac=True,
            method="L-BFGS-B",
            callback=stop_if_flat,
            options={
                "maxiter": max_iterations,
                "gtol": tolerance,
                "ftol": 64 * np.finfo(np.float64).eps,
                "maxcor": 10,
                "maxls": 50,
            },
        )
    weights: FloatArray = result.x
    return weights


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
    columns, and L-BFGS takes the steps that it would take in the full one. Equal rows are
    looked at once, too.

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
    first, copy_of = _distinct(columns, penalty)
    if not len(first):
        return np.zeros(0)
    root = np.sqrt(np.bincount(copy_of))
    rows = sparse.csr_array(columns[:, first])
    rows.sort_indices()
    kept, row_of = _distinct(rows, np.zeros(len(correct)))
    shrunk = sparse.csr_array(rows[kept] * root)
    times, right = (
        np.bincount(row_of, of, minlength=len(kept)).astype(np.float64)
        for of in (np.ones(len(correct)), correct)
    )
    found = minimise(
        Objective(shrunk, right, penalty[first], times=times),
        len(first),
        unit=root,
        tolerance=tolerance,
        max_iterations=max_iterations,
    )
    weights: FloatArray = (found / root)[copy_of]
    return weights


def _distinct(
    lines: sparse.csr_array | sparse.csc_array, penalty: FloatArray
) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Where each distinct pair of a line and a penalty comes first, and which of them each is.

    The lines are the rows or columns that the matrix is stored by. They are told apart by a
    digest, as keeping all of them would need as much memory as the matrix.
    """
    places, data = lines.indices.view(np.uint8).data, lines.data.view(np.uint8).data
    wide, deep = lines.indices.itemsize, lines.data.itemsize
    ends = lines.indptr.tolist()
    number: dict[tuple[bytes, float], int] = {}
    first: list[int] = []
    copy_of = np.empty(len(penalty), dtype=np.intp)
    for line, strength in enumerate(penalty.tolist()):
        begin, end = ends[line], ends[line + 1]
        digest = blake2b(places[begin * wide : end * wide], digest_size=16)
        digest.update(data[begin * deep : end * deep])
        index = number.setdefault((digest.digest(), strength), len(first))
        if index == len(first):
            first.append(line)
        copy_of[line] = index
    return np.array(first, dtype=np.intp), copy_of


def probabilities(matrix: sparse.csr_array, weights: FloatArray) -> FloatArray:
    """p(φ = True) of factors with features (n, k); shape (n,)."""
    chance: FloatArray = expit(matrix @ weights)
    return chance
