"""The tables of a language: words, numbers, forms and patterns, each row with an example.

A language is a folder of JSON Lines in :mod:`g3.language`. The first line of a table states its
source; each other one is a row. `words` are in lower case, as they are written
(:func:`g3.language.lexicon.field_words.bare`), and with `stems` in the normal form
(:func:`g3.language.lexicon.field_words.normalise`), so that other endings count as well. A row
has the words of those that it includes, too. Rows ``kind/name`` are the members of a kind: the
words of a concept, a class of words or a colour.

A second language is a folder with the same rows, and a treebank for the parser. Open classes, such
as nouns for things, need no rows: :mod:`g3.language.similarity.word_similarity` compares them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Literal, TypeVar

import msgspec

from g3.language.lexicon.stemming import stems

FOLDER = Path(__file__).parents[1] / "english"

Kind = Literal["concept", "class", "colour", "size", "kind", "cue"]
"""Kinds of which several rows are members."""
V = TypeVar("V")


class Row(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Row of a table.

    Parameters
    ----------
    name
        Name by which modules look the row up.
    example
        Words in which the row has its effect.
    words, stems, include
        The words, with blanks between; whether their endings don't count; rows whose words these
        are, too.
    values, forms
        Number or form that each word stands for.
    pattern, where
        Regular expression over the words of a text; side of it on which its noun stands.
    note
        Use of the words.
    """

    name: str
    example: str
    words: str = ""
    stems: bool = False
    include: tuple[str, ...] = ()
    values: dict[str, int | float] = {}
    forms: dict[str, str] = {}
    pattern: str = ""
    where: Literal["", "after", "before"] = ""
    note: str = ""


class Source(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """First line of a table."""

    source: str


@cache
def rows() -> Mapping[str, Row]:
    """Return the rows of all tables by name, each table's in their order."""
    read: dict[str, Row] = {}
    for path in sorted(FOLDER.glob("*.jsonl")):
        source, *lines = path.read_bytes().splitlines()
        msgspec.json.decode(source, type=Source)
        for line in lines:
            row = msgspec.json.decode(line, type=Row)
            read[row.name] = row
    return read


def members(kind: Kind) -> dict[str, Row]:
    """Return the rows of a kind by the names of its members.

    >>> members("colour")["grey"].words
    'grey gray silver charcoal'
    """
    prefix = f"{kind}/"
    return {n.removeprefix(prefix): row for n, row in rows().items() if n.startswith(prefix)}


def written(row: Row) -> frozenset[str]:
    """Return the words of a row and of those that it includes, as they are written."""
    included = (written(rows()[name]) for name in row.include)
    return frozenset(row.words.split()).union(row.values, row.forms, *included)


class _Lookup(dict[str, V]):
    """Values by the names of rows, each made when it is first looked up."""

    def __init__(self, make: Callable[[Row], V]) -> None:
        super().__init__()
        self._make = make

    def __missing__(self, name: str) -> V:
        value = self[name] = self._make(rows()[name])
        return value


def _word_set(row: Row) -> frozenset[str]:
    return stems(written(row)) if row.stems else written(row)


def _values(row: Row) -> Mapping[str, float]:
    return {w: n for name in row.include for w, n in _values(rows()[name]).items()} | row.values


WORDS: Mapping[str, frozenset[str]] = _Lookup(_word_set)
"""Sets of words."""
COUNTS: Mapping[str, Mapping[str, int]] = _Lookup(
    lambda row: {word: int(n) for word, n in _values(row).items()}
)
"""Whole numbers that words stand for."""
VALUES: Mapping[str, Mapping[str, float]] = _Lookup(_values)
"""Numbers that words stand for, and units in m, s and rad."""
FORMS: Mapping[str, Mapping[str, str]] = _Lookup(lambda row: row.forms)
"""Forms that words stand for."""
