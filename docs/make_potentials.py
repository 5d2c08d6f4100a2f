"""Write the tables of ``potentials.md``, with each potential's record.

The record is in files that ``benchmarks.potentials_off`` writes::

    python -m benchmarks.potentials_off --test aaai11,automatic,warehouse --out corpora.json
    python -m benchmarks.potentials_off --set second --set fourth --set eighth --out written.json
    python docs/make_potentials.py corpora.json written.json
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from g3.inference.potentials.potential_registry import KINDS, Potential, potentials

PAGE = Path(__file__).parent / "potentials.md"
BEGIN = "<!-- by docs/make_potentials.py -->"


def main() -> None:
    """Replace the tables."""
    rows = [row for name in sys.argv[1:] for row in json.loads(Path(name).read_text())["rows"]]
    intro = PAGE.read_text(encoding="utf-8").partition(BEGIN)[0]
    PAGE.write_text(f"{intro}{BEGIN}\n\n" + "\n".join(_tables(rows)), encoding="utf-8")


def _tables(rows: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    sizes = {row["corpus"]: row["n"] for row in rows}
    corpora = "".join(f" {name} ({n}) |" for name, n in sizes.items())
    for kind, about in KINDS.items():
        yield f"### `{kind}`: {about}\n"
        yield f"| name | what it says | SDCs | of | weight |{corpora} verdict |"
        yield f"| --- | --- | --- | --- | --- |{' ---: |' * len(sizes)} --- |"
        for rule in potentials():
            if rule.kind == kind:
                own = [row for row in rows if row["name"] == rule.name]
                by_corpus = {row["corpus"]: row for row in own}
                cells = "".join(f" {_cell(by_corpus.get(name))} |" for name in sizes)
                yield f"{listed(rule)}{cells} {verdict(own) if own else ''} |"
        yield ""


def listed(rule: Potential) -> str:
    """Return the cells of a potential that come before its record."""
    weight = "hard" if rule.is_hard else format(rule.weight, ".2f")
    of = ", ".join(rule.roles) or "the command"
    said = re.sub(r"\s+", " ", rule.description)
    return f"| `{rule.name}` | {said} | {', '.join(rule.types)} | {of} | {weight} |"


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
