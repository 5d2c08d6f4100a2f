"""L-BFGS, as all training here uses it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from threadpoolctl import threadpool_limits

from g3.groundings import FloatArray


def lbfgs(
    objective: Callable[[FloatArray], tuple[float, FloatArray]], start: FloatArray, **options: Any
) -> FloatArray:
    """Minimise a function; shape (parameters,).

    Parameters
    ----------
    objective
        The function's value and gradient at a point, shape (parameters,).
    **options
        SciPy's options, such as ``maxiter`` (:func:`scipy.optimize.minimize`).
    """
    from scipy import optimize  # noqa: PLC0415 - a fifth of a second, which only training waits for

    how: Any = options  # SciPy's stubs want every name written out
    # The vectors are short: BLAS threads cost more than they bring, twentyfold on a busy machine.
    with threadpool_limits(limits=1, user_api="blas"):
        found = optimize.minimize(objective, start, jac=True, method="L-BFGS-B", options=how)
    return found.x
