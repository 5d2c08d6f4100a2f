"""Growth with the size of a corpus: ``python -m benchmarks.growth CORPUS``.

The corpus is repeated under new ids, and each command runs in a process of its own. The exponent
is that of a power of the corpus's size: 1 grows with it, 0 is flat.
"""

from __future__ import annotations

import argparse
import os
import tempfile
from dataclasses import replace
from pathlib import Path

from benchmarks.timing import growth, in_own_process, row
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.importers.authored.bundled import resolve

ALONE = """
import json, sys, time
from benchmarks.timing import most_mib
from corpus_tools.cli.console import run
status = run(sys.argv[1:])
print(json.dumps([time.process_time(), most_mib()]))
sys.exit(status)
"""


def repeated(corpus: Corpus, times: int) -> Corpus:
    """Return a corpus with all its commands, annotations and judgments several times."""
    rounds = range(times)
    said = (replace(c, id=f"{c.id}-{i}") for i in rounds for c in corpus.commands.values())
    commands = {c.id: c for c in said}
    annotations = tuple(
        replace(a, id=f"{a.id}-{i}", command=commands[f"{a.command.id}-{i}"])
        for i in rounds
        for a in corpus.annotations
    )
    judgments = tuple(replace(j, id=f"{j.id}-{i}") for i in rounds for j in corpus.judgments)
    return replace(corpus, commands=commands, annotations=annotations, judgments=judgments)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, prog="python -m benchmarks.growth")
    parser.add_argument("corpus", nargs="?", default="warehouse", help="a folder (warehouse)")
    parser.add_argument("--times", type=int, nargs="+", default=[1, 10, 100])
    given = parser.parse_args()
    print(f"{given.corpus}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}")
    original = Corpus.load(resolve(given.corpus))
    spent: dict[str, list[tuple[float, float]]] = {"ct corpus stats": [], "ct train g3": []}
    with tempfile.TemporaryDirectory() as name:
        model = str(Path(name) / "model.npz")
        for times in given.times:
            corpus = Path(name) / str(times)
            repeated(original, times).save(corpus)
            for what, own in spent.items():
                options = ["--corpus", str(corpus), "--out", model]
                arguments = [str(corpus)] if what == "ct corpus stats" else options
                own.append(in_own_process("-c", ALONE, *what.split()[1:], *arguments))
    for what, own in spent.items():
        seconds, mib = zip(*own, strict=True)
        row(
            f"{what}, corpus × {', × '.join(map(str, given.times))}",
            "; ".join(f"{s:.1f} s, {m:.0f} MiB" for s, m in own),
            f"time grows to {growth(given.times, seconds):.2f}, "
            f"memory to {growth(given.times, mib):.2f}",
        )


if __name__ == "__main__":
    main()
