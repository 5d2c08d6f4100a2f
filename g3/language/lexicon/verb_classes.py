"""Looks up the classes of words that decide how a command is built.

The words are in :mod:`g3.language.lexicon.word_sets`.
"""

from __future__ import annotations

from functools import lru_cache

from g3.language.lexicon.word_sets import WORD_CLASSES

_BY_WORD: dict[str, str] = {}
for _name, _words in WORD_CLASSES.items():
    for _word in _words.split():
        _BY_WORD[_word] = f"{_BY_WORD[_word]}+{_name}" if _word in _BY_WORD else _name


@lru_cache(maxsize=65536)
def word_class(word: str) -> str:
    """The classes of a word, joined by "+"; empty if none is known.

    >>> word_class("putting"), word_class("carries"), word_class("pallet")
    ('placing', 'carrying', '')
    """
    for stem in _stems(word):
        if stem in _BY_WORD:
            return _BY_WORD[stem]
    return ""


def _stems(word: str) -> tuple[str, ...]:
    stems = [word]
    if word.endswith("ing") and len(word) > 5:
        stem = word[:-3]
        stems += [stem, f"{stem}e", stem[:-1]]
    if word.endswith("ies"):
        stems.append(f"{word[:-3]}y")
    if word.endswith("es"):
        stems.append(word[:-2])
    if word.endswith("s") and not word.endswith("ss"):
        stems.append(word[:-1])
    if word.endswith("ed") and len(word) > 4:
        stems += [word[:-1], word[:-2], word[:-3]]
    return tuple(stems)
