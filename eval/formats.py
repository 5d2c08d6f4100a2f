"""Table 1 as text: a table to read, JSON, CSV or LaTeX.

Every function returns text without a final newline and leaves the writing to the caller.
"""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from eval.correspondence import PAPER_SOURCE, PAPER_TABLE_1, Row
from eval.latex import RULE, estimate, tabular
from eval.statistics import FIGURES, Estimate

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

Format = Literal["text", "json", "csv", "latex"]
FORMATS: tuple[Format, ...] = get_args(Format)

HEADINGS = ("Precision", "Recall", "F-score", "Accuracy")
COUNTS = ("n", "positives", "commands", "scenarios")
COLUMNS = (
    "type",
    *FIGURES,
    *COUNTS,
    *(f"{name}_{bound}" for name in FIGURES for bound in ("low", "high")),
    *(f"paper_{name}" for name in FIGURES),
)
"""Columns of the CSV."""


def render(
    rows: Sequence[Row],
    format: Format,  # noqa: A002 - the name of the option
    metadata: Mapping[str, object],
    *,
    terminal: bool = False,
) -> str:
    """Table 1 in one of the formats, with the paper's figures beside.

    Parameters
    ----------
    rows
        What :func:`eval.correspondence.table_rows` gives.
    format
        ``table`` to read, ``json``, ``csv`` (metadata as columns that repeat, so that
        files of several runs can be put together) or ``latex`` (a tabular for booktabs).
    metadata
        What to record with the figures: corpus, model, seeds. In JSON they stand at the
        top level.
    terminal
        Whether the table goes to a terminal: colours and Unicode lines, else pure ASCII.

    Raises
    ------
    ValueError
        Where a key of the metadata is also the name of a column, or no such format exists.
    """
    if format == "text":
        return _table(rows, metadata, terminal=terminal)
    if format == "json":
        return document({"rows": [_nested(row) for row in rows]}, metadata)
    if format == "csv":
        return delimited([_flat(row) for row in rows], metadata, columns=COLUMNS)
    if format == "latex":
        return _latex(rows, metadata)
    raise ValueError(f"{format!r} is no format, expected one of {', '.join(FORMATS)}")


# Records


def _figures(row: Row) -> dict[str, object]:
    record: dict[str, object] = {"type": row.type}
    estimates: dict[str, Estimate] = {name: getattr(row, name) for name in FIGURES}
    record |= {name: one.value for name, one in estimates.items()}
    record |= {name: getattr(row, name) for name in COUNTS}
    for name, one in estimates.items():
        record |= {f"{name}_low": one.low, f"{name}_high": one.high}
    return record


def _nested(row: Row) -> dict[str, object]:
    paper = PAPER_TABLE_1[row.type]._asdict() | {"source": PAPER_SOURCE}
    return _figures(row) | {"paper": paper}


def _flat(row: Row) -> dict[str, object]:
    paper = PAPER_TABLE_1[row.type]._asdict()
    return _figures(row) | {f"paper_{name}": value for name, value in paper.items()}


def plain(value: object) -> object:
    """Turn a value into what JSON can hold: NaN and infinities into None, arrays into lists."""
    if isinstance(value, (np.generic, np.ndarray)):
        return plain(value.tolist())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    return value if value is None or isinstance(value, (str, int)) else str(value)


def metadata_text(metadata: Mapping[str, object]) -> str:
    """Metadata as lines of ``key: value``."""
    return "\n".join(f"{_one_line(key)}: {_one_line(value)}" for key, value in metadata.items())


def comments(metadata: Mapping[str, object]) -> list[str]:
    """Metadata as lines for a file that is handed on: of whole paths it has the names only."""
    shown = {
        key: Path(value).name if isinstance(value, str) and Path(value).is_absolute() else value
        for key, value in metadata.items()
    }
    return metadata_text(shown).splitlines()


def _one_line(value: object) -> str:
    value = plain(value)
    text = value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
    return "".join(c if c.isprintable() else " " for c in text)


def _refuse_clashes(metadata: Mapping[str, object], names: Iterable[str]) -> None:
    clashes = sorted(set(metadata) & set(names))
    if clashes:
        raise ValueError(f"metadata key {clashes[0]!r} is the name of a column")


def document(content: Mapping[str, object], metadata: Mapping[str, object]) -> str:
    """Strict JSON of the content with the metadata merged in at the top level."""
    _refuse_clashes(metadata, content)
    merged = plain({**metadata, **content})
    return json.dumps(merged, indent=2, ensure_ascii=False, allow_nan=False)


def delimited(
    records: Sequence[Mapping[str, object]],
    metadata: Mapping[str, object],
    *,
    columns: Sequence[str],
) -> str:
    """CSV of the columns of records, metadata repeated beside; None and NaN are empty fields."""
    _refuse_clashes(metadata, columns)
    constant = {key: _one_line(value) for key, value in metadata.items()}
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow([*columns, *constant])
    for record in records:
        writer.writerow([*(plain(record[name]) for name in columns), *constant.values()])
    return out.getvalue().rstrip("\n")


# Tables to read


def table_text(
    tables: Mapping[str, Table],
    notes: Sequence[str],
    metadata: Mapping[str, object],
    *,
    terminal: bool,
) -> str:
    """Tables by title, one under the other, then notes and metadata, a line each."""
    out = io.StringIO()
    console = Console(
        file=out,
        # Wide enough that nothing wraps: a pipe has no width, and a pager can scroll.
        width=400,
        force_terminal=terminal,
        color_system="standard" if terminal else None,
        legacy_windows=False,
        highlight=False,
    )
    for title, table in tables.items():
        # Not the table's own title, which wraps at the width of the table.
        console.print(Text(title, style="bold"), soft_wrap=True)
        table.box = box.SIMPLE_HEAD if terminal else box.ASCII2
        table.show_edge = table.pad_edge = False
        console.print(table)
        console.print()
    for line in [*notes, *metadata_text(metadata).splitlines()]:
        console.print(Text(line, style="dim"), soft_wrap=True)
    text = "\n".join(line.rstrip() for line in out.getvalue().splitlines())
    return text if terminal else text.encode("ascii", "backslashreplace").decode("ascii")


def cell(text: object, style: str = "") -> Text:
    """Text for a cell of a table: no markup is read in it and nothing in it is unprintable."""
    return Text(_one_line(text), style=style)


def _number(value: float) -> str:
    return "-" if math.isnan(value) else f"{value:.2f}"


def interval(low: float | None, high: float | None, form: str = "{:.2f} to {:.2f}") -> str:
    """The bounds of an interval, or a dash where there is none."""
    if low is None or high is None or math.isnan(low):
        return "-"
    return form.format(low, high)


def _table(rows: Sequence[Row], metadata: Mapping[str, object], *, terminal: bool) -> str:
    table = Table()
    table.add_column("Type")
    for heading in (*HEADINGS, "n", "True", "Commands"):
        table.add_column(heading, justify="right")
    for row in rows:
        estimates: list[Estimate] = [getattr(row, name) for name in FIGURES]
        between = "{:.2f}–{:.2f}" if terminal else "{:.2f}-{:.2f}"
        name = row.type.capitalize() if row.type == "overall" else row.type
        counts = (str(row.n), str(row.positives), str(row.commands))
        table.add_row(name, *(_number(e.value) for e in estimates), *counts, style="bold")
        table.add_row("  95%", *(interval(e.low, e.high, between) for e in estimates))
        paper = [_number(value) for value in PAPER_TABLE_1[row.type]]
        table.add_row("  paper", *paper, style="dim", end_section=True)
    title = "Performance at predicting the correspondence variable"
    notes = (
        "95%: percentile interval of a bootstrap over clusters of examples",
        "-: none, for all clusters say the same, or only one says anything",
        f"paper: {PAPER_SOURCE}, on its own corpus",
    )
    return table_text({title: table}, notes, metadata, terminal=terminal)


def _latex(rows: Sequence[Row], metadata: Mapping[str, object]) -> str:
    cells: list[tuple[str, ...]] = []
    for row in rows:
        estimates: list[Estimate] = [getattr(row, name) for name in FIGURES]
        paper = [_number(value) for value in PAPER_TABLE_1[row.type]]
        if row.type == "overall":
            cells.append(RULE)
        name = row.type.capitalize() if row.type == "overall" else row.type
        cells += [
            (name, *(estimate(*one) for one in estimates), str(row.n)),
            (r"\quad paper$^\dagger$", *paper, ""),
        ]
    about = [*comments(metadata), f"Rows marked with a dagger: {PAPER_SOURCE}."]
    return tabular(("SDC type", *HEADINGS, "$n$"), cells, comments=about)
