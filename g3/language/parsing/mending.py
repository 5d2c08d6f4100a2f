"""Misspellings that the parser stumbles over."""

from __future__ import annotations

from functools import lru_cache

from g3.language.lexicon.spelling import mended

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


@lru_cache(maxsize=65536)
def mend(word: str) -> str:
    """The word that was meant, as far as that is plain.

    >>> mend("palllet"), mend("tailor"), mend("barrels")
    ('pallet', 'trailer', 'barrels')
    """
    return ALIASES[word] if word in ALIASES else mended(word)
