"""Stems of words."""

from __future__ import annotations

import snowballstemmer

_STEMMER = snowballstemmer.stemmer("english")


def stem(word: str) -> str:
    """A word in lower case without its ending (Porter 2).

    >>> stem("lifting"), stem("tires")
    ('lift', 'tire')
    """
    found: str = _STEMMER.stemWord(word)
    return found
