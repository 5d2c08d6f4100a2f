"""Training against scikit-learn's on the same matrix, objective and tolerance.

``python -m benchmarks.training --shards DIR --examples 1000000`` takes the examples of shards
(:mod:`benchmarks.shards`), each a row of its own for both.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt
from scipy import sparse
from threadpoolctl import threadpool_limits

from benchmarks.timing import best_of, compare, heading, show
from corpus_tools.shards.shard_files import Shard, read_manifest, read_shard
from g3.features.matrix import ALONE
from g3.groundings import FloatArray
from g3.learning import crf
from g3.learning.crf import BoolArray

L2 = 1.0
TOLERANCE = 1e-4


def run(
    matrix: sparse.csr_array,
    correct: BoolArray,
    *,
    tolerance: float = TOLERANCE,
    repeats: int = 3,
    as_it_comes: bool = True,
) -> None:
    heading(f"Training on {matrix.shape[0]} examples with {matrix.shape[1]} features")
    try:
        from sklearn.linear_model import LogisticRegression  # noqa: PLC0415 - may be missing
    except ImportError:
        print("  (left out: scikit-learn is not installed)")
        return
    # scikit-learn's objective is ours divided by n, and so is its gradient.
    theirs = LogisticRegression(
        C=1 / L2, fit_intercept=False, solver="lbfgs", tol=tolerance / len(correct), max_iter=10_000
    )

    def scikit_learn() -> FloatArray:
        weights: FloatArray = theirs.fit(matrix, correct).coef_.ravel()
        return weights

    def one_thread() -> FloatArray:
        with threadpool_limits(limits=1, user_api="blas"):
            return scikit_learn()

    actions: dict[str, Callable[[], FloatArray]] = {
        "ours": lambda: crf.train(matrix, correct, l2=L2, tolerance=tolerance),
        "scikit-learn, one BLAS thread": one_thread,
    }
    if as_it_comes:
        actions["scikit-learn"] = scikit_learn
    results = best_of(actions, repeats, time.process_time)
    ours, weights = results.pop("ours")
    likelihood = crf.Likelihood(matrix, correct)

    def objective(at: FloatArray) -> float:
        return likelihood(at).value + L2 * float(at @ at) / 2

    show("ours", ours, "s", f"objective {objective(weights):.10g}")
    for name, (seconds, other) in results.items():
        show(name, seconds, "s", f"objective {objective(other):.10g}")
        compare("training", name, ours / seconds, "reading the matrix from memory")
        difference = abs(objective(weights) / objective(other) - 1)
        show("  relative difference of the objectives", difference, "")
        show("  largest difference of a weight", float(np.abs(weights - other).max()), "")
    _limit(matrix, likelihood)


def _limit(matrix: sparse.csr_array, likelihood: crf.Likelihood) -> None:
    """One evaluation reads the matrix twice; no machine does that faster than it reads memory."""
    source, target = np.ones(2**24), np.zeros(2**24)
    copying, _ = best_of({"": lambda: np.copyto(target, source)})[""]
    bandwidth = 2 * source.nbytes / copying
    bytes_read = 2 * matrix.nnz * (matrix.data.itemsize + matrix.indices.itemsize)
    seconds, _ = best_of({"": lambda: likelihood(np.zeros(matrix.shape[1]))})[""]
    show("an evaluation of the whole objective", 1e3 * seconds, "ms")
    show("  its bytes at the bandwidth of copying", 1e3 * bytes_read / bandwidth, "ms")


def from_shards(
    folder: Path, examples: int, *, wordless: bool = False
) -> tuple[sparse.csr_array, BoolArray]:
    """The first examples of shards, a row each, in the features that they have together."""
    shards: list[Shard] = []
    total = 0
    for record in read_manifest(folder).shards:
        if total < examples:
            shards.append(read_shard(folder / record.file))
            total += record.examples
    column: dict[tuple[str, str], int] = {}
    features: list[npt.NDArray[np.int32]] = []
    lengths: list[npt.NDArray[np.int32]] = []
    correct: list[BoolArray] = []
    for shard in shards:
        base, word = np.divmod(shard.keys, len(shard.words))
        names = [(shard.bases[b], shard.words[w]) for b, w in zip(base, word, strict=True)]
        own = np.array([column.setdefault(name, len(column)) for name in names], dtype=np.int32)
        kept = np.isin(word, [shard.words.index(ALONE)]) | (not wordless)
        matrix = sparse.csr_array(
            (kept[shard.features].astype(np.int8), shard.features, shard.offsets),
            shape=(len(shard.right), len(names)),
            copy=True,
        )
        matrix.eliminate_zeros()
        rows = np.repeat(np.arange(len(shard.right)), shard.right + shard.wrong)
        for_each = np.repeat(
            np.tile([True, False], len(shard.right)),
            np.column_stack((shard.right, shard.wrong)).reshape(-1),
        )
        each = matrix[rows[: examples - sum(len(part) for part in correct)]]
        features.append(own[each.indices])
        lengths.append(np.diff(each.indptr))
        correct.append(for_each[: each.shape[0]])
    joined = np.concatenate(features)
    features.clear()
    offsets = np.concatenate(([0], np.cumsum(np.concatenate(lengths)))).astype(np.int32)
    shape = (len(offsets) - 1, len(column))
    whole = sparse.csr_array((np.ones(len(joined)), joined, offsets), shape=shape)
    whole.sort_indices()
    return whole, np.concatenate(correct)


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.training", description=__doc__)
    parser.add_argument("--shards", type=Path, required=True)
    parser.add_argument("--examples", type=int, default=1_000_000)
    parser.add_argument("--tolerance", type=float, default=TOLERANCE)
    parser.add_argument(
        "--wordless", action="store_true", help="only base features alone, a third of the memory"
    )
    arguments = parser.parse_args()
    matrix, correct = from_shards(arguments.shards, arguments.examples, wordless=arguments.wordless)
    run(matrix, correct, tolerance=arguments.tolerance, repeats=1, as_it_comes=False)


if __name__ == "__main__":
    main()
