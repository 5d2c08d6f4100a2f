"""Counting a large corpus: ``python -m benchmarks.corpus_counting CORPUS``.

The corpus is repeated under new ids. Its files are counted line by line, as ``ct corpus stats``
does, and beside it as it is simpler: the corpus is read first. Each is done in a process of its
own, and the figures must be the same.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import msgspec

from benchmarks.timing import aim, heading, in_own_process, most_mib
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.corpus_reading import load_corpus
from corpus_tools.corpus.corpus_statistics import Statistics, statistics
from corpus_tools.corpus.corpus_writing import write_corpus
from corpus_tools.corpus.streamed_statistics import statistics_of_files
from corpus_tools.importers.authored.bundled import resolve

WAYS: Mapping[str, Callable[[Path], Statistics]] = {
    "line by line": statistics_of_files,
    "read first": lambda folder: statistics(load_corpus(folder)),
}


def repeated(corpus: Corpus, times: int) -> Corpus:
    """A corpus with all its commands, annotations and judgments several times."""
    rounds = range(times)
    commands = {
        f"{c.id}-{i}": replace(c, id=f"{c.id}-{i}")
        for i in rounds
        for c in corpus.commands.values()
    }
    annotations = tuple(
        replace(a, id=f"{a.id}-{i}", command=commands[f"{a.command.id}-{i}"])
        for i in rounds
        for a in corpus.annotations
    )
    judgments = tuple(replace(j, id=f"{j.id}-{i}") for i in rounds for j in corpus.judgments)
    return replace(corpus, commands=commands, annotations=annotations, judgments=judgments)


def alone(folder: Path, way: str) -> None:
    """Print the processor seconds, the MiB above those of the start, and the figures."""
    before, start = most_mib(), time.process_time()
    found = WAYS[way](folder)
    seconds = time.process_time() - start
    print(json.dumps([seconds, most_mib() - before, msgspec.to_builtins(found)]))


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, prog="python -m benchmarks.corpus_counting"
    )
    parser.add_argument("corpus", nargs="?", default="warehouse", help="a folder (warehouse)")
    parser.add_argument("--times", type=int, nargs="+", default=[10, 100])
    parser.add_argument("--alone", choices=WAYS, help="one way")
    given = parser.parse_args()
    corpus = resolve(given.corpus)
    if given.alone:
        alone(corpus, given.alone)
        return
    for times in given.times:
        heading(f"{given.corpus}, {times} times")
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "corpus"
            write_corpus(repeated(load_corpus(corpus), times), path)
            said = set()
            spent = {}
            for way in WAYS:
                command = ("-m", "benchmarks.corpus_counting", str(path), "--alone", way)
                seconds, mib, found = in_own_process(*command)
                print(f"  {way:<14}{seconds:7.2f} s{mib:8.0f} MiB")
                spent[way] = seconds, mib
                said.add(json.dumps(found))
            print(f"  the same figures: {len(said) == 1}")
        measured = "; ".join(f"{way} {s:.1f} s, {mib:.0f} MiB" for way, (s, mib) in spent.items())
        (ours_s, ours_mib), (first_s, _) = spent.values()
        aim(
            f"counting a corpus, {times} times",
            measured,
            "a third of the time, memory flat",
            reached=ours_s <= first_s / 3 and ours_mib <= 20,
        )


if __name__ == "__main__":
    main()
