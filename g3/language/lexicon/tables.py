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

# fmt: off
WordSet = Literal[
    "aboard", "about", "after_all", "again", "aligning", "alone", "an", "anything", "areas",
    "around", "arrows", "articles", "aside", "asking", "back", "before_all", "behind",
    "beside_verbs", "between", "breaks", "class/relative", "closing", "collectives", "coming",
    "counting_all", "decks", "demonstratives", "determiners", "distant", "distributive", "doubled",
    "doubting", "drivers", "elsewhere", "empty", "emptying", "ends", "everything", "excepting",
    "existential", "facing", "farthest", "filling", "floor", "forks", "former", "generic",
    "getting", "having", "heaped", "heaps", "here", "holding", "indefinite", "interjections", "it",
    "joining", "keeping", "laden", "laps", "later", "lateral", "leading", "leaving", "lifts",
    "light", "lining", "linking", "listing", "lowering", "mended", "moving", "naming_nothing",
    "nearer", "nearest", "negated_anyway", "negating_nouns", "negation_leads", "never_absent",
    "next_to", "no_antecedents", "none_of_them", "not_imperative", "nothing", "nounless", "ones",
    "option", "orbiting", "others", "owners", "parking", "parts", "passing", "past", "people",
    "personal", "persons", "place_prepositions", "plural", "pronouns", "purposes", "quantifiers",
    "questions", "raising", "rear", "reflexives", "regarding", "rest", "returning", "robot", "rows",
    "same_again", "selves", "sending", "sentence_ends", "single", "singular", "stacking", "start",
    "stating", "straight", "stressed", "stressing", "subject_links", "swapping", "telling", "these",
    "touching", "universal", "unloading", "until", "when", "whichever", "whole", "with_verb", "you",
]
# fmt: on
"""Names of the sets of words."""
CountTable = Literal["ordinals", "cardinals", "counts"]
ValueTable = Literal["fractions", "numbers", "metres", "seconds", "radians", "circles"]
FormTable = Literal["short_forms", "contracted", "nominals", "phrasal_verbs", "kinds"]
Kind = Literal["concept", "class", "colour", "size", "kind", "cue"]
"""Kinds of which several rows are members."""
K = TypeVar("K", bound=str)
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


class _Lookup(dict[K, V]):
    """Values by the names of rows, each made when it is first looked up."""

    def __init__(self, make: Callable[[Row], V]) -> None:
        super().__init__()
        self._make = make

    def __missing__(self, name: K) -> V:
        value = self[name] = self._make(rows()[name])
        return value


def _word_set(row: Row) -> frozenset[str]:
    return stems(written(row)) if row.stems else written(row)


def _values(row: Row) -> Mapping[str, float]:
    return {w: n for name in row.include for w, n in _values(rows()[name]).items()} | row.values


WORDS: Mapping[WordSet, frozenset[str]] = _Lookup[WordSet, frozenset[str]](_word_set)
"""Sets of words."""
COUNTS: Mapping[CountTable, Mapping[str, int]] = _Lookup[CountTable, Mapping[str, int]](
    lambda row: {word: int(n) for word, n in _values(row).items()}
)
"""Whole numbers that words stand for."""
VALUES: Mapping[ValueTable, Mapping[str, float]] = _Lookup[ValueTable, Mapping[str, float]](_values)
"""Numbers that words stand for, and units in m, s and rad."""
FORMS: Mapping[FormTable, Mapping[str, str]] = _Lookup[FormTable, Mapping[str, str]](
    lambda row: row.forms
)
"""Forms that words stand for."""
