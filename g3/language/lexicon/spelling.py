"""Misspelt words that decide how a command is built: "the frthest pallet", "pikc it up".

Other words need none of this, as they are compared with labels by their spelling. A misspelt verb,
preposition or word for a side has no label to be compared with, and would say nothing.

What is a word of English is no misspelling, so "closet" isn't "closest". pyspellchecker knows
them, and how frequent they are.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

from g3.language.lexicon.tables import WORDS
from g3.language.lexicon.verb_classes import word_class

if TYPE_CHECKING:
    from spellchecker import SpellChecker

SHORTEST, LONGEST = 4, 16
"""Letters of a word that is looked at. Shorter ones have too many neighbours."""


@lru_cache(maxsize=1)
def _english() -> SpellChecker:
    from spellchecker import SpellChecker  # noqa: PLC0415 - slow to import

    return SpellChecker(distance=1)


def mended(word: str) -> str:
    """The word that was meant, if a word is none, and one slip away from one that decides.

    A letter may be left out, added, another one, or swapped with the next; not the first one.

    Parameters
    ----------
    word
        In lower case, without punctuation around it.

    >>> mended("frthest"), mended("pikc"), mended("closet"), mended("conex")
    ('furthest', 'pick', 'closet', 'conex')
    """
    if not SHORTEST <= len(word) <= LONGEST or not _is_spelt(word) or _decides(word):
        return word
    english = _english()
    if word in english:
        return word
    near = english.known(english.edit_distance_1(word))
    meant = [other for other in near if other[0] == word[0] and _decides(other)]
    return max(meant, key=lambda other: (english[other], other), default=word)


def _is_spelt(word: str) -> bool:
    return word.isascii() and word.isalpha()


def _decides(word: str) -> bool:
    return len(word) >= SHORTEST and bool(word in WORDS["mended"] or word_class(word))
