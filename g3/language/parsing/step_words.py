"""Words that only say that the next step begins: "after that", "when this is done".

"Why don't you" and "how about you" only begin it, too.
"""

from __future__ import annotations

from collections.abc import Sequence

from g3.language.lexicon.verb_chains import is_verb
from g3.language.lexicon.word_sets import ARTICLES, SENTENCE_ENDS, words
from g3.language.parsing.numbered_steps import Token

_DONE = words("done finished completed complete over")
_THIS = words("that this it these those all")
_BE = words("is 's s are has have been")
_AFTERWARDS = words("afterwards afterward subsequently")
_BEFORE = SENTENCE_ENDS | words(", and & then -")
_SUGGESTING = (
    *(["why", "do", "n't", you] for you in ("you", "we")),
    *(["why", "do", "not", you] for you in ("you", "we")),
    ["why", "not"],
    ["how", "about", "you"],
)
_FOLLOWING = ARTICLES | words(", you please also just")


def without_step_words(tokens: Sequence[Token]) -> list[Token]:
    """Words of a text, with the end of a sentence for what says that the next step begins.

    >>> words = "drop it , and after that lift the crate . afterwards , wait".split()
    >>> " ".join(word for _, _, word in without_step_words([(0, 0, word) for word in words]))
    'drop it . lift the crate . wait'
    >>> words = "why do n't you go to the truck".split()
    >>> " ".join(word for _, _, word in without_step_words([(0, 0, word) for word in words]))
    'go to the truck'
    >>> words = "after that truck turn left".split()
    >>> len(without_step_words([(0, 0, word) for word in words]))
    5
    """
    said = [word for _, _, word in tokens]
    found: list[Token] = []
    at = 0
    while at < len(said):
        size = _size(said[at:]) if not at or said[at - 1] in _BEFORE else 0
        if not size:
            found.append(tokens[at])
            at += 1
            continue
        while found and found[-1][2] in _BEFORE:
            found.pop()
        if found:
            found.append((tokens[at][0], tokens[at + size - 1][1], "."))
        at += size
        at += said[at : at + 1] == [","]
    return found


def _size(said: Sequence[str]) -> int:
    """How many words at the beginning say that a step follows; 0 if none do."""
    if said[0] in _AFTERWARDS:
        size = 1
    elif said[0] == "after" and said[1:2] and said[1] in ("that", "this"):
        size = 2
    elif said[0] in ("when", "once", "after"):
        size = 1
        while size < len(said) and said[size] in _THIS | _BE:
            size += 1
        size = size + 1 if size < len(said) and said[size] in _DONE else 0
    else:
        size = next((len(own) for own in _SUGGESTING if list(said[: len(own)]) == own), 0)
    begins = size < len(said) and (said[size] in _FOLLOWING or is_verb(said[size]))
    return size if size and begins else 0
