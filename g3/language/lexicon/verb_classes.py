"""Classes of words that decide how a command is built: verbs, directions, measures."""

from __future__ import annotations

from collections import defaultdict
from functools import cache, lru_cache

from g3.language.lexicon.tables import FORMS, members, written

VERBS = frozenset(("placing", "taking", "carrying", "going", "turning", "staying"))
"""Classes of verbs, by what they ask for."""
HANDLING_VERBS = frozenset(("placing", "taking", "carrying"))
"""Those of them that handle something."""


@cache
def _by_word() -> dict[str, str]:
    classes: dict[str, list[str]] = defaultdict(list)
    for name, row in members("class").items():
        for word in written(row):
            classes[word].append(name)
    return {word: "+".join(names) for word, names in classes.items()}


@lru_cache(maxsize=65536)
def word_class(word: str) -> str:
    """Return the classes of a word, joined by "+"; empty if none is known.

    >>> word_class("putting"), word_class("carries"), word_class("pallet")
    ('placing', 'carrying', '')
    """
    by_word = _by_word()
    return next((by_word[stem] for stem in _stems(word) if stem in by_word), "")


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
    if word in FORMS["irregular"]:
        stems.append(FORMS["irregular"][word])
    return tuple(stems)
