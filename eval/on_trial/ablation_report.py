"""Ablations as text, JSON and CSV."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from rich.table import Table

from eval.on_trial.ablation_rows import COLUMNS, AblationRow, verdict
from eval.tables.formats import Format, cell, delimited, document, table_text

NOTES = (
    "won: commands that are right with it and wrong without it; lost: the other way round.",
    "p: two-sided exact sign test; Holm: corrected for all that was tried in the corpus.",
    "The verdict goes by won and lost alone; p says how easily that comes about by chance.",
)


def render(
    rows: Sequence[AblationRow],
    form: Format,
    metadata: Mapping[str, object],
    *,
    terminal: bool = False,
) -> str:
    """The rows, with a verdict on each candidate."""
    said = {name: verdict(own) for name, own in _by_name(rows)}
    if form == "csv":
        records = [{**row, "verdict": said[row["name"]]} for row in rows]
        return delimited(records, metadata, columns=(*COLUMNS, "verdict"))
    if form == "json":
        return document({"rows": rows, "verdicts": said}, metadata)
    table = Table("switched off", "kind")
    sizes = {row["corpus"]: row["n"] for row in rows}
    for corpus, n in sizes.items():
        table.add_column(cell(f"{corpus} ({n}): won"), justify="right")
        for heading in ("lost", "p", "Holm"):
            table.add_column(heading, justify="right")
    table.add_column("verdict")
    for name, own in _by_name(rows):
        cells = [text for row in own for text in _cells(row)]
        table.add_row(cell(name), own[0]["kind"], *cells, said[name])
    return table_text({"On trial": table}, NOTES, metadata, terminal=terminal)


def _by_name(rows: Sequence[AblationRow]) -> Iterator[tuple[str, list[AblationRow]]]:
    for name in dict.fromkeys(row["name"] for row in rows):
        yield name, [row for row in rows if row["name"] == name]


def _cells(row: AblationRow) -> tuple[str, str, str, str]:
    if not row["won"] + row["lost"]:
        return "0", "0", "-", "-"
    return str(row["won"]), str(row["lost"]), f"{row['p']:.3f}", f"{row['p_holm']:.3f}"
