"""Adjectives for what things are like: their colours and their sizes."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from functools import cache
from typing import Literal, cast

from g3.groundings import Colour
from g3.language.lexicon.tables import members, written

Dimension = Literal["height", "length", "width", "volume"]
"""Dimensions of things that words can name."""
Sense = tuple[Dimension, int]
"""A dimension, and 1 for much or -1 for little of it."""


@cache
def _colours() -> dict[str, Colour]:
    colours = members("colour").items()
    return {word: cast("Colour", colour) for colour, row in colours for word in written(row)}


@cache
def _sizes() -> dict[str, tuple[Sense, ...]]:
    senses: dict[str, tuple[Sense, ...]] = defaultdict(tuple)
    for name, row in members("size").items():
        sense = (cast("Dimension", name.removeprefix("-")), -1 if name.startswith("-") else 1)
        for word in written(row):
            senses[word] += (sense,)
    return dict(senses)


def colours_named(words: Iterable[str]) -> frozenset[Colour]:
    """Return the colours that words name, each word in lower case as it is written.

    >>> sorted(colours_named(["the", "red", "and", "navy", "crates"]))
    ['blue', 'red']
    """
    colours = _colours()
    return frozenset(colours[word] for word in words if word in colours)


def sizes_named(words: Iterable[str]) -> list[tuple[Sense, ...]]:
    """Return the senses that each adjective of size may have.

    >>> sizes_named(["the", "tall", "box"])
    [(('height', 1),)]
    >>> sizes_named(["the", "shorter", "one"])
    [(('height', -1), ('length', -1))]
    """
    sizes = _sizes()
    return [sizes[word] for word in words if word in sizes]
