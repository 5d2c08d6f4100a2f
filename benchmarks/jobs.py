"""Following commands with two processes against one: ``python -m benchmarks.jobs``.

Wall time of Table 3 with annotated SDCs, training included; both cores should be idle.
"""

from __future__ import annotations

import sys
import time

from benchmarks.timing import row, show
from corpus_tools.runtime.parallel import Workers
from eval.table_3.end_to_end import run as table_3


def main(corpus: str) -> None:
    print(f"Table 3 of the corpus {corpus}, annotated SDCs")
    seconds, outcomes = {}, {}
    for jobs in (1, 2):
        start = time.perf_counter()
        result = table_3(corpus, corpus, configurations=("gold",), workers=Workers(jobs))
        seconds[jobs], outcomes[jobs] = time.perf_counter() - start, result.outcomes
        show(f"{jobs} at a time", seconds[jobs], "s", f"{len(outcomes[jobs]['gold'])} commands")
    assert outcomes[1] == outcomes[2]
    row("Table 3, two jobs", f"{seconds[2]:.0f} s", f"{seconds[2] / seconds[1]:.2f} of one job")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "warehouse")
