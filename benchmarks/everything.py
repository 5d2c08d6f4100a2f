"""All measurements of the README, one after the other: ``python -m benchmarks.everything``.

It takes hours, most of them for simulated corpora and for scikit-learn on a million examples.
Simulated corpora and shards are kept in a folder; a run begun again makes what is missing there.
``--quick`` measures what grows and what peers do, in about twelve minutes on an idle machine.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import re
import shlex
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from benchmarks.timing import MEASURED

SEEDS = (101, 102, 103, 104, 105, 107, 108)
"""Of the simulated corpora."""
PAGE = Path(__file__).with_name("README.md")
MARKS = ("<!-- measured in one run -->", "<!-- until here -->")
"""``--write`` replaces what stands between them."""


def commands(folder: Path, slu_core: Path | None) -> Iterator[list[str]]:
    """What is run, in order."""
    bench = [sys.executable, "-m"]
    yield [*bench, "benchmarks", *(["--slu-core", str(slu_core)] if slu_core else [])]
    yield [*bench, "benchmarks.rendering"]
    yield [*bench, "benchmarks.cold_start"]
    yield [*bench, "benchmarks.installed_size"]
    yield [*bench, "benchmarks.own_rooms"]
    yield [*bench, "benchmarks.inference"]
    yield [*bench, "benchmarks.jobs"]
    yield [*bench, "benchmarks.cluster"]
    yield [*bench, "benchmarks.script_execution", "--generated", "200"]
    yield [*bench, "benchmarks.episodes"]
    yield [*bench, "benchmarks.corpus_counting"]
    yield [*bench, "benchmarks.growth"]
    yield [*bench, "benchmarks.peers", "--folder", str(folder / "peers")]
    yield [*bench, "benchmarks.app_requests"]
    yield [*bench, "benchmarks.app"]
    alone = ["--databases", "sqlite", "--processes", "1", "--think", "5"]
    yield [*bench, "benchmarks.app", *alone]
    yield [*bench, "benchmarks.app_submissions", "--workers", "600"]
    yield [*bench, "benchmarks.app_rooms"]
    yield [*bench, "benchmarks.app_leases"]
    yield [*bench, "benchmarks.app_dashboard"]
    yield [*bench, "benchmarks.app_watched"]
    yield [*bench, "benchmarks.app_watched", "--processes", "2"]
    yield [*bench, "benchmarks.segment_designs"]
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


def quick(
    folder: Path, corpus: str, slu_core: Path | None, beside: Path | None
) -> Iterator[list[str]]:
    """What is run to see how the toolkit grows, and what peers take."""
    bench = [sys.executable, "-m"]
    imported = ["--slu-core", str(slu_core)] if slu_core else []
    turns = ["--beside", str(beside)] if beside else []
    yield [*bench, "benchmarks.installed_size"]
    yield [*bench, "benchmarks.app_leases", "--databases", "sqlite"]
    many = ["--workers", "50", "--slots", "15000", "--each", "20", "--at-once", "50"]
    yield [*bench, "benchmarks.app_submissions", "--databases", "sqlite", *many, *turns]
    answers = ["--answers", "1000", "100000"]
    yield [*bench, "benchmarks.app_dashboard", "--databases", "sqlite", *answers]
    yield [*bench, "benchmarks.app_watched"]
    yield [*bench, "benchmarks.app_watched", "--processes", "2"]
    yield [*bench, "benchmarks.growth", corpus, "--times", "1", "10", "100", *imported]
    yield [*bench, "benchmarks.corpus_counting", corpus, "--times", "1", "10", "100"]
    yield [*bench, "benchmarks.cold_start", "--runs", "3", *turns]
    yield [*bench, "benchmarks.rendering", "--jobs", "1", "--frames", "100"]
    yield [*bench, "benchmarks.cluster"]
    yield [*bench, "benchmarks.peers", "--each", "4", "--folder", str(folder / "peers")]
    crowd = ["--workers", "1000", "--processes", "4", "--think", "15", "--no-kill"]
    crowd += ["--seconds", "90", "--warm-up", "30"]
    yield [*bench, "benchmarks.app", "--databases", "postgresql", *crowd]


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


def table(lines: Iterable[str]) -> str:
    """What was measured beside what it should reach, in Markdown."""
    rows = (json.loads(line) for line in lines)
    body = "".join(f"| {' | '.join(row)} |\n" for row in rows)
    return f"| What | Measured | Aim | Reached |\n|---|---|---|---|\n{body}"


def write(page: Path, block: str) -> None:
    """Put a block between the two marks of a page."""
    text = page.read_text(encoding="utf-8")
    begin, end = MARKS
    if len(re.findall(f"(?s){begin}.*{end}", text)) != 1:
        raise SystemExit(f"{page} needs the lines {begin} and {end} once")
    new = f"{begin}\n{block}\n{end}"
    page.write_text(re.sub(f"(?s){begin}.*{end}", lambda _: new, text), encoding="utf-8")


def machine(command: Sequence[str], seconds: float) -> str:
    """What was run, when and where."""
    return (
        f"`{shlex.join(command)}`: {seconds / 60:.0f} minutes, {time.strftime('%Y-%m-%d')}, "
        f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f} at the end, "
        f"Python {platform.python_version()}.\n"
    )


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.everything", description=__doc__)
    parser.add_argument(
        "--folder", type=Path, default=Path("benchmark-data"), help="what is made (benchmark-data)"
    )
    parser.add_argument("--slu-core", type=Path, metavar="PATH", help="the data of slu_core")
    parser.add_argument("--only", default="", metavar="TEXT", help="commands that contain this")
    parser.add_argument("--quick", action="store_true", help="growth and peers alone")
    parser.add_argument("--corpus", default="warehouse", help="with --quick, what is repeated")
    parser.add_argument("--beside", type=Path, metavar="PATH", help="with --quick: a checkout")
    parser.add_argument("--list", action="store_true", help="show the commands, run nothing")
    parser.add_argument("--write", action="store_true", help="put the table into the README")
    given = parser.parse_args()
    every = commands(given.folder, given.slu_core)
    if given.quick:
        every = quick(given.folder, given.corpus, given.slu_core, given.beside)
    chosen = [command for command in every if given.only in shlex.join(command)]
    if given.list:
        print(*(shlex.join(["python", *command[1:]]) for command in chosen), sep="\n")
        return
    with tempfile.TemporaryDirectory() as name:
        measured, start = Path(name) / "measured", time.perf_counter()
        measured.touch()
        os.environ[MEASURED] = str(measured)
        failed = run(chosen)
        reached = table(measured.read_text(encoding="utf-8").splitlines())
        print(f"\n{reached}")
        if given.write:
            # Paths of one machine say nothing to others.
            said = [Path(word).name if "/" in word else word for word in sys.argv[1:]]
            command = ["python", "-m", "benchmarks.everything", *said]
            text = f"{machine(command, time.perf_counter() - start)}\n{reached}"
            write(PAGE, text + f"\n{failed} of the benchmarks failed.\n" * bool(failed))
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
