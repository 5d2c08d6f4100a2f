"""Tables as lines of text that fit :data:`WIDTH` columns for any content of their cells."""

from __future__ import annotations

import copy
import io
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from rich import box
from rich.console import Console
from rich.measure import Measurement
from rich.table import Column, Table
from rich.text import Text

from g3.storage.text_lines import split_lines

WIDTH = 100
"""Columns that a table or a note takes at most."""


def table_lines(table: Table, *, terminal: bool = False) -> list[str]:
    """Lay a table out in lines of at most :data:`WIDTH` columns, styled for a terminal.

    Columns of words get narrower first, and wrap. Figures, which are justified to the right, stay
    whole: columns of them that find no room continue below, beside the words. A word is broken
    only where it is wider than its column can be.
    """
    table.show_edge = table.pad_edge = False
    if table.box is not None:
        table.box = box.SIMPLE_HEAD if terminal else box.ASCII2
    out = io.StringIO()
    console = Console(
        file=out,
        width=WIDTH,
        force_terminal=terminal,
        color_system="standard" if terminal else None,
        legacy_windows=False,
        highlight=False,
    )
    for part in _parts(table, console):
        if out.tell():
            console.print()
        console.print(part)
    return [line.rstrip() for line in split_lines(out.getvalue())]


def figure_table(
    headings: Sequence[str], rows: Iterable[Sequence[str | Text]] = (), *, words: int = 1
) -> Table:
    """Make a table whose first `words` columns hold words, and the others figures."""
    table = Table()
    for place, heading in enumerate(headings):
        table.add_column(heading, justify="left" if place < words else "right")
    for row in rows:
        table.add_row(*row)
    return table


def columns(rows: Sequence[Sequence[str]]) -> list[str]:
    """Lay words out in columns without headings, two spaces apart."""
    table = Table(box=None, show_header=False, padding=(0, 2, 0, 0))
    for row in rows:
        table.add_row(*map(Text, row))
    return table_lines(table)


def wrapped(lines: Iterable[str]) -> list[str]:
    """Wrap lines that are wider than a table may be."""
    return [
        part
        for line in lines
        for part in (
            textwrap.wrap(line, WIDTH, subsequent_indent="  ") if len(line) > WIDTH else [line]
        )
    ]


def _parts(table: Table, console: Console) -> Iterator[Table]:
    """Yield tables that fit, each with all columns of words and as many figures as find room."""
    spans = [_span(column, console) for column in table.columns]
    figures = [i for i, column in enumerate(table.columns) if column.justify == "right"]
    words = [i for i in range(len(spans)) if i not in figures]
    while True:
        taken = len(figures)
        while taken > 1 and sum(spans[i][0] for i in (*words, *figures[:taken])) > _room(
            table, len(words) + taken
        ):
            taken -= 1
        yield _part(table, sorted([*words, *figures[:taken]]), spans)
        figures = figures[taken:]
        if not figures:
            return


def _part(table: Table, shown: Sequence[int], spans: Sequence[tuple[int, int]]) -> Table:
    """Return a table of some columns, each as wide as it may be."""
    room = _room(table, len(shown))
    least, most = ([spans[i][end] for i in shown] for end in (0, 1))
    if sum(least) > room:
        widths = _shares(least, room)
    else:
        more = _shares([b - a for a, b in zip(least, most, strict=True)], room - sum(least))
        widths = [a + b for a, b in zip(least, more, strict=True)]
    part = copy.copy(table)
    part.columns = [
        replace(table.columns[i], width=width, overflow="fold", _index=place)
        for place, (i, width) in enumerate(zip(shown, widths, strict=True))
    ]
    return part


def _span(column: Column, console: Console) -> tuple[int, int]:
    """Measure the least and the greatest width that a column has a use for."""
    heading, *cells = (
        Measurement.get(console, console.options.update_width(10**6), one)
        for one in (column.header, *column.cells)
    )
    is_whole = column.justify == "right"
    least = (cell.maximum if is_whole else cell.minimum for cell in cells)
    most = (cell.maximum for cell in cells)
    return max(heading.minimum, *least, 1), max(heading.maximum, *most, 1)


def _room(table: Table, count: int) -> int:
    """Return the width that so many columns share, without what is between them."""
    _, right, _, left = table.padding
    return WIDTH - (count - 1) * (right + left + (table.box is not None))


def _shares(wishes: Sequence[int], room: int) -> list[int]:
    """Divide room so that small wishes come true, and what is left is equal."""
    shares = list(wishes)
    for taken, place in enumerate(sorted(range(len(wishes)), key=wishes.__getitem__)):
        shares[place] = min(wishes[place], room // (len(wishes) - taken))
        room -= shares[place]
    return shares
