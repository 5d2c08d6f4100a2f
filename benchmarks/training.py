"""Training against scikit-learn's, on the same matrix: ``python -m benchmarks.training CORPUS``.

Both stop at the same gradient of the same objective. Processor time.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

from sklearn.linear_model import LogisticRegression
from threadpoolctl import threadpool_limits

from benchmarks.timing import best_of, heading, row, show
from corpus_tools.importers.authored.bundled import open_corpus
from g3.features.feature_registry import select
from g3.groundings import FloatArray
from g3.learning import crf
from g3.learning.examples import examples
from g3.learning.factor_matrix import matrix_of_examples

L2, TOLERANCE = 1.0, 1e-4


def main(corpus: str) -> None:
    factors = matrix_of_examples(examples(open_corpus(corpus).annotations), select())
    matrix, correct = factors.matrix, factors.correct
    heading(f"Training on {matrix.shape[0]} examples with {matrix.shape[1]} features")
    # scikit-learn's objective is ours divided by n, and so is its gradient.
    theirs = LogisticRegression(
        C=1 / L2, fit_intercept=False, solver="lbfgs", tol=TOLERANCE / len(correct), max_iter=10_000
    )

    def scikit_learn() -> FloatArray:
        with threadpool_limits(limits=1, user_api="blas"):
            weights: FloatArray = theirs.fit(matrix, correct).coef_.ravel()
        return weights

    actions: dict[str, Callable[[], FloatArray]] = {
        "ours": lambda: crf.train(matrix, correct, l2=L2, tolerance=TOLERANCE),
        "scikit-learn": scikit_learn,
    }
    results = best_of(actions, clock=time.process_time)
    likelihood = crf.Likelihood(matrix, correct)
    for name, (seconds, weights) in results.items():
        objective = likelihood(weights).value + L2 * float(weights @ weights) / 2
        show(name, seconds, "s", f"objective {objective:.10g}")
    ours, peer = results["ours"][0], results["scikit-learn"][0]
    what = f"training on {matrix.shape[0]} examples, {matrix.shape[1]} features"
    row(what, f"{ours:.2f} s of processor", f"{ours / peer:.2f} of scikit-learn's lbfgs")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "warehouse")
