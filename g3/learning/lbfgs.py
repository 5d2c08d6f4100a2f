"""L-BFGS, as the paper trains (section 3.2): more passes than Newton's method, less memory."""

from __future__ import annotations

import numpy as np
from threadpoolctl import threadpool_limits

from g3.groundings import FloatArray
from g3.learning.newton import ROUNDING, Problem


def minimise(problem: Problem, *, tolerance: float, max_iterations: int) -> FloatArray:
    """Where a problem's sum is least, from 0.

    Parameters
    ----------
    tolerance
        Stop when no component of the gradient exceeds it.
    max_iterations
        Stop after so many steps all the same.
    """
    weights = np.zeros(len(problem.unit))
    if not len(weights):
        return weights
    from scipy import optimize  # noqa: PLC0415 - a fifth of a second, which only training waits for

    slope = weights

    def objective(weights: FloatArray) -> tuple[float, FloatArray]:
        nonlocal slope
        local = problem.look(weights, np.inf)
        slope = local.gradient + weights
        return local.value + float(weights @ weights) / 2, slope

    def stop_if_flat(xk: FloatArray) -> None:
        if np.abs(slope / problem.unit).max() <= tolerance:
            raise StopIteration

    # The vectors are short: BLAS threads cost more than they bring, twentyfold on a busy machine.
    with threadpool_limits(limits=1, user_api="blas"):
        result = optimize.minimize(
            objective,
            weights,
            jac=True,
            method="L-BFGS-B",
            callback=stop_if_flat,
            options={
                "maxiter": max_iterations,
                "gtol": tolerance * float(problem.unit.min()),
                "ftol": ROUNDING,
                "maxls": 50,
            },
        )
    found: FloatArray = result.x
    return found
