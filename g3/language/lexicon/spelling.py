"""Misspelt words for where things are: "the frthest pallet".

Nouns need none of this, as their labels are compared by their spelling. A word for a side, a
distance or a number has no label to be compared with, and misspelt it would say nothing.
"""

from __future__ import annotations

from rapidfuzz.distance import OSA
from rapidfuzz.process import extractOne

from g3.language.lexicon.word_sets import LIKE_WHERE, WHERE

_VOCABULARY = tuple(sorted(WHERE))
SHORTEST = 6
"""Shorter words have too many neighbours."""


def mended(word: str) -> str:
    """The word that was meant, if it is one letter away from a word for where things are.

    Parameters
    ----------
    word
        In lower case, without punctuation around it.

    >>> mended("frthest"), mended("cloesst"), mended("closet"), mended("pallet")
    ('farthest', 'closest', 'closet', 'pallet')
    """
    return word if word in LIKE_WHERE else one_letter_away(word, _VOCABULARY)


def one_letter_away(word: str, vocabulary: tuple[str, ...]) -> str:
    """The word of a vocabulary that a long word misspells, else the word itself.

    A letter may be left out, added, another one, or swapped with the next.

    >>> one_letter_away("palllet", ("pallet",)), one_letter_away("pallets", ("pallet",))
    ('pallet', 'pallets')
    """
    if len(word) < SHORTEST or not word.isalpha() or word.removesuffix("s") in vocabulary:
        return word
    nearest = extractOne(word, vocabulary, scorer=OSA.distance, score_cutoff=1)
    return word if nearest is None else str(nearest[0])
