"""All measurements of the README, one after the other: ``python -m benchmarks.everything``.

It takes hours, most of them for simulated corpora and for scikit-learn on a million examples.
Simulated corpora and shards are kept in a folder; a run begun again makes what is missing there.
"""

from __future__ import annotations

import argparse
import shlex
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

SEEDS = (101, 102, 103, 104, 105, 107, 108)
"""Of the simulated corpora."""


def commands(folder: Path, slu_core: Path | None) -> Iterator[list[str]]:
    """What is run, in order."""
    bench = [sys.executable, "-m"]
    yield [*bench, "benchmarks", *(["--slu-core", str(slu_core)] if slu_core else [])]
    yield [*bench, "benchmarks.rendering"]
    yield [*bench, "benchmarks.cold_start"]
    yield [*bench, "benchmarks.own_rooms"]
    yield [*bench, "benchmarks.inference"]
    yield [*bench, "benchmarks.jobs"]
    yield [*bench, "benchmarks.script_execution", "--generated", "200"]
    yield [*bench, "benchmarks.episodes"]
    yield [*bench, "benchmarks.corpus_counting"]
    yield [*bench, "benchmarks.app_requests"]
    yield [*bench, "benchmarks.app"]
    alone = ["--databases", "sqlite", "--processes", "1", "--think", "5"]
    yield [*bench, "benchmarks.app", *alone]
    yield [*bench, "benchmarks.app_submissions", "--workers", "600"]
    yield [*bench, "benchmarks.app_rooms"]
    yield [*bench, "benchmarks.app_leases"]
    yield [*bench, "benchmarks.app_dashboard"]
    corpora = [folder / "simulated" / str(seed) for seed in SEEDS]
    simulate = [*bench, "corpus_tools", "simulate-workers", "describe", "--scenarios", "10"]
    simulate += ["--commands", "1660", "--workers", "1660"]
    for seed, corpus in zip(SEEDS, corpora, strict=True):
        yield [*simulate, "--seed", str(seed), "--out", str(corpus)]
    shards = ["--folder", str(folder / "shards")]
    yield [*bench, "benchmarks.shards", *map(str, corpora), *shards]
    yield _training(folder, "100000", "1e-3")
    yield _training(folder, "1000000", "1e-2")
    yield [*_training(folder, "1000000", "0.1"), "--wordless"]


def _training(folder: Path, examples: str, tolerance: str) -> list[str]:
    training = [sys.executable, "-m", "benchmarks.training", "--shards", str(folder / "shards")]
    return [*training, "--examples", examples, "--tolerance", tolerance]


def run(chosen: Sequence[list[str]]) -> int:
    """Run commands; how many failed."""
    failed: list[str] = []
    for number, command in enumerate(chosen, start=1):
        text = shlex.join(["python", *command[1:]])
        print(f"\n=== {number} of {len(chosen)}: {text}", flush=True)
        start = time.perf_counter()
        status = subprocess.run(command, check=False).returncode
        print(f"=== {time.perf_counter() - start:.0f} s, exit status {status}", flush=True)
        if status:
            failed.append(text)
    print(*(f"failed: {text}" for text in failed), sep="\n")
    return len(failed)


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.everything", description=__doc__)
    parser.add_argument(
        "--folder", type=Path, default=Path("benchmark-data"), help="what is made (benchmark-data)"
    )
    parser.add_argument("--slu-core", type=Path, metavar="PATH", help="the data of slu_core")
    parser.add_argument("--only", default="", metavar="TEXT", help="commands that contain this")
    parser.add_argument("--list", action="store_true", help="show the commands, run nothing")
    given = parser.parse_args()
    chosen = [
        command
        for command in commands(given.folder, given.slu_core)
        if given.only in shlex.join(command)
    ]
    if given.list:
        print(*(shlex.join(["python", *command[1:]]) for command in chosen), sep="\n")
        return
    sys.exit(1 if run(chosen) else 0)


if __name__ == "__main__":
    main()
