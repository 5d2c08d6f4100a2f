"""The words of an SDC's fields in the form that features see."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache

from g3.language.lexicon.spelling import mended
from g3.language.lexicon.stemming import stem
from g3.language.lexicon.tables import FORMS, WORDS
from g3.sdc.clauses import SDC, Span, all_words

_AROUND = '"`.,;:!?()[]{}<>*-'
"""Punctuation around words, but for apostrophes."""


@lru_cache(maxsize=65536)
def normalise(word: str) -> str:
    """A word in lower case, without punctuation around it, mended and stemmed (Porter 2).

    >>> normalise("Pallets,"), normalise("beetween")
    ('pallet', 'between')
    """
    return stem(bare(word))


@lru_cache(maxsize=65536)
def bare(word: str) -> str:
    """A word in lower case, without punctuation around it, not shortened, and mended.

    >>> bare("Pallets,"), bare("'em"), bare("Pikc")
    ('pallets', 'them', 'pick')
    """
    return "to" if word in WORDS["arrows"] else mended(unshortened(word.strip(_AROUND)))


def bare_words(spans: Iterable[Span]) -> list[str]:
    """Return words of a clause as :func:`bare` has them."""
    return [bare(span.text) for span in spans]


def text_words(text: str) -> tuple[str, ...]:
    """The words of a text in lower case, without punctuation around them, and not shortened.

    >>> text_words("Lift it, pls - NOW!")
    ('lift', 'it', 'please', 'now')
    """
    return tuple(word for part in text.split() if (word := bare(part)))


def unshortened(word: str) -> str:
    """A word in lower case, written out if it is a short form; other capitals are names.

    >>> unshortened("'re"), unshortened("ur"), unshortened("n"), unshortened("N"), unshortened("L")
    ('are', 'your', 'and', 'n', 'left')
    """
    own = word.strip("'’").lower()
    if word[:1] in ("'", "’") and word[-1:] not in ("'", "’"):
        return FORMS["contracted"].get(own, own)
    return FORMS["capitals"].get(own, own) if len(word) == 1 and word.isupper() else spelt(own)


def spelt(word: str) -> str:
    """A word in lower case as it is usually spelt: of a short form, or of a dialect.

    >>> spelt("ur"), spelt("tae"), spelt("truck")
    ('your', 'to', 'truck')
    """
    return FORMS["short_forms"].get(word) or FORMS["dialect"].get(word, word)


def field_words(spans: Iterable[Span]) -> tuple[str, ...]:
    """Normal forms of the words of a field, in order, empty ones dropped."""
    return tuple(word for span in spans if (word := normalise(span.text)))


def figure_words(sdc: SDC) -> tuple[str, ...]:
    """Normal forms of the words that name the figure."""
    return field_words(figure_spans(sdc))


def figure_name(sdc: SDC) -> tuple[str, ...]:
    """The words that name the figure as they are written, for looking them up."""
    return tuple(word for span in figure_spans(sdc) if (word := bare(span.text)))


def figure_spans(sdc: SDC) -> tuple[Span, ...]:
    """Words that name the figure.

    A leaf's own words; otherwise those of the clauses in the figure field, and those of
    a noun's complement: "pallet" and "tires" name one thing in "the pallet of tires", but
    not in "the truck with tires".
    """
    if sdc.is_leaf:
        return sdc.words
    named = sdc.figure
    if sdc.type == "OBJECT" and field_words(sdc.relation) == ("of",):
        named = (*named, *sdc.landmark1)
    return tuple(span for child in named for span in all_words(child))
