"""Spatial concepts that words name, so that "beside" can borrow from "next to".

A hand-made lexicon of closed-class words: directions, contact, nearness, sources and
destinations. It plays the part for relations that word-label similarity plays for nouns
(section 3.3): with a few hundred commands most relation words occur too rarely to learn
their geometry from scratch.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal, get_args

from g3.language.words import normalise

Concept = Literal[
    "left", "right", "front", "back", "on", "between", "near", "far", "to", "from", "first", "last"
]
CONCEPTS: tuple[Concept, ...] = get_args(Concept)

_LEXICON: dict[Concept, str] = {
    "left": "left leftmost left-most leftward leftwards left-hand",
    "right": "right rightmost right-most rightward rightwards right-hand",
    "front": "front infront ahead forward forwards before facing",
    "back": "behind back rear backward backwards reverse",
    "on": "on onto upon atop top aboard",
    "between": "between inbetween middle midway center centre among amid",
    "near": "next near nearest beside besides by close closer closest nearby alongside adjacent "
    "side",
    "far": "far farther farthest further furthest outside opposite",
    "to": "to toward towards into onto until approach reach at",
    "from": "from off out away leave",
    "first": "first nearest closest",
    "last": "last end furthest farthest",
}

_BY_WORD: dict[str, tuple[Concept, ...]] = {}
for _concept, _words in _LEXICON.items():
    for _word in _words.split():
        _form = normalise(_word)
        if _concept not in _BY_WORD.get(_form, ()):
            _BY_WORD[_form] = (*_BY_WORD.get(_form, ()), _concept)


def concepts(words: Iterable[str]) -> frozenset[Concept]:
    """The concepts that normalised words name.

    >>> sorted(concepts(["to", "the", "left", "of"]))
    ['left', 'to']
    """
    return frozenset(concept for word in words for concept in _BY_WORD.get(word, ()))
