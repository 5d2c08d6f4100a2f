"""Features of all examples, and how the time grows with the number of candidates."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np
from scipy import sparse

from benchmarks.timing import best, heading, show
from g3.features.feature_registry import select
from g3.features.matrix import fit_space, transform
from g3.learning.examples import Example, to_batch

TIMES = (1, 2, 4, 8, 16)


def run(items: Sequence[Example]) -> sparse.csr_array:
    """Measure on examples; return their matrix."""
    heading(f"Features of {len(items)} examples")
    sets = select()
    packing, batch = best(lambda: to_batch(items))
    fitting, (space, matrix) = best(lambda: fit_space(batch, sets))
    show("pack", packing, "s")
    show("extract", fitting, "s", f"{matrix.shape[1]} features, {matrix.nnz} active")
    show("pack and extract", packing + fitting, "s")
    show("examples a second", len(items) / (packing + fitting), "1/s")

    print("  growth with the number of candidates (1 is linear):")
    one = 0.0
    for times in TIMES:
        rows = np.tile(np.arange(len(items)), times)
        larger = batch.take(rows)
        seconds, _ = best(partial(transform, larger, sets, space))
        each = seconds / len(rows)
        one = one or each
        show(f"  {len(rows)} candidates", 1e6 * each, "µs each", f"{each / one:.2f} of the first")
    return matrix
