"""Tables of other people, CSV or JSON lines: rows whose cells are located by line and column.

CSV is read strictly (RFC 4180): a stray quotation mark is an error, never another text. Python's
reader accepts marks within cells, drops some, and lets one that isn't closed swallow the rest of
the file. It also has no columns for errors.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeAlias

import msgspec

from corpus_tools.tables.json_text import decode, numbered_lines, read_text
from g3.errors import FormatError
from g3.storage.text_lines import place_in

TABLES = (".csv", ".jsonl")
"""The endings of their names."""
OnNote: TypeAlias = Callable[[str], None]
"""Function that receives remarks about tables that can be read all the same."""
Value: TypeAlias = str | int | float | bool

_SEPARATORS = {";": "semicolons", "\t": "tabs", "|": "vertical bars"}
_MOST_LINES = 10
_OBJECT = 'write each line as {"video": "clip.mp4", "command": "Go."}'


def no_note(_note: str) -> None:
    """Take no note."""


@dataclass(frozen=True, slots=True)
class Row:
    """A row of a table that isn't empty."""

    table: Path
    line: int
    values: Mapping[str, Value]
    """By column; empty cells are empty texts, or aren't there."""
    texts: Mapping[str, str]
    """Values as the file writes them: a number such as 1.10 keeps its digits."""
    columns: Mapping[str, Place] = field(repr=False)
    """Places of the cells."""

    def where(self, name: str = "") -> str:
        """Return the place of a cell, or of the row, as errors name it."""
        line, column = self.columns.get(name, (self.line, 1))
        place = f"{self.table}:{line}:{column}"
        return f"{place}: {name}" if name else place

    def text(self, name: str) -> str:
        """Return the text of a cell; it is empty if there is none."""
        return self.texts.get(name, "")


def read_table(path: Path, needed: Sequence[str] = (), on_note: OnNote = no_note) -> list[Row]:
    """Read a table, and name all of its cells that aren't used.

    Parameters
    ----------
    path
        A file whose name ends in .csv, else it is read as JSON lines.
    needed
        The columns that each row must have.
    on_note
        Takes a line about cells that aren't used, or that go over several lines.

    Returns
    -------
    list of Row
        The rows in their order, without those of which all cells are empty.
    """
    text = read_text(path, what="table", fix="save it as UTF-8 text")
    read = _csv_table if path.suffix.lower() == ".csv" else _jsonl_table
    return list(read(text, path, needed, on_note))


def lines_named(lines: Iterable[int]) -> str:
    """Return the numbers of lines as notes name them, such as "lines 2, 5 and 7"."""
    every = sorted(set(lines))
    first = list(map(str, every[:_MOST_LINES]))
    if len(every) == 1:
        return f"line {first[0]}"
    if len(every) > len(first):
        return f"lines {', '.join(first)} and {len(every) - len(first)} more"
    return f"lines {', '.join(first[:-1])} and {first[-1]}"


def _csv_table(text: str, path: Path, needed: Sequence[str], on_note: OnNote) -> Iterator[Row]:
    _check_separator(text, path, needed)
    rows = (row for row in csv_rows(text, str(path)) if any(map(str.strip, row.cells)))
    header = next(rows, None)
    if header is None:
        raise FormatError(
            "the table is empty", where=f"{path}:1:1", fix=f"begin it with {_listed(needed)}"
        )
    names = [name.strip() for name in header.cells]
    _check_names(names, header, path, needed)
    broken: list[int] = []
    unnamed: dict[int, list[int]] = {}
    for row in rows:
        _check_width(row, names, path)
        cells = dict(zip(names, row.cells, strict=False))
        for number, (name, cell) in enumerate(zip(names, row.cells, strict=False), start=1):
            if not name and cell.strip():
                unnamed.setdefault(number, []).append(row.line)
        if row.last_line > row.line:
            broken.append(row.line)
        cells.pop("", None)
        yield Row(path, row.line, cells, cells, dict(zip(names, row.places, strict=False)))
    for number, lines in unnamed.items():
        on_note(
            f"{path}: column {number} has no name, and its cells aren't used: {lines_named(lines)}"
        )
    if broken:
        on_note(
            f"{path}: cells go on over several lines from {lines_named(broken)}; see that their "
            "quotation marks are meant so"
        )


def _check_separator(text: str, path: Path, needed: Sequence[str]) -> None:
    """See that a table has commas between its cells, and nothing else."""
    start = len(text) - len(text.lstrip("\r\n"))
    first = re.split("[\r\n]", text[start:], maxsplit=1)[0]
    for separator, name in _SEPARATORS.items():
        cells = {cell.strip().strip('"') for cell in first.split(separator)}
        if separator in first and needed and cells.issuperset(needed):
            line, column = place_in(text, start + first.index(separator))
            raise FormatError(
                f"the cells are separated by {name}",
                where=f"{path}:{line}:{column}",
                fix="save the table with commas between its cells",
            )


def _check_names(names: Sequence[str], header: CsvRow, path: Path, needed: Sequence[str]) -> None:
    for number, (name, (line, column)) in enumerate(zip(names, header.places, strict=True)):
        if name and name in names[:number]:
            raise FormatError(
                f"two columns are called {name!r}",
                where=f"{path}:{line}:{column}",
                fix="rename one of them, or leave it out",
            )
    for name in needed:
        if name not in names:
            raise FormatError(
                f"there is no column {name!r} in the first row, which has "
                f"{', '.join(filter(None, names))}",
                where=f"{path}:{header.line}:1",
                fix=f"begin the table with a row of names; needed are {_listed(needed)}",
            )


def _check_width(row: CsvRow, names: Sequence[str], path: Path) -> None:
    filled = max(number for number, cell in enumerate(row.cells, start=1) if cell.strip())
    if filled > len(names) or len(row.cells) < len(names):
        line, column = row.places[min(len(names), len(row.cells) - 1)]
        raise FormatError(
            f"this row has {len(row.cells)} cells and the first row has {len(names)}: "
            f"{'more' if filled > len(names) else 'fewer'}",
            where=f"{path}:{line}:{column}",
            fix="put cells with commas between quotation marks, and leave none out",
        )


def _jsonl_table(text: str, path: Path, needed: Sequence[str], _on_note: OnNote) -> Iterator[Row]:
    decoder = msgspec.json.Decoder(dict[str, msgspec.Raw])
    rows = [_jsonl_row(path, *numbered, decoder) for numbered in numbered_lines(text)]
    for name in needed:
        if not any(name in row.values for row in rows):
            raise FormatError(
                f"there is no {name!r}",
                where=rows[0].where() if rows else f"{path}:1:1",
                fix=f"needed are {_listed(needed)}",
            )
    return (row for row in rows if any(map(str.strip, row.texts.values())))


def _jsonl_row(
    path: Path, line: int, content: str, decoder: msgspec.json.Decoder[dict[str, msgspec.Raw]]
) -> Row:
    try:
        raw = decode(content, decoder, str(path), line, fix=_OBJECT)
    except FormatError as error:
        what = f"this is no object of texts and numbers: {error.what}"
        raise FormatError(what, where=error.where, fix=_OBJECT) from error
    tokens = {name: bytes(token) for name, token in raw.items()}
    columns = {name: (line, _column(content, name)) for name in raw}
    values = {name: _plain(token, path, name, columns[name]) for name, token in tokens.items()}
    texts = {
        name: value if isinstance(value, str) else tokens[name].decode()
        for name, value in values.items()
    }
    return Row(path, line, values, texts, columns)


def _plain(token: bytes, path: Path, name: str, place: Place) -> Value:
    try:
        value: Value | None = msgspec.json.decode(token, type=Value | None)
    except msgspec.DecodeError as error:
        raise FormatError(
            f"this is no text and no number: {str(error).partition(' - at ')[0]}",
            where=f"{path}:{place[0]}:{place[1]}: {name}",
            fix=_OBJECT,
        ) from error
    return "" if value is None else value


def _column(line: str, name: str) -> int:
    return line.find(f'"{name}"') + 1 or 1


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names) or "the names of its columns"


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
        match = _UP_TO_MARK[self.end].match(self.text, start)
        self.at = start if match is None else match.end()
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
