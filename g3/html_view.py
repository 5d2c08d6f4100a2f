"""HTML of objects for notebooks, in which all texts are escaped."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

from g3.short_repr import shortened

CELL = 200
"""Largest number of characters in a cell; the end of a longer text is left out."""


def heading(title: str, *details: str) -> str:
    """Return a title in bold, with details after it."""
    rest = f" <span>{text(' · '.join(filter(None, details)))}</span>" if any(details) else ""
    return f"<p><strong>{text(title)}</strong>{rest}</p>"


def paragraph(words: str) -> str:
    """Return words in a paragraph of their own."""
    return f"<p>{text(words)}</p>"


def table(headings: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return a table whose cells are texts."""
    head = "".join(f"<th>{text(name)}</th>" for name in headings)
    body = "".join(
        f"<tr>{''.join(f'<td>{text(str(cell))}</td>' for cell in row)}</tr>" for row in rows
    )
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def preformatted(words: str) -> str:
    """Return words as they are printed, in letters of one width."""
    shown = escape(_printable(words, keep="\n"))
    return f'<pre style="line-height: 1.2; overflow-x: auto">{shown}</pre>'


def text(words: str) -> str:
    """Escape words and shorten long ones."""
    return escape(_printable(shortened(words, CELL)))


def _printable(words: str, keep: str = "") -> str:
    return "".join(c if c.isprintable() or c in keep else "\ufffd" for c in words)
