"""Misspellings that the parser stumbles over."""

from __future__ import annotations

from functools import lru_cache

from g3.language.lexicon.spelling import one_letter_away

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


@lru_cache(maxsize=65536)
def mend(word: str) -> str:
    """The word that was meant, as far as that is plain.

    >>> mend("palllet"), mend("tailor"), mend("barrels")
    ('pallet', 'trailer', 'barrels')
    """
    return ALIASES[word] if word in ALIASES else one_letter_away(word, VOCABULARY)
