"""Tables in memory, and as text: to read, as JSON and as CSV.

Texts have no final newline; the caller writes them.
"""

from __future__ import annotations

import io
import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args, overload

import click
import numpy as np
from rich.table import Table
from rich.text import Text

from corpus_tools.corpus.estimate import REASONS, Estimate, Reason
from corpus_tools.exporters.csv_tables import write_rows
from corpus_tools.runtime.text_tables import table_lines, wrapped
from g3 import html_view
from g3.data_frames import data_frame
from g3.storage.text_lines import split_lines

if TYPE_CHECKING:
    import pandas as pd

Format = Literal["text", "json", "csv", "latex"]
FORMATS: tuple[Format, ...] = get_args(Format)


def plain(value: object) -> object:
    """Convert a value for JSON: NaN and infinities become None, arrays become lists."""
    if isinstance(value, Estimate):
        return plain(value._asdict())
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
    """Format metadata as lines of ``key: value``."""
    return "\n".join(f"{_one_line(key)}: {_one_line(value)}" for key, value in metadata.items())


def comments(metadata: Mapping[str, object]) -> list[str]:
    """Format metadata as lines for a published file: whole paths are cut to names."""
    whole = {key: _without_folders(value) for key, value in metadata.items()}
    return split_lines(metadata_text(whole))


def _without_folders(value: object) -> object:
    """Reduce whole paths in a value to names; of several with commas, each one."""
    if isinstance(value, Mapping):
        return {key: _without_folders(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_without_folders(item) for item in value]
    if isinstance(value, (str, Path)):
        parts = str(value).split(",")
        return ",".join(Path(p).name if Path(p).is_absolute() else p for p in parts)
    return value


def _one_line(value: object) -> str:
    value = plain(value)
    text = value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
    return "".join(c if c.isprintable() else " " for c in text)


def _refuse_clashes(metadata: Mapping[str, object], names: Iterable[str]) -> None:
    clashes = sorted(set(metadata) & set(names))
    if clashes:
        raise ValueError(f"metadata key {clashes[0]!r} is the name of a column")


def document(content: Mapping[str, object], metadata: Mapping[str, object]) -> str:
    """Return strict JSON of the content with the metadata merged in at the top level."""
    _refuse_clashes(metadata, content)
    merged = plain({**metadata, **content})
    return json.dumps(merged, indent=2, ensure_ascii=False, allow_nan=False)


def delimited(
    records: Sequence[Mapping[str, object]],
    metadata: Mapping[str, object],
    *,
    columns: Sequence[str],
) -> str:
    """Return CSV of records' columns, with repeated metadata; None and NaN are empty fields."""
    _refuse_clashes(metadata, columns)
    constant = {
        key: "" if plain(value) is None else _one_line(value) for key, value in metadata.items()
    }
    out = io.StringIO()
    rows = ([*(plain(record[name]) for name in columns), *constant.values()] for record in records)
    write_rows(out, [*columns, *constant], rows, line_end="\n")
    return out.getvalue().rstrip("\n")


# Tables to read


def table_text(
    tables: Mapping[str, Table],
    notes: Sequence[str],
    metadata: Mapping[str, object],
    *,
    terminal: bool,
) -> str:
    """Render tables by title, one under the other, then notes and metadata, each on a new line."""

    def text(lines: Iterable[str], **style: bool) -> list[str]:
        below = wrapped(map(_one_line, lines))
        return [click.style(line, **style) for line in below] if terminal else below

    parts = (
        line
        for title, table in tables.items()
        for line in (*text([title], bold=True), *table_lines(table, terminal=terminal), "")
    )
    under = text([*notes, *split_lines(metadata_text(metadata))], dim=True)
    return "\n".join([*parts, *under])


def cell(text: object) -> Text:
    """Text for a cell of a table: no markup is read in it and nothing in it is unprintable."""
    return Text(_one_line(text))


def figure(value: float | None) -> str:
    """Format a figure with two digits, or a dash where there is none."""
    return "-" if value is None or math.isnan(value) else f"{value:.2f}"


def interval(one: Estimate, form: str = "{:.2f} to {:.2f}") -> str:
    """Format an estimate's interval, or the reason for its absence; a dash without a reason."""
    return form.format(one.low, one.high) if one.has_interval else one.reason or "-"


def value(one: Estimate, form: str = "{:.2f}") -> str:
    """Format the figure alone, or the reason for its absence."""
    return form.format(one.value) if one.is_known else one.reason or "-"


def stated(one: Estimate, form: str = "{:.2f}") -> str:
    """Format a figure with its interval, or the reason for its absence, for a sentence."""
    if not one.is_known:
        return f"none ({one.reason})"
    shown = form.format(one.value)
    around = interval(one, f"{form} to {form}")
    return f"{shown} ({around})" if one.has_interval or one.reason else shown


def estimate_of(
    value: float | None, low: float | None, high: float | None, reason: object = ""
) -> Estimate:
    """Return an estimate from a record, in which None is no figure."""
    named: Reason = next((name for name in REASONS if name == reason), "")
    one, *bounds = (math.nan if number is None else number for number in (value, low, high))
    return Estimate(one, bounds[0], bounds[1], named)


def left_out(estimates: Mapping[str, Estimate], draws: object) -> list[str]:
    """Return a line for each figure with left-out resamples; its name describes the figure."""
    return [
        f"{name}: {one.left_out} of {draws} resamples have no such figure and are left out"
        for name, one in estimates.items()
        if one.left_out
    ]


Row = Mapping[str, Any]


class ResultTable:
    """A table of the paper, with new measurements.

    It prints as ``ct eval`` does. Its length is the number of its rows; iterating gives them.

    Attributes
    ----------
    document
        All that was measured, with seeds and corpora, as ``ct eval --json`` writes it.
    """

    def __init__(self, title: str, render: Callable[[Format], str]) -> None:
        self.title = title
        self._render = render
        self.document: Row = json.loads(render("json"))

    @cached_property
    def text(self) -> str:
        """The printed table."""
        return self._render("text")

    @property
    def rows(self) -> tuple[Row, ...]:
        """Each row by the names of its columns; None where there is no figure."""
        return tuple(self.document["rows"])

    def to_pandas(self) -> pd.DataFrame:
        """Return the rows as a pandas table."""
        return data_frame(self.rows)

    def to_csv(self) -> str:
        """Return the rows as CSV, with seeds and corpora in further columns."""
        return self._render("csv")

    def to_latex(self) -> str:
        """Return the table for a paper; it needs the package booktabs."""
        return self._render("latex")

    def __len__(self) -> int:
        return len(self.rows)

    def __iter__(self) -> Iterator[Row]:
        return iter(self.rows)

    @overload
    def __getitem__(self, which: int) -> Row: ...
    @overload
    def __getitem__(self, which: slice) -> tuple[Row, ...]: ...
    def __getitem__(self, which: int | slice) -> Row | tuple[Row, ...]:
        return self.rows[which]

    def __str__(self) -> str:
        return self.text

    def __repr__(self) -> str:
        return f"ResultTable({self.title!r}, {len(self)} rows)"

    def _repr_html_(self) -> str:
        """Return the printed table as HTML."""
        return html_view.preformatted(self.text)
