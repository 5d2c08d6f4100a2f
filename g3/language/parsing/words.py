"""Cut the text of a command into words."""

from __future__ import annotations

import re
from dataclasses import dataclass

from g3.language.lexicon.field_words import spelt
from g3.language.lexicon.tables import WORDS
from g3.lengths import too_long
from g3.sdc.clauses import Span
from g3.short_repr import short_repr

MAX_WORDS = 400
"""Longest command in words; the rest of a text is left out."""
_ARROWS = "|".join(map(re.escape, sorted(WORDS["arrows"], key=len, reverse=True)))
_WORD = re.compile(rf"{_ARROWS}|[^\W_]+(?:['’.][^\W_]+)*|[^\w\s]|_")


@short_repr
@dataclass(frozen=True, slots=True)
class Words:
    """The n words and punctuation marks of a command.

    Parameters
    ----------
    text
        The command.
    spans
        The words as typed, and their places.
    forms
        The words in lower case, as they are usually spelt, with straight apostrophes.
    note
        Part of the text that was left out; empty if there is none.
    """

    text: str
    spans: tuple[Span, ...]
    forms: tuple[str, ...]
    note: str = ""


def cut(text: str) -> Words:
    """Cut a command into words.

    Of a longer command only the first `MAX_WORDS` words are kept, and nothing of one with more
    characters than :data:`g3.lengths.MAX_CHARACTERS`.

    >>> cut("Don't lift 1.5 t, pls").forms
    ("don't", 'lift', '1.5', 't', ',', 'please')
    """
    note = too_long(text)
    spans: list[Span] = []
    for match in _WORD.finditer("" if note else text):
        if len(spans) == MAX_WORDS:
            note = f"only the first {MAX_WORDS} words were parsed, which is the limit"
            break
        spans.append(Span(match.start(), match.group()))
    forms = tuple([_form(span.text) for span in spans])
    return Words(text, tuple(spans), forms, note)


def _form(word: str) -> str:
    """A word in lower case, as it is usually spelt; an arrow is read as "to"."""
    return "to" if word in WORDS["arrows"] else spelt(word.lower().replace("’", "'"))
