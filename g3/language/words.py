"""The words of an SDC's fields in the form that features see."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache

import snowballstemmer

from g3.sdc import SDC, Span, all_words

_STEMMER = snowballstemmer.stemmer("english")


@lru_cache(maxsize=65536)
def normalise(word: str) -> str:
    """A word in lower case, without punctuation around it, stemmed (Porter 2).

    >>> normalise("Pallets,")
    'pallet'
    """
    bare = word.lower().strip("\"'`.,;:!?()[]{}<>*-")
    stem: str = _STEMMER.stemWord(bare)
    return stem


def field_words(spans: Iterable[Span]) -> tuple[str, ...]:
    """Normal forms of the words of a field, in order, empty ones dropped."""
    return tuple(word for span in spans if (word := normalise(span.text)))


def figure_words(sdc: SDC) -> tuple[str, ...]:
    """Words that name the figure: a leaf's own, or those of the clauses in its figure field."""
    if sdc.is_leaf:
        return field_words(sdc.words)
    return field_words(span for child in sdc.figure for span in all_words(child))
