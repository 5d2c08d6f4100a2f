"""CSV, read strictly (RFC 4180): a stray quotation mark is an error, never another text.

Python's reader accepts marks within cells, drops some, and lets one that isn't closed swallow the
rest of the file. It also has no columns for errors.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from g3.errors import FormatError

Place = tuple[int, int]
"""Line and column, both from 1."""

_UP_TO_MARK = {"\n": re.compile(r'[^",\n]*'), "\r": re.compile(r'[^",\r]*')}
_FIRST_ROW = re.compile(r'(?:[^"\r\n]+|"[^"]*")*')
_LONE_RETURN = re.compile(r"\r(?!\r*\n)")
_DOUBLE = 'put the whole cell between quotation marks, and double each mark in it: ""'


@dataclass(frozen=True, slots=True)
class CsvRow:
    """A row of a CSV file."""

    cells: tuple[str, ...]
    """The texts of its cells; a blank line has none."""
    places: tuple[Place, ...]
    """Beginning of each cell."""
    line: int
    last_line: int
    """The lines on which the row begins and ends; they differ if a cell has line ends in it."""


def csv_rows(text: str, where: str) -> Iterator[CsvRow]:
    """Read the rows of a CSV file.

    Parameters
    ----------
    text
        The file's text. Its rows end as the first one does: at line feeds, or at carriage returns.
    where
        The file, as errors name it.

    Raises
    ------
    FormatError
        At the first quotation mark that is not closed, or not at the edge of a cell.
    """
    scan = _Scan(text, where)
    while scan.at < len(text):
        yield scan.row()


class _Scan:
    """The place in a text up to which it is read."""

    def __init__(self, text: str, where: str) -> None:
        self.text, self.where = text, where
        self.end = _row_end(text)
        self.at, self.line, self.line_start = 0, 1, 0

    def row(self) -> CsvRow:
        start, line = self.at, self.line
        cells, places = [], []
        while True:
            places.append(self.place(self.at))
            cells.append(self.quoted() if self.text.startswith('"', self.at) else self.plain())
            if not self.text.startswith(",", self.at):
                break
            self.at += 1
        last_line = self.line
        is_blank = cells == [""] and self.at == start
        while self.text.startswith("\r", self.at) and self.end == "\n":
            self.at += 1
        if self.at < len(self.text):
            if not self.text.startswith(self.end, self.at):
                raise self.after_mark(places[-1])
            self.at += 1
            self.line, self.line_start = self.line + 1, self.at
        return CsvRow(() if is_blank else tuple(cells), tuple(places), line, last_line)

    def plain(self) -> str:
        start = self.at
        found = _UP_TO_MARK[self.end].match(self.text, start)
        self.at = start if found is None else found.end()
        if self.text.startswith('"', self.at):
            raise self.error(
                self.place(self.at), "a quotation mark is in a cell that does not begin with one"
            )
        cell = self.text[start : self.at]
        if self.end == "\r" or self.text.startswith(",", self.at):
            return cell
        kept = cell.rstrip("\r")  # of the row's end
        self.at -= len(cell) - len(kept)
        return kept

    def quoted(self) -> str:
        start = self.at
        close = self.text.find('"', start + 1)
        while close >= 0 and self.text.startswith('"', close + 1):
            close = self.text.find('"', close + 2)
        if close < 0:
            raise self.error(self.place(start), "a quotation mark is not closed")
        self.at = close + 1
        breaks = self.text.count(self.end, start, close)
        if breaks:
            self.line += breaks
            self.line_start = self.text.rindex(self.end, start, close) + 1
        return self.text[start + 1 : close].replace('""', '"')

    def place(self, offset: int) -> Place:
        return self.line, offset - self.line_start + 1

    def after_mark(self, opened: Place) -> FormatError:
        line, column = opened
        return self.error(
            self.place(self.at),
            f"there is text after the quotation mark that ends the cell of line {line}, "
            f"column {column}",
        )

    def error(self, place: Place, what: str) -> FormatError:
        line, column = place
        return FormatError(what, where=f"{self.where}:{line}:{column}", fix=_DOUBLE)


def _row_end(text: str) -> str:
    first = _FIRST_ROW.match(text)
    return "\r" if _LONE_RETURN.match(text, 0 if first is None else first.end()) else "\n"
