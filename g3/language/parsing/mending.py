"""Misspellings that the parser stumbles over.

A word that nobody knows is most likely one of the words that commands are made of, misspelt. It is
mended where exactly one of these is a single slip away.
"""

from __future__ import annotations

from collections.abc import Set as AbstractSet
from functools import lru_cache

from rapidfuzz.distance import OSA
from rapidfuzz.process import extract, extractOne

from g3.language.lexicon.word_sets import (
    CARDINALS,
    CONCEPT_WORDS,
    ORDINALS,
    QUANTIFIERS,
    WORD_CLASSES,
)

ALIASES = {
    "tailor": "trailer",
    "palette": "pallet",
    "palettes": "pallets",
    "pallette": "pallet",
    "tyre": "tire",
    "tyres": "tires",
    "lorry": "truck",
    "infront": "before",
    "inbetween": "between",
    "thats": "that",
    "foward": "forward",
    "grey": "gray",
}
"""Words that are words, or that people write in more than one way."""

_COMMON = (
    "pallet pallets trailer trailers forklift barrel forward backward behind between toward "
    "towards straight platform package packages receiving storage slowly directly"
)
VOCABULARY = tuple(_COMMON.split())
"""Words of the domain that are often misspelt and look like few others."""

SHORTEST = 6
"""Shorter words have too many neighbours."""
SHORTEST_UNKNOWN = 4
"""Nor are shorter words mended that nobody knows."""
FREQUENT = tuple(
    sorted(
        word
        for word in {
            *VOCABULARY,
            *" ".join((*CONCEPT_WORDS.values(), *WORD_CLASSES.values())).split(),
            *ORDINALS,
            *CARDINALS,
            *QUANTIFIERS,
        }
        if len(word) >= SHORTEST_UNKNOWN and word.isalpha()
    )
)
"""Words that commands are made of: those for what to do and where, and `VOCABULARY`."""


@lru_cache(maxsize=65536)
def mend(word: str) -> str:
    """The word that was meant, as far as that is plain.

    >>> mend("palllet"), mend("tailor"), mend("barrels")
    ('pallet', 'trailer', 'barrels')
    """
    if word in ALIASES:
        return ALIASES[word]
    if len(word) < SHORTEST or not word.isalpha() or word.removesuffix("s") in VOCABULARY:
        return word
    nearest = extractOne(word, VOCABULARY, scorer=OSA.distance, score_cutoff=1)
    return word if nearest is None else str(nearest[0])


def mend_unknown(word: str, known: AbstractSet[str]) -> str:
    """The only one of `FREQUENT` that an unknown word is a slip away from; else the word.

    Parameters
    ----------
    word
        A word in lower case.
    known
        Words that are spelt rightly, in the singular or the plural.

    >>> mend_unknown("bewteen", frozenset()), mend_unknown("canters", frozenset({"canter"}))
    ('between', 'canters')
    """
    if len(word) < SHORTEST_UNKNOWN or not word.isalpha() or word in FREQUENT:
        return word
    if not known.isdisjoint((word, f"{word}s", word.removesuffix("s"))):
        return word
    near = extract(word, FREQUENT, scorer=OSA.distance, score_cutoff=1, limit=2)
    # The first letter is hardly ever the one that is wrong.
    alike = [found for found, *_ in near if found[0] == word[0]]
    return str(alike[0]) if len(near) == len(alike) == 1 else word
