"""Training against scikit-learn's on the same matrix, objective and tolerance."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy import sparse
from threadpoolctl import threadpool_limits

from benchmarks.timing import best_of, heading, show
from g3 import crf
from g3.crf import BoolArray
from g3.groundings import FloatArray

L2 = 1.0
TOLERANCE = 1e-4


def run(matrix: sparse.csr_array, correct: BoolArray) -> None:
    heading(f"Training on {matrix.shape[0]} examples with {matrix.shape[1]} features")
    try:
        from sklearn.linear_model import LogisticRegression  # noqa: PLC0415 - may be missing
    except ImportError:
        print("  (left out: scikit-learn is not installed)")
        return
    # scikit-learn's objective is ours divided by n, and so is its gradient.
    theirs = LogisticRegression(
        C=1 / L2, fit_intercept=False, solver="lbfgs", tol=TOLERANCE / len(correct), max_iter=10_000
    )

    def scikit_learn() -> FloatArray:
        weights: FloatArray = theirs.fit(matrix, correct).coef_.ravel()
        return weights

    def one_thread() -> FloatArray:
        with threadpool_limits(limits=1, user_api="blas"):
            return scikit_learn()

    actions: dict[str, Callable[[], FloatArray]] = {
        "ours": lambda: crf.train(matrix, correct, l2=L2, tolerance=TOLERANCE),
        "scikit-learn": scikit_learn,
        "scikit-learn, one BLAS thread": one_thread,
    }
    results = best_of(actions)
    ours, weights = results.pop("ours")
    objective = crf.Objective(matrix, correct, L2)
    show("ours", ours, "s", f"objective {objective(weights)[0]:.8g}")
    for name, (seconds, other) in results.items():
        show(name, seconds, "s", f"objective {objective(other)[0]:.8g}")
        show(f"ours / {name}", ours / seconds, "")
        difference = abs(objective(weights)[0] / objective(other)[0] - 1)
        show("  relative difference of the objectives", difference, "")
        show("  largest difference of a weight", float(np.abs(weights - other).max()), "")
