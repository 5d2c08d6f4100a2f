"""Following commands and resampling with two processes beside one: ``python -m benchmarks.jobs``.

Wall time of Table 3 with annotated SDCs, training included, and of 10 000 draws of many clusters;
both cores should be idle.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

from benchmarks.timing import compare, heading, show
from corpus_tools.runtime.parallel import Executor, Workers
from eval.statistics.resampling import resampled_sums
from eval.table_3.end_to_end import run as table_3

CLUSTERS, DRAWS = 50_000, 10_000


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.jobs", description=__doc__)
    parser.add_argument("--corpus", default="warehouse", help="a corpus (default: warehouse)")
    run(parser.parse_args().corpus)


def run(corpus: str = "warehouse") -> None:
    heading(f"Table 3 of the corpus {corpus}, annotated SDCs")
    seconds, outcomes = {}, {}
    for jobs in (1, 2):
        start = time.perf_counter()
        outcomes[jobs] = table_3(
            corpus, corpus, configurations=("gold",), workers=Workers(jobs)
        ).outcomes
        seconds[jobs] = time.perf_counter() - start
        show(
            f"{jobs} job{'s' * (jobs > 1)}",
            seconds[jobs],
            "s",
            f"{len(outcomes[1]['gold'])} commands",
        )
    assert outcomes[1] == outcomes[2]
    compare("following commands, two jobs", "one job", seconds[2] / seconds[1], "0.50: two cores")
    _resampling()


def _resampling() -> None:
    heading(f"{DRAWS} resamples of {CLUSTERS} clusters")
    counts = np.random.default_rng(0).integers(0, 5, (CLUSTERS, 4))
    seconds, sums = {}, {}
    for jobs in (1, 2):
        start = time.perf_counter()
        with Executor(Workers(jobs)) as executor:
            sums[jobs] = resampled_sums(
                counts, rng=np.random.default_rng(0), draws=DRAWS, executor=executor
            )
        seconds[jobs] = time.perf_counter() - start
        show(f"{jobs} job{'s' * (jobs > 1)}", seconds[jobs], "s")
    assert (sums[1] == sums[2]).all()
    compare("resampling, two jobs", "one job", seconds[2] / seconds[1], "0.50: two cores")


if __name__ == "__main__":
    main()
