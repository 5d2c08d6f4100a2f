"""Newton's method for a sum over many factors, with the curvature of few of them.

A step needs the value and the gradient of all factors, so that the optimum is that of all.
Of the curvature an estimate is enough: what it lacks makes steps worse, not the optimum.
Near the optimum most factors are decided, and few have curvature at all.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, cg
from threadpoolctl import threadpool_limits

from g3.groundings import FloatArray

KEPT = 100_000
"""How many rows a step takes the curvature of at most, on average."""
RESIDUAL = 0.5
"""Of the gradient, how much of it a step may leave by its estimate of the curvature."""
ROUNDING = 64 * np.finfo(np.float64).eps


@dataclass(frozen=True, slots=True)
class Local:
    """A function of k weights, near some weights.

    Parameters
    ----------
    value
        The function there.
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
"""What is minimised near some weights (k,), with the rows of at least this curvature, and of the
others so many as make up for those that are left out."""


@dataclass(frozen=True, slots=True)
class Problem:
    """A convex function of k weights, to which half their square is added.

    Parameters
    ----------
    look
        The function.
    unit
        What the components of the gradient are divided by before they are compared, shape (k,).
    curvature
        The sum of the curvatures of all rows at 0.
    """

    look: Look
    unit: FloatArray
    curvature: float


def minimise(problem: Problem, *, tolerance: float, max_iterations: int) -> FloatArray:
    """Where a problem's sum is least, from 0.

    Parameters
    ----------
    tolerance
        Stop when no component of the gradient exceeds it.
    max_iterations
        Stop after so many steps all the same.
    """
    look, unit = problem.look, problem.unit
    weights = np.zeros(len(unit))
    # The vectors are short: BLAS threads cost more than they bring, twentyfold on a busy machine.
    with threadpool_limits(limits=1, user_api="blas"):
        here = look(weights, problem.curvature / KEPT)
        for _ in range(max_iterations):
            gradient = here.gradient + weights
            if not len(unit) or np.abs(gradient / unit).max() <= tolerance:
                break
            found = _walk(look, weights, here, gradient)
            if found is None:
                break
            weights, here = found
    return weights


def _walk(
    look: Look, weights: FloatArray, here: Local, gradient: FloatArray
) -> tuple[FloatArray, Local] | None:
    """Go where the function is less; None if rounding hides whether it is."""
    step = _step(here, gradient)
    least = here.curvature / KEPT
    value, slope = _penalised(here, weights), float(gradient @ step)
    while True:
        there = weights + step
        found = look(there, least)
        if _penalised(found, there) <= value + 1e-4 * slope:
            return there, found
        if -slope <= ROUNDING * abs(value):
            flatter = np.linalg.norm(found.gradient + there) < np.linalg.norm(gradient)
            return (there, found) if flatter else None
        step, slope = step / 2, slope / 2


def _penalised(local: Local, weights: FloatArray) -> float:
    return local.value + float(weights @ weights) / 2


def _step(here: Local, gradient: FloatArray) -> FloatArray:
    columns = here.rows.T

    def bend(step: FloatArray) -> FloatArray:
        bent: FloatArray = columns @ (here.strengths * (here.rows @ step)) + step
        return bent

    size = len(gradient)
    operator = LinearOperator((size, size), matvec=bend, dtype=np.float64)
    step: FloatArray = cg(operator, -gradient, rtol=RESIDUAL)[0]
    return step
