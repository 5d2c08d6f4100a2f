"""Write ``potentials.csv``, the table of ``potentials.md``, with each potential's record.

The record is in files that ``benchmarks.potentials_off`` writes::

    python -m benchmarks.potentials_off --test aaai11,automatic,warehouse --out corpora.json
    python -m benchmarks.potentials_off --set 02 --set 04 --set 08 --out written.json
    python docs/make_potentials.py corpora.json written.json

Without files the records stay, and the other columns are written.
"""

from __future__ import annotations

import csv
import json
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from g3.inference.potentials.potential_registry import KINDS, Potential, potentials

TABLE = Path(__file__).parent / "contributing/potentials.csv"


def main() -> None:
    """Replace the table."""
    rows = [row for name in sys.argv[1:] for row in json.loads(Path(name).read_text())["rows"]]
    table = [*(_table(rows) if rows else _same_records())]
    with TABLE.open("w", encoding="utf-8", newline="") as stream:
        csv.writer(stream, lineterminator="\n").writerows(table)


def _table(rows: Sequence[Mapping[str, Any]]) -> Iterator[list[str]]:
    sizes = {row["corpus"]: row["n"] for row in rows}
    corpora = [f"{name} ({n})" for name, n in sizes.items()]
    yield ["kind", "name", "what it says", "SDCs", "of", "weight", *corpora, "verdict"]
    for rule in _by_kind():
        by_corpus = {row["corpus"]: row for row in rows if row["name"] == rule.name}
        records = [_cell(by_corpus.get(name)) for name in sizes]
        yield [*listed(rule), *records, verdict([*by_corpus.values()]) if by_corpus else ""]


def _same_records() -> Iterator[list[str]]:
    with TABLE.open(encoding="utf-8", newline="") as stream:
        head, *rows = csv.reader(stream)
    yield head
    records = {row[1]: row[6:] for row in rows}
    for rule in _by_kind():
        yield [*listed(rule), *records.get(rule.name, [""] * (len(head) - 6))]


def _by_kind() -> list[Potential]:
    return sorted(potentials(), key=lambda rule: list(KINDS).index(rule.kind))


def listed(rule: Potential) -> list[str]:
    """Return the cells of a potential that come before its record."""
    weight = "hard" if rule.is_hard else format(rule.weight, ".2f")
    roles = ", ".join(rule.roles) or "the command"
    description = re.sub(r"\s+", " ", rule.description)
    return [rule.kind, rule.name, description, ", ".join(rule.types), roles, weight]


def verdict(rows: Sequence[Mapping[str, Any]]) -> str:
    """Sum up a potential's rows by counts alone."""
    wins = sum(row["won"] > row["lost"] for row in rows)
    loses = sum(row["won"] < row["lost"] for row in rows)
    if wins and loses:
        return "wins in some and loses in others"
    if loses:
        return "loses"
    if wins:
        return f"wins in {wins} corpora" if wins > 1 else "wins in one only"
    changes = any(row["won"] or row["lost"] for row in rows)
    return "wins as much as it loses" if changes else "changes nothing"


def _cell(row: Mapping[str, Any] | None) -> str:
    return f"{row['won']}, {row['lost']} ({row['spoke']})" if row else ""


if __name__ == "__main__":
    main()
