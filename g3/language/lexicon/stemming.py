"""Stems of words."""

from __future__ import annotations

from collections.abc import Iterable

import snowballstemmer

_STEMMER = snowballstemmer.stemmer("english")


def stem(word: str) -> str:
    """Return a word in lower case without its ending (Porter 2).

    >>> stem("lifting"), stem("tires")
    ('lift', 'tire')
    """
    result: str = _STEMMER.stemWord(word)
    return result


def stems(words: Iterable[str]) -> frozenset[str]:
    """Return the stems of words in lower case."""
    return frozenset(map(stem, words))
