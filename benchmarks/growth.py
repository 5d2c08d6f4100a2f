"""What grows with a corpus: ``python -m benchmarks.growth CORPUS``.

The corpus is repeated under new ids, and each command runs in a process of its own. The exponent
is that of a power of the corpus's size: 1 grows with it, 0 is flat.
"""

from __future__ import annotations

import argparse
import os
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from benchmarks.corpus_counting import repeated
from benchmarks.timing import aim, in_own_process
from corpus_tools.corpus.corpus_reading import load_corpus
from corpus_tools.corpus.corpus_writing import write_corpus
from corpus_tools.importers.authored.bundled import resolve


def commands(corpus: Path, folder: Path) -> Iterator[tuple[str, list[str]]]:
    """What is measured, with its arguments."""
    yield STATS, ["corpus", "stats", str(corpus)]
    model = str(folder / "model.npz")
    yield TRAIN, ["train", "g3", "--corpus", str(corpus), "--out", model]


STATS, TRAIN = "ct corpus stats", "ct train g3"
REACH = {STATS: ("a third of 27 s at × 100, flat", 100), TRAIN: ("512 MiB at × 10", 10)}
"""What is aimed at, and at how many times the corpus."""
ALONE = """
import json, sys, time
from benchmarks.timing import most_mib
from corpus_tools.cli.console import run
start = time.perf_counter()
status = run(sys.argv[1:])
wall_s = time.perf_counter() - start
print(json.dumps([time.process_time(), wall_s, most_mib()]))
sys.exit(status)
"""


def spent(arguments: Sequence[str]) -> tuple[float, float, float]:
    """Processor seconds with the start, seconds without it, and the most MiB of a command."""
    seconds, wall_s, mib = in_own_process("-c", ALONE, *arguments)
    return seconds, wall_s, mib


def exponent(times: Sequence[int], values: Sequence[float]) -> float:
    """Of the power of `times` that is nearest to the values."""
    return float(np.polyfit(np.log(times), np.log(values), 1)[0]) if len(times) > 1 else np.nan


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, prog="python -m benchmarks.growth")
    parser.add_argument("corpus", nargs="?", default="warehouse", help="a folder (warehouse)")
    parser.add_argument("--times", type=int, nargs="+", default=[1, 10])
    parser.add_argument("--slu-core", type=Path, metavar="PATH", help="measure its import, too")
    given = parser.parse_args()
    print(f"{given.corpus}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}\n")
    found: dict[str, list[tuple[float, float, float]]] = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if given.slu_core:
            imported = [
                "import",
                "slu-core",
                str(given.slu_core),
                "--out",
                str(folder / "imported"),
            ]
            seconds, wall_s, mib = spent(imported)
            took = f"{wall_s:.1f} s; processor time {seconds:.1f} s, {mib:.0f} MiB"
            why = "it takes both cores: other programs slow it"
            aim(
                "import of the paper's corpus",
                took,
                "2 s with two cores",
                reached=wall_s <= 2,
                reason=why,
            )
        original = load_corpus(resolve(given.corpus))
        for times in given.times:
            write_corpus(repeated(original, times), folder / f"{times}")
            for what, arguments in commands(folder / f"{times}", folder):
                found.setdefault(what, []).append(spent(arguments))
    heads = " | ".join(f"× {times}" for times in given.times)
    print(f"| | {heads} | exponent of time; memory |")
    print("|---|" + "---:|" * (len(given.times) + 1))
    for what, measured in found.items():
        cells = " | ".join(f"{s:.1f} s, {mib:.0f} MiB" for s, _, mib in measured)
        time_, memory = (exponent(given.times, [one[i] for one in measured]) for i in (0, 2))
        print(f"| {what} | {cells} | {time_:.2f}; {memory:.2f} |")
        grows = f"{cells.replace(' |', ';')}; exponents {time_:.2f}; {memory:.2f}"
        reach, size = REACH[what]
        if size in given.times:
            seconds, _, mib = measured[given.times.index(size)]
            reached = {STATS: seconds <= 9 and not memory > 0.1, TRAIN: mib <= 512}[what]
            name = f"{what}, corpus × {', × '.join(map(str, given.times))}"
            aim(name, grows, reach, reached=reached)


if __name__ == "__main__":
    main()
