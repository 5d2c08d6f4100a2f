"""Spatial concepts that words name, so that "beside" can borrow from "next to".

Closed-class words of :mod:`g3.language.lexicon.word_sets`: directions, contact, nearness, sources
and destinations. This plays the part for relations that word-label similarity plays for nouns
(section 3.3): with a few hundred commands most relation words occur too rarely to learn
their geometry from scratch.
"""

from __future__ import annotations

from collections.abc import Iterable

from g3.language.lexicon.field_words import normalise
from g3.language.lexicon.word_sets import CONCEPT_WORDS, CONCEPTS, Concept

__all__ = ["CONCEPTS", "Concept", "concepts"]

_BY_WORD: dict[str, tuple[Concept, ...]] = {}
for _concept, _words in CONCEPT_WORDS.items():
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
