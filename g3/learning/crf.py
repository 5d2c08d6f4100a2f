"""The conditional random field over correspondence variables (section 3.2, equation 4).

Given the groundings, the factors of a grounding graph share no unobserved variable. So the
likelihood factors over clauses, and each φ_i is logistic in the weights of its active features.
Training maximises the L2-regularised likelihood; the objective is convex, so the optimum is unique,
whether Newton's method finds it or L-BFGS.
"""

from __future__ import annotations

from hashlib import blake2b

import numpy as np
import numpy.typing as npt
from scipy import sparse
from scipy.special import expit

from g3.groundings import FloatArray
from g3.learning.optimum import Local, Optimizer, Problem, minimise

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
        Newton's method takes a fraction of L-BFGS's passes (`g3.learning.optimum`).
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
    found = minimise(problem, tolerance=tolerance, optimizer=optimizer)
    return (found / size)[copy_of]


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
