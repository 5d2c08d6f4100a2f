"""Spatial concepts that words name, so that "beside" can borrow from "next to".

Closed-class words for directions, contact, nearness, sources and destinations. This plays the part
for relations that word-label similarity plays for nouns (section 3.3): with a few hundred commands
most relation words occur too rarely to learn their geometry from scratch.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from functools import cache
from typing import Literal, get_args

from g3.language.lexicon.field_words import normalise
from g3.language.lexicon.tables import members, written

Concept = Literal[
    "left", "right", "front", "back", "on", "between", "near", "far", "to", "from", "first", "last"
]
"""Meanings of closed-class words of space and order."""
CONCEPTS: tuple[Concept, ...] = get_args(Concept)
SIDES: frozenset[Concept] = frozenset({"left", "right", "front", "back"})
"""Concepts of the sides of a thing."""
BESIDE = SIDES | {"near", "between"}
"""Concepts by which something stands beside a thing, on the ground."""
WAYS = SIDES | {"around"}
"""Concepts of ways that the robot can go without a landmark, and around."""


@cache
def _by_word() -> dict[str, set[Concept]]:
    by_word: dict[str, set[Concept]] = defaultdict(set)
    rows = members("concept")
    for concept in CONCEPTS:
        for word in written(rows[concept]):
            by_word[normalise(word)].add(concept)
    return dict(by_word)


def concepts(words: Iterable[str]) -> frozenset[Concept]:
    """Return the concepts that normalised words name.

    >>> sorted(concepts(["to", "the", "left", "of"]))
    ['left', 'to']
    """
    by_word = _by_word()
    return frozenset(concept for word in words for concept in by_word.get(word, ()))
