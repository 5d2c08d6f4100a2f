"""The weights where a convex sum over many factors is least, by SciPy's optimisers.

A step needs the value and the gradient of all factors, so that the optimum is that of all. Of the
curvature, which Newton's method uses, an estimate is enough: what it lacks makes steps worse, not
the optimum. Near the optimum most factors are decided, and few have curvature at all.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Literal

import numpy as np
from scipy import sparse
from threadpoolctl import threadpool_limits

from g3.groundings import FloatArray
from g3.short_repr import short_repr

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
