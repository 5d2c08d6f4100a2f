"""Agreement of two annotators of the treebank: ``python -m benchmarks.treebank``.

A tenth of the commands in ``datasets/treebank`` was annotated twice, independently. How far the two
agree is the most that a parser can reach. ``benchmarks.encoder --hold-out``
measures the parser on people that it has not seen.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from pathlib import Path
from typing import TypeAlias

from corpus_tools.importers.treebank import read_second_trees, read_treebank
from eval.parsing.sdc_scores import Counts, compare
from g3.sdc.clauses import SDC

FOLDER = Path(__file__).parents[1] / "datasets" / "treebank"
Trees: TypeAlias = tuple[SDC, ...]


def score(pairs: Iterable[tuple[Trees, Trees, str]]) -> str:
    """Return typed F, exact matches and the number of pairs of trees, as text."""
    compared = [compare(*pair) for pair in pairs]
    typed = sum((one.typed for one in compared), Counts())
    exact = sum(one.exact for one in compared) / len(compared)
    return f"typed F {typed.f.value:.3f}, exact {exact:.3f}, {len(compared)} commands"


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.treebank", description=__doc__)
    parser.parse_args()
    commands = {command.id: command for command in read_treebank(FOLDER)}
    twice = read_second_trees(FOLDER)
    pairs = ((commands[name].trees, trees, commands[name].text) for name, trees in twice.items())
    print(f"two annotators: {score(pairs)}")


if __name__ == "__main__":
    main()
