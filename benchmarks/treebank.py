"""Agreement of two annotators of the treebank: ``python -m benchmarks.treebank``.

A tenth of the commands in ``datasets/treebank`` was annotated twice, independently. How far the two
agree is the most that a parser can reach. With ``--parser`` the bundled extractor is measured on
all commands, too, of which it has learned none.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, TypeAlias

from eval.parsing.sdc_scores import Counts, compare
from g3.language.parsing.parser import parse
from g3.sdc.clauses import SDC
from g3.sdc.sdc_notation import parse_brackets

FOLDER = Path(__file__).parents[1] / "datasets" / "treebank"
Trees: TypeAlias = tuple[SDC, ...]


def rows(name: str) -> list[dict[str, Any]]:
    """Read a file of the treebank."""
    lines = (FOLDER / name).read_text("utf-8").split("\n")
    return [json.loads(line) for line in lines if line]


def trees_of(row: Mapping[str, Any], text: str) -> Trees:
    """Return the trees of a row; an empty tuple for a command that asks for nothing."""
    return parse_brackets("\n".join(row["trees"]), command=text) if row["trees"] else ()


def score(pairs: Iterable[tuple[Trees, Trees, str]]) -> str:
    """Return typed F, exact matches and the number of pairs of trees, as text."""
    compared = [compare(*pair) for pair in pairs]
    typed = sum((one.typed for one in compared), Counts())
    exact = sum(one.exact for one in compared) / len(compared)
    return f"typed F {typed.f.value:.3f}, exact {exact:.3f}, {len(compared)} commands"


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.treebank", description=__doc__)
    parser.add_argument("--parser", action="store_true", help="measure the bundled extractor, too")
    options = parser.parse_args()
    first = {row["id"]: row for row in rows("trees.jsonl")}
    twice = [(first[row["id"]], row) for row in rows("second.jsonl")]
    pairs = ((trees_of(a, a["text"]), trees_of(b, a["text"]), a["text"]) for a, b in twice)
    print(f"two annotators: {score(pairs)}")
    if options.parser:
        parsed = (
            (parse(row["text"]).trees[0].sdcs, trees_of(row, row["text"]), row["text"])
            for row in first.values()
        )
        print(f"the bundled extractor: {score(parsed)}")


if __name__ == "__main__":
    main()
