"""The conditional random field over correspondence variables (section 3.2, equation 4).

Given the groundings, the factors of a grounding graph share no unobserved variable. So the
likelihood factors over clauses, and each φ_i is logistic in the weights of its active features.
Training maximises the L2-regularised likelihood; the objective is convex, so the optimum is unique,
whether Newton's method finds it or L-BFGS.

A step needs the value and the gradient of all factors, so that the optimum is that of all. Of the
curvature, which Newton's method uses, an estimate is enough: what it lacks makes steps worse, not
the optimum. Near the optimum most factors are decided, and few have curvature at all.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from hashlib import blake2b
from types import MappingProxyType
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.special import expit
from threadpoolctl import threadpool_limits

from g3.groundings import FloatArray
from g3.short_repr import short_repr

BoolArray = npt.NDArray[np.bool_]

TOLERANCE = 1e-4


class Likelihood:
    """Negative log-likelihood of labelled factors.

    Parameters
    ----------
    matrix
        Features of the factors, shape (n, k).
    right
        Correspondence variables, shape (n,); how often they are true, if a row stands for
        several factors.
    times
        Number of factors that each row stands for, shape (n,); one if left out.
    number
        Index of the part of a likelihood: each draws other rows for the curvature.
    """

    def __init__(
        self,
        matrix: sparse.csr_array,
        right: BoolArray | FloatArray,
        *,
        times: FloatArray | None = None,
        number: int = 0,
    ) -> None:
        self._matrix = matrix
        self._right = right.astype(np.float64)
        self._times = np.ones(len(right)) if times is None else times
        # The same draw at each step, so that the estimate changes no more than the curvature.
        self._drawn = np.random.default_rng(number).random(len(right))

    def __call__(self, weights: FloatArray, least: float = np.inf) -> Local:
        """Value, gradient and curvature at some weights (k,).

        Rows with at least the curvature `least` are kept; of those with less so many as make up
        for the others of their kind, as if they had it.
        """
        score = self._matrix @ weights
        chance = expit(score)
        value = self._times @ np.logaddexp(0.0, score) - self._right @ score
        gradient = self._matrix.T @ (self._times * chance - self._right)
        curvature = self._times * chance * (1 - chance)
        kept = np.flatnonzero(curvature > least * self._drawn)
        return Local(
            float(value),
            gradient,
            float(curvature.sum()),
            self._matrix[kept],
            np.maximum(curvature[kept], least),
        )


def train(
    matrix: sparse.csr_array,
    correct: BoolArray,
    *,
    l2: float | FloatArray = 1.0,
    tolerance: float = TOLERANCE,
    optimizer: Optimizer = "newton",
) -> FloatArray:
    """Weights that maximise the regularised likelihood, shape (k,).

    Most products of base features and words occur in the same few factors, so many
    columns are equal. At the optimum equal columns with equal penalties p have equal
    weights. Hence d copies with weights w act as one column times sqrt(d / p) with the
    weight sqrt(d p) w and the penalty 1: the problem shrinks to the distinct columns, and
    has the same optimum. Equal rows are looked at once, too.

    Parameters
    ----------
    matrix
        Features, shape (n, k).
    correct
        Correspondence variables, shape (n,).
    l2
        Strength of the regularisation, above 0: the penalty is ``sum(l2 * weights ** 2) / 2``;
        one number or one a feature (k,).
    tolerance
        Stop when no component of the gradient exceeds it. (scikit-learn's objective is
        the mean over factors: its ``tol`` is this divided by n.)
    optimizer
        Newton's method takes a fraction of L-BFGS's passes (`g3.learning.crf`).
    """
    penalty = np.broadcast_to(np.asarray(l2, dtype=np.float64), (matrix.shape[1],))
    rows = matrix
    if not matrix.has_canonical_format:
        rows = matrix.copy()
        rows.sum_duplicates()
    kept, row_of = _distinct(rows, np.zeros(len(correct)))
    columns = sparse.csc_array(rows[kept])
    first, copy_of = _distinct(columns, penalty)
    unit, size = shrinking(copy_of, penalty[first])
    shrunk = sparse.csr_array(sparse.csr_array(columns[:, first]) * unit)
    times, right = (
        np.bincount(row_of, of, minlength=len(kept)).astype(np.float64)
        for of in (np.ones(len(correct)), correct)
    )
    problem = Problem(Likelihood(shrunk, right, times=times), unit, len(correct) / 4)
    minimum = minimise(problem, tolerance=tolerance, optimizer=optimizer)
    return (minimum / size)[copy_of]


def shrinking(copy_of: npt.NDArray[np.intp], penalty: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the factors of distinct columns with penalties (m,), and their weights'; (m,) each."""
    copies = np.bincount(copy_of)
    return np.sqrt(copies / penalty), np.sqrt(copies * penalty)


def _distinct(
    lines: sparse.csr_array | sparse.csc_array, penalty: FloatArray
) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
    """Return the first index of each distinct pair of a line and a penalty, and each one's rank.

    The lines are the rows or columns that the matrix is stored by. They are distinguished by a
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
    return expit(matrix @ weights)


Optimizer = Literal["newton", "lbfgs"]

METHODS = MappingProxyType({"newton": "Newton-CG", "lbfgs": "L-BFGS-B"})
"""SciPy's names of the ways to the optimum; the paper's is L-BFGS."""

MAX_ITERATIONS = 1000
KEPT = 100_000
"""Rows of which a step takes the curvature at most, on average."""


@short_repr
@dataclass(frozen=True, slots=True)
class Local:
    """A function of k weights, near some weights.

    Parameters
    ----------
    gradient
        Shape (k,).
    curvature
        The sum of the curvatures of all its rows.
    rows, strengths
        ``rows.T @ diag(strengths) @ rows`` estimates the second derivative; shapes (m, k), (m,).
    """

    value: float
    gradient: FloatArray
    curvature: float
    rows: sparse.csr_array
    strengths: FloatArray


Look = Callable[[FloatArray, float], Local]
"""Evaluation near some weights (k,), with the rows of at least this curvature, and of the others so
many as make up for those that are left out."""


@short_repr
@dataclass(frozen=True, slots=True)
class Problem:
    """A convex function of k weights, to which half their square is added.

    Parameters
    ----------
    unit
        Divisors of the components of the gradient before these are compared, shape (k,).
    curvature
        The sum of the curvatures of all rows at 0.
    """

    look: Look
    unit: FloatArray
    curvature: float


class _Penalised:
    """The objective in SciPy's form; it keeps its value at the last weights."""

    def __init__(self, problem: Problem, tolerance: float, *, curved: bool) -> None:
        self._problem, self._tolerance = problem, tolerance
        self._least = problem.curvature / KEPT if curved else np.inf
        self._seen: tuple[bytes, Local] | None = None

    def _at(self, weights: FloatArray) -> Local:
        key = weights.tobytes()
        if self._seen is None or self._seen[0] != key:
            self._seen = None  # its rows go before others come
            self._seen = key, self._problem.look(weights, self._least)
        return self._seen[1]

    def value(self, weights: FloatArray) -> tuple[float, FloatArray]:
        """Return the sum and its gradient."""
        local = self._at(weights)
        return local.value + float(weights @ weights) / 2, local.gradient + weights

    def bend(self, weights: FloatArray, step: FloatArray) -> FloatArray:
        """Return the second derivative times a step."""
        local = self._at(weights)
        bent: FloatArray = local.rows.T @ (local.strengths * (local.rows @ step)) + step
        return bent

    def stop_if_flat(self, xk: FloatArray) -> None:
        """End where no component of the gradient exceeds the tolerance."""
        local = self._at(xk)
        if self._least < np.inf:
            self._least = local.curvature / KEPT
        if np.abs((local.gradient + xk) / self._problem.unit).max() <= self._tolerance:
            raise StopIteration


def minimise(problem: Problem, *, tolerance: float, optimizer: Optimizer) -> FloatArray:
    """Minimise a problem's sum, from 0.

    Parameters
    ----------
    tolerance
        Stop when no component of the gradient exceeds it.
    optimizer
        Newton's method looks at all factors a few dozen times, L-BFGS hundreds.
    """
    start = np.zeros(len(problem.unit))
    if not len(start):
        return start
    from scipy import optimize  # noqa: PLC0415 - a fifth of a second, which only training waits for

    newton = optimizer == "newton"
    at = _Penalised(problem, tolerance, curved=newton)
    options: Any = {"xtol": 0} if newton else {"gtol": 0, "ftol": 0, "maxls": 50}
    method: Any = METHODS[optimizer]  # SciPy's stubs want it written out
    # The vectors are short: BLAS threads cost more than they bring, twentyfold on a busy machine.
    with threadpool_limits(limits=1, user_api="blas"):
        result = optimize.minimize(
            at.value,
            start,
            jac=True,
            hessp=at.bend if newton else None,
            method=method,
            callback=at.stop_if_flat,
            options={"maxiter": MAX_ITERATIONS} | options,
        )
    return result.x
