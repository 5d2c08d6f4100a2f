"""A table of results in memory: its rows, and the forms in which it is printed."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any, overload

from eval.tables.formats import Format
from g3 import html_view
from g3.data_frames import data_frame

if TYPE_CHECKING:
    import pandas as pd

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
