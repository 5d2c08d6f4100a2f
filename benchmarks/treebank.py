"""The treebank's annotators, and the parser on unseen people: ``python -m benchmarks.treebank``.

Four hundred commands in ``datasets/treebank`` were annotated twice, independently. How far the two
agree is the most that a parser can reach. Nothing learns from the commands in
``written/unseen_people``, whose writer wrote nothing of the treebank.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from pathlib import Path
from typing import TypeAlias

from corpus_tools.importers.treebank import read_second_trees, read_treebank
from eval.parsing.sdc_scores import Counts, compare
from g3.language.parsing.encoder import default_encoder
from g3.language.parsing.sdc_parser import default_parser, parse_words
from g3.language.parsing.words import cut
from g3.sdc.clauses import SDC

FOLDER = Path(__file__).parents[1] / "datasets" / "treebank"
UNSEEN = Path(__file__).parent / "written" / "unseen_people"
Trees: TypeAlias = tuple[SDC, ...]


def score(pairs: Iterable[tuple[Trees, Trees, str]]) -> str:
    """Return typed F, exact matches and the number of pairs of trees, as text."""
    compared = [compare(*pair) for pair in pairs]
    typed = sum((one.typed for one in compared), Counts())
    exact = sum(one.exact for one in compared) / len(compared)
    return f"typed F {typed.f.value:.3f}, exact {exact:.3f}, {len(compared)} commands"


def main() -> None:
    argparse.ArgumentParser(prog="python -m benchmarks.treebank", description=__doc__).parse_args()
    commands = {command.id: command for command in read_treebank(FOLDER)}
    twice = read_second_trees(FOLDER)
    pairs = ((commands[name].trees, trees, commands[name].text) for name, trees in twice.items())
    print(f"two annotators: {score(pairs)}")
    unseen = read_treebank(UNSEEN)
    parser = default_parser()
    parses = parse_words(default_encoder(), parser.arcs_, (cut(one.text) for one in unseen))
    parsed = zip(parses, unseen, strict=True)
    print(f"parser, unseen people: {score((p.sdcs, one.trees, one.text) for p, one in parsed)}")


if __name__ == "__main__":
    main()
