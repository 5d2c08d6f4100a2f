"""A Dask cluster of two workers on this machine: ``python -m benchmarks.cluster``.

Videos, shards and Table 3 are made by this process and by the cluster. The results must be the
same. Scheduler and workers run in processes of their own, and their start doesn't count.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

from benchmarks.timing import aim, heading, show
from corpus_tools.cli.console import run
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.corpus_writing import write_corpus
from corpus_tools.corpus.encoding import make_corpus
from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.runtime.parallel import Workers
from eval.table_3.end_to_end import run as table_3

WORKERS = 2
SCENARIOS = 4
"""Of Table 3, so that it takes seconds."""


@contextmanager
def cluster() -> Iterator[str]:
    """The address of a scheduler with its workers."""
    program = [sys.executable, "-m", "distributed.cli.dask_{}"]
    quiet = ["--no-dashboard"]
    start = [*program[:2], program[2].format("scheduler"), "--host", "127.0.0.1", "--port", "0"]
    scheduler = subprocess.Popen(
        [*start, *quiet], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    )
    assert scheduler.stderr is not None
    said = iter(scheduler.stderr.readline, "")
    address = next(line.split()[-1] for line in said if "Scheduler at" in line)
    join = [*program[:2], program[2].format("worker"), address, *quiet]
    workers = subprocess.Popen(
        [*join, "--nworkers", str(WORKERS), "--nthreads", "1"],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[1])},
    )
    try:
        yield address
    finally:
        for process in (workers, scheduler):
            process.terminate()
            process.wait()
        scheduler.stderr.close()


def first_scenarios(corpus: Corpus, count: int) -> Corpus:
    """What was said in some scenarios."""
    chosen = sorted({a.command.scenario for a in corpus.annotations})[:count]
    annotations = [a for a in corpus.annotations if a.command.scenario in chosen]
    return make_corpus(
        "few",
        contexts={a.context.id: a.context for a in annotations}.values(),
        commands={a.command.id: a.command for a in annotations}.values(),
        annotations=annotations,
        source=corpus.source,
        licence=corpus.licence,
    )


def contents(folder: Path) -> Mapping[str, bytes]:
    """All files of a folder, by their names in it."""
    files = (path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


def by_command(arguments: Sequence[str], folder: Path, address: str) -> tuple[float, float, bool]:
    """Seconds of a command here and on the cluster, and whether it makes the same files."""
    seconds = []
    for name, where in (("here", []), ("there", ["--scheduler", address])):
        start = time.perf_counter()
        status = run([*arguments, "--out", str(folder / name), *where])
        assert status == 0
        seconds.append(time.perf_counter() - start)
    here, there = seconds
    return here, there, contents(folder / "here") == contents(folder / "there")


def by_table(corpus: str, address: str) -> tuple[float, float, bool]:
    """The same of Table 3 with annotated SDCs."""
    seconds, outcomes = [], []
    for workers in (Workers(), Workers(scheduler=address)):
        start = time.perf_counter()
        outcomes.append(table_3(corpus, corpus, configurations=("gold",), workers=workers).outcomes)
        seconds.append(time.perf_counter() - start)
    here, there = seconds
    return here, there, outcomes[0] == outcomes[1]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, prog="python -m benchmarks.cluster")
    parser.add_argument("--corpus", default="warehouse", help="a corpus (default: warehouse)")
    given = parser.parse_args()
    heading(f"One process, and a cluster of {WORKERS} workers; load {os.getloadavg()[0]:.1f}")
    with tempfile.TemporaryDirectory() as name, cluster() as address:
        folder = Path(name)
        few = first_scenarios(open_corpus(given.corpus), SCENARIOS)
        write_corpus(few, folder / "few")
        videos = ["render-videos", "--only", "dock_p*", "--quality", "draft", "--size", "320x240"]
        found = {
            "videos": by_command(videos, folder / "videos", address),
            "features (ct shards)": by_command(["shards", given.corpus], folder / "s", address),
            "Table 3": by_table(str(folder / "few"), address),
        }
    for what, (here, there, same) in found.items():
        show(f"{what}, one process", here, "s")
        show(f"{what}, the cluster", there, "s", "same result" if same else "another result")
        measured = (
            f"{there:.1f} s, one process {here:.1f}; {'the same' if same else 'another'} result"
        )
        aim(
            f"a Dask cluster of two local workers: {what}",
            measured,
            "the same result",
            reached=same,
        )


if __name__ == "__main__":
    main()
