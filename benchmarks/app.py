"""The annotation app under many workers: ``python -m benchmarks.app``.

Real servers and bad connections, as in the tests (``tests.annotation_app.load``), with a time limit
and with figures. ``--think 0`` shows how much the servers can do. What the servers, PostgreSQL and
the workers' own program take of the processor is counted apart (from /proc, so on Linux only). It
needs the extra ``test``.
"""

from __future__ import annotations

import argparse
import math
import os
import tempfile
from collections import Counter
from pathlib import Path

import numpy as np

from annotation_app.core.config import open_instance
from benchmarks.timing import row
from tests.annotation_app.load import Tally, check, run_load
from tests.annotation_app.load_servers import new_databases
from tests.annotation_app.rendered import render

VIDEOS = 6


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, prog="python -m benchmarks.app")
    parser.add_argument("--workers", type=int, default=200)
    parser.add_argument("--processes", type=int, nargs="+", default=[1, 4])
    parser.add_argument("--think", type=float, default=15.0, help="mean seconds between requests")
    parser.add_argument("--no-kill", action="store_true", help="leave the servers alone")
    parser.add_argument("--databases", nargs="+", default=["sqlite", "postgresql"])
    parser.add_argument("--seconds", type=float, default=math.inf, help="nobody sends after that")
    given = parser.parse_args()

    print(f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}, {given.workers} workers")
    with tempfile.TemporaryDirectory() as folder:
        videos = render(Path(folder) / "videos", tuple(f"video{i}" for i in range(VIDEOS)))
        for kind in given.databases:
            with new_databases(kind) as new:
                for processes in given.processes:
                    config = open_instance(Path(folder) / f"{kind}-{processes}", new())
                    tally = run_load(
                        config,
                        videos,
                        workers=given.workers,
                        answers=max(1, given.workers // 4),
                        processes=processes,
                        think_s=given.think,
                        kills=0 if given.no_kill else 1,
                        seconds=given.seconds,
                    )
                    states = check(config, tally, whole=given.seconds == math.inf)
                    _report(f"{kind}, {processes} processes", tally, states, given)


def _report(title: str, tally: Tally, states: Counter[str], given: argparse.Namespace) -> None:
    every = [s for values in tally.seconds.values() for s in values]
    each = ", ".join(f"{n} {1000 * s / len(every):.1f} ms" for n, s in tally.processor.items())
    print(f"\n{title}: {dict(states)}; {dict(tally.broken)}")
    p50, p95 = 1000 * np.percentile(every, [50, 95])
    rate, answers = len(every) / tally.wall_s, len(tally.acknowledged) / tally.wall_s
    row(
        f"{given.workers} workers, {given.think:g} s to think, {title}",
        f"p50 {p50:.0f} ms, p95 {p95:.0f} ms at {rate:.0f} requests/s, {answers:.0f} answers/s",
        f"processor time of each: {each}",
    )


if __name__ == "__main__":
    main()
