"""Adjectives for what things are like: their colours and their sizes."""

from __future__ import annotations

from collections.abc import Iterable

from g3.groundings import Colour
from g3.language.lexicon.word_sets import COLOUR_WORDS, SIZE_WORDS, Dimension

_COLOURS = {word: colour for colour, words in COLOUR_WORDS.items() for word in words.split()}


def colours_named(words: Iterable[str]) -> frozenset[Colour]:
    """The colours that words name, each word in lower case as it is written.

    >>> sorted(colours_named(["the", "red", "and", "navy", "crates"]))
    ['blue', 'red']
    """
    return frozenset(_COLOURS[word] for word in words if word in _COLOURS)


def sizes_named(words: Iterable[str]) -> list[tuple[tuple[Dimension, int], ...]]:
    """What each adjective of size may say: dimensions, and 1 for much or -1 for little of it.

    >>> sizes_named(["the", "tall", "box"])
    [(('height', 1),)]
    >>> sizes_named(["the", "shorter", "one"])
    [(('height', -1), ('length', -1))]
    """
    said = (tuple(s for s, own in _SIZES if word in own) for word in words)
    return [senses for senses in said if senses]


_SIZES = [(sense, frozenset(own.split())) for sense, own in SIZE_WORDS.items()]
