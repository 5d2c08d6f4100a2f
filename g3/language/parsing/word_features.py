"""Features of words in their commands, as hashed ids.

What a word does shows in the word, its part of speech and dependency (spaCy's), its
neighbours, and what stands before it in its clause: the verb, the last noun, the last
preposition. A feature is a template filled with such attributes; its id is a 64-bit mix of
the template's number and the ids of the values, so that a batch of commands is a few NumPy
operations and nothing has to be looked up by name.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from g3.language.lexicon.verb_classes import word_class
from g3.language.parsing.spacy_pipeline import VECTOR, Analysis

IdArray = npt.NDArray[np.uint64]
IndexArray = npt.NDArray[np.intp]

PRIME = 0x9E3779B97F4A7C15
"""Multiplying by it spreads ids over 64 bits (Fibonacci hashing)."""
_PRIME = np.uint64(PRIME)
_SHIFT = np.uint64(29)
OUTSIDE = np.uint64(0)
"""The id of what stands before the first and after the last word."""
REACH = 3
"""How far neighbours are looked at."""

VERB_TAGS = ("VB", "VBP", "VBZ", "VBD", "VBG", "VBN")
NOUN_TAGS = ("NN", "NNS", "NNP", "NNPS", "PRP", "EX", "CD")
PREPOSITION_TAGS = ("IN", "TO", "RP")

TEMPLATES: tuple[tuple[str, ...], ...] = tuple(
    tuple(line.split())
    for line in """
    w0
    w-1
    w+1
    w-2
    w+2
    t0
    t-1
    t+1
    t-2
    t+2
    d0
    c0
    s0
    w0 t0
    w-1 w0
    w0 w+1
    w-1 t0
    t0 w+1
    c-1 w0
    w0 c+1
    t-1 t0
    t0 t+1
    t-1 t0 t+1
    t-2 t-1 t0
    t0 t+1 t+2
    w-1 w0 w+1
    w0 w+1 w+2
    w-2 w-1 w0
    w0 d0
    t0 d0
    w0 headtag
    d0 headtag
    t0 d0 headword
    w0 headclass
    w0 verb
    w0 verbclass
    t0 verbclass
    w0 verb nouns
    w0 verbclass nouns
    t0 verbclass nouns
    w0 nouns preps
    t0 nouns preps
    w0 noun
    w0 nextnoun
    w0 nextclass
    w0 verbclass nextclass
    w0 w+1 verbclass
    w0 w+1 w+2 verbclass
    w0 prep
    w0 prep verbclass
    w0 nextprep
    w0 verbclass nextprep
    w0 verbclass prep nextprep
    t0 gap
    w0 gap
    w0 fromhead
    """.strip().splitlines()
)
"""Attributes whose values make a feature together: w word, t part of speech, d dependency, c
class, s last three letters, of the word and its neighbours; the head; the last verb, noun and
preposition before it and the next ones; how many nouns and prepositions stand between the verb
and the word; how far the verb is; and the direction of the head."""


MOVE_TEMPLATES: tuple[tuple[str, ...], ...] = ((), ("w0",), ("t0",), ("c0",), ("w-1",))
"""The features that speak for pairs of roles."""


@lru_cache(maxsize=65536)
def string_id(text: str) -> int:
    """A 64-bit id of a text, the same in every process (FNV-1a); 0 for none."""
    value = 0xCBF29CE484222325 if text else 0
    for byte in text.encode():
        value = ((value ^ byte) * 0x100000001B3) & 0xFFFFFFFFFFFFFFFF
    return value


@lru_cache(maxsize=65536)
def _word_ids(word: str) -> tuple[int, int, int]:
    """Ids of a word, its class and its ending."""
    return string_id(word), string_id(word_class(word)), string_id(word[-3:])


class Features(NamedTuple):
    """Features of n words.

    Parameters
    ----------
    roles, moves
        Ids of those that speak for roles (n, t) and for pairs of roles (n, u).
    vectors
        The words in their contexts, as spaCy sees them, shape (n, VECTOR).
    """

    roles: IdArray
    moves: IdArray
    vectors: npt.NDArray[np.float32]


def features(commands: Sequence[Analysis]) -> Features:
    """The features of all words of some commands."""
    attributes = _attributes(commands)
    vectors = np.concatenate([c.vectors for c in commands] or [np.zeros((0, VECTOR), np.float32)])
    return Features(_mix(attributes, TEMPLATES), _mix(attributes, MOVE_TEMPLATES), vectors)


def _mix(attributes: dict[str, IdArray], templates: Sequence[Sequence[str]]) -> IdArray:
    ids = np.empty((len(templates), len(attributes["w0"])), dtype=np.uint64)
    for number, template in enumerate(templates):
        row = ids[number]
        row[:] = string_id(" ".join(template))
        for name in template:
            np.bitwise_xor(row, attributes[name], out=row)
            np.multiply(row, _PRIME, out=row)
            np.bitwise_xor(row, row >> _SHIFT, out=row)
    mixed: IdArray = ids.T
    return mixed


def _attributes(commands: Sequence[Analysis]) -> dict[str, IdArray]:
    lengths = np.array([len(c.lower) for c in commands], dtype=np.intp)
    starts = np.cumsum(lengths) - lengths
    start = np.repeat(starts, lengths)
    end = np.repeat(starts + lengths, lengths)
    n = len(start)
    position = np.arange(n)

    def joined(pick: Callable[[Analysis], IdArray]) -> IdArray:
        parts = [pick(c) for c in commands]
        return np.concatenate(parts) if parts else np.zeros(0, dtype=np.uint64)

    words = [_word_ids(word) for c in commands for word in c.lower]
    w, c, s = np.array(words, dtype=np.uint64).reshape(-1, 3).T
    t, d = joined(lambda a: a.tag), joined(lambda a: a.dep)
    head = start + np.concatenate([a.head for a in commands] or [np.zeros(0, dtype=np.int64)])

    found: dict[str, IdArray] = {"s0": s, "d0": d}
    for name, values in (("w", w), ("t", t), ("c", c)):
        found[f"{name}0"] = values
        for offset in range(1, REACH):
            found[f"{name}-{offset}"] = _at(values, position - offset, start, end)
            found[f"{name}+{offset}"] = _at(values, position + offset, start, end)
    found["headtag"], found["headword"], found["headclass"] = t[head], w[head], c[head]
    found["fromhead"] = np.sign(head - position).astype(np.int64).view(np.uint64)

    is_verb, is_noun, is_prep = (
        np.isin(t, [string_id_of_tag(tag) for tag in tags])
        for tags in (VERB_TAGS, NOUN_TAGS, PREPOSITION_TAGS)
    )
    verb = _last(is_verb, position, start)
    noun, prep = _last(is_noun, position, start), _last(is_prep, position, start)
    following = _next(is_noun, position, end)
    found["verb"], found["verbclass"] = _at(w, verb, start, end), _at(c, verb, start, end)
    found["noun"], found["prep"] = _at(w, noun, start, end), _at(w, prep, start, end)
    found["nextnoun"] = _at(w, following, start, end)
    found["nextclass"] = _at(c, following, start, end)
    found["nextprep"] = _at(w, _next(is_prep, position, end), start, end)
    since = np.maximum(verb, start)
    found["nouns"] = _count(is_noun, since, position)
    found["preps"] = _count(is_prep, since, position)
    found["gap"] = np.minimum(position - since, 4).astype(np.uint64)
    return found


def string_id_of_tag(tag: str) -> int:
    """The id that spaCy gives a part of speech."""
    from spacy.strings import get_string_id  # noqa: PLC0415 - spaCy is loaded when needed

    value: int = get_string_id(tag)
    return value


def _at(values: IdArray, index: IndexArray, start: IndexArray, end: IndexArray) -> IdArray:
    inside = (index >= start) & (index < end)
    result: IdArray = np.where(inside, values[np.where(inside, index, 0)], OUTSIDE)
    return result


def _last(mask: npt.NDArray[np.bool_], position: IndexArray, start: IndexArray) -> IndexArray:
    """Where the last word before each one is that the mask has; -1 if none is in the command."""
    if not len(mask):
        return position
    marked = np.maximum.accumulate(np.where(mask, position, -1))
    before = np.concatenate([[-1], marked[:-1]])
    return np.where(before >= start, before, -1)


def _next(mask: npt.NDArray[np.bool_], position: IndexArray, end: IndexArray) -> IndexArray:
    if not len(mask):
        return position
    n = len(mask)
    marked = np.minimum.accumulate(np.where(mask, position, n)[::-1])[::-1]
    after = np.concatenate([marked[1:], [n]])
    return np.where(after < end, after, -1)


def _count(mask: npt.NDArray[np.bool_], since: IndexArray, position: IndexArray) -> IdArray:
    """How many words the mask has from `since` up to each one, at most 3."""
    total = np.concatenate([[0], np.cumsum(mask)])
    counted: IdArray = np.minimum(total[position] - total[since], 3).astype(np.uint64)
    return counted
