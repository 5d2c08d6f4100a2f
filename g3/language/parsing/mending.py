"""Misspellings that the parser stumbles over."""

from __future__ import annotations

from functools import lru_cache

from rapidfuzz.distance import OSA
from rapidfuzz.process import extractOne

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
