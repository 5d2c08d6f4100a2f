r"""Output of ``ct``: text of a file or a person can't control the terminal.

A corpus's text may hold characters that clear the screen, change what was printed before, or swap
the order of what is read. They are printed as JSON would write them (``\u001b``), into pipes as
well. JSON stays JSON by that.
"""

from __future__ import annotations

import logging
import re
from collections.abc import Sequence

import click

from g3.storage.system_errors import about

MOST_NOTES = 50
_STYLE = r"\x1b\[(?:[0-4]|[39][0-7])?(?:;(?:[0-4]|[39][0-7]))*m"
_DANGEROUS = "\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069"
"""Control characters but for tab and newline, and those that turn the direction of text."""
_ALL = re.compile(f"[{_DANGEROUS}]")
_UNSTYLED = re.compile(f"({_STYLE})|[{_DANGEROUS}]")


def visible(text: str, *, styled: bool = False) -> str:
    r"""Return a text with all that would control a terminal written out.

    Parameters
    ----------
    styled
        Keep colours, and what makes letters bold, dim or underlined: for what we coloured.

    >>> visible("one\x1b[2Jtwo\x00\n")
    'one\\u001b[2Jtwo\\u0000\n'
    """
    if styled:
        return _UNSTYLED.sub(lambda match: match[1] or _escaped(match), text)
    return _ALL.sub(_escaped, text)


def _escaped(match: re.Match[str]) -> str:
    return f"\\u{ord(match[0]):04x}"


def say(*lines: str, styled: bool = False) -> None:
    """Print lines on the standard output."""
    with about("the standard output"):
        for line in lines:
            click.echo(visible(line, styled=styled))


def note(*lines: str) -> None:
    """Print lines on the standard error, as they are."""
    for line in lines:
        click.echo(visible(line), err=True)


def note_all(notes: Sequence[str]) -> None:
    """Print notes on the standard error, a line each, up to :data:`MOST_NOTES`."""
    note(*(f"note: {one}" for one in notes[:MOST_NOTES]))
    if len(notes) > MOST_NOTES:
        note(f"note: and {len(notes) - MOST_NOTES} more such notes")


class VisibleFormatter(logging.Formatter):
    """Formats lines of a log so that they can't control a terminal either."""

    def format(self, record: logging.LogRecord) -> str:
        """One line, and the lines of a traceback if there is one."""
        return visible(super().format(record))
