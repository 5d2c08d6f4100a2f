"""Features and training against scikit-learn's: ``python -m benchmarks.learning CORPUS``.

Both trainings stop at the same gradient of the same objective, on the same matrix. Their times are
of the processor.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from functools import partial

import numpy as np
from sklearn.linear_model import LogisticRegression
from threadpoolctl import threadpool_limits

from benchmarks.timing import best, best_of, growth, row, show
from corpus_tools.importers.authored.bundled import open_corpus
from g3.features.feature_registry import FeatureSet, select
from g3.features.matrix import fit_space, transform
from g3.groundings import FloatArray
from g3.learning import crf
from g3.learning.examples import Example, examples, to_batch
from g3.learning.factor_matrix import matrix_of_examples

TIMES = (1, 2, 4, 8, 16)
L2, TOLERANCE = 1.0, 1e-4


def main(corpus: str) -> None:
    items, sets = examples(open_corpus(corpus).annotations), select()
    print(f"{len(items)} examples")
    features(items, sets)
    training(items, sets)


def features(items: list[Example], sets: tuple[FeatureSet, ...]) -> None:
    packing, batch = best(lambda: to_batch(items))
    fitting, (space, matrix) = best(lambda: fit_space(batch, sets))
    seconds = []
    for times in TIMES:
        larger = batch.take(np.tile(np.arange(len(items)), times))
        seconds.append(best(partial(transform, larger, sets, space))[0])
        show(f"{times * len(items)} candidates", 1e6 * seconds[-1] / len(larger), "µs each")
    rate = len(items) / (packing + fitting)
    what = f"features of {len(items)} examples ({matrix.shape[1]})"
    row(what, f"{rate:,.0f} examples/s", f"grows with candidates to {growth(TIMES, seconds):.2f}")


def training(items: list[Example], sets: tuple[FeatureSet, ...]) -> None:
    factors = matrix_of_examples(items, sets)
    matrix, correct = factors.matrix, factors.correct
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
