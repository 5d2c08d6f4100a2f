"""Features of a corpus's examples: ``python -m benchmarks.extraction CORPUS``."""

from __future__ import annotations

import sys
from functools import partial

import numpy as np

from benchmarks.timing import best, growth, heading, row, show
from corpus_tools.importers.authored.bundled import open_corpus
from g3.features.feature_registry import select
from g3.features.matrix import fit_space, transform
from g3.learning.examples import examples, to_batch

TIMES = (1, 2, 4, 8, 16)


def main(corpus: str) -> None:
    items, sets = examples(open_corpus(corpus).annotations), select()
    heading(f"Features of {len(items)} examples")
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


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "warehouse")
