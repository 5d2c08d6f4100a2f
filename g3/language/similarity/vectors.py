"""Vectors of words: those of the bundled encoder's pieces, or a text file's.

Text files are read as GloVe, word2vec and fastText write them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Protocol

import numpy as np
import numpy.typing as npt

from g3.groundings import FloatArray
from g3.language.parsing.encoder import default_encoder
from g3.short_repr import short_repr

MOST = 200_000
"""How many words are read: files have the frequent ones first."""

DECIMALS = 6
"""More than single precision has would depend on what is multiplied at once."""


class Vectors(Protocol):
    """Vectors of words, as far as likeness needs them."""

    def cosine(self, words: Sequence[str], others: Sequence[str]) -> FloatArray:
        """Cosine between words, negative as 0, 0 for unknown ones; shape (words, others)."""


class PieceVectors:
    """Vectors of the pieces of words that the bundled encoder reads, before it reads any others.

    They are MiniLM's, which learned them from text; training on trees leaves them as they were.
    The mean of all pieces is taken off: it is common to all words (Mu and Viswanath, ICLR 2018).
    """

    def cosine(self, words: Sequence[str], others: Sequence[str]) -> FloatArray:
        """Cosine between words, negative as 0; shape (words, others)."""
        rows, columns = (np.array([_vector(text) for text in texts]) for texts in (words, others))
        if not rows.size or not columns.size:
            return np.zeros((len(words), len(others)))
        similarity: FloatArray = np.round(rows @ columns.T, DECIMALS)
        return np.clip(similarity, 0.0, 1.0)


@cache
def _mean() -> FloatArray:
    encoder = default_encoder()
    mean: FloatArray = (encoder.words * encoder.word_scales[:, None]).mean(axis=0, dtype=float)
    return mean


@lru_cache(maxsize=65536)
def _vector(text: str) -> FloatArray:
    encoder = default_encoder()
    pieces = [piece for word in text.lower().split() for piece in encoder.pieces(word)]
    if not pieces:
        return np.zeros(encoder.width)
    scales = encoder.word_scales[pieces, None]
    vectors = encoder.words[pieces] * scales - _mean()
    mean = (vectors / np.linalg.norm(vectors, axis=1, keepdims=True)).mean(axis=0)
    vector: FloatArray = mean / (np.linalg.norm(mean) or 1.0)
    return vector


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class WordVectors:
    """Vectors of v words.

    Parameters
    ----------
    rows
        The row of each word.
    values
        Vectors of length 1, shape (v, d).
    """

    rows: Mapping[str, int]
    values: npt.NDArray[np.float32]

    def cosine(self, words: Sequence[str], others: Sequence[str]) -> FloatArray:
        """Cosine between words, negative as 0, 0 for unknown ones; shape (words, others)."""
        similarity: FloatArray = np.round(self._of(words) @ self._of(others).T, DECIMALS)
        return np.clip(similarity, 0.0, 1.0)

    def _of(self, words: Sequence[str]) -> FloatArray:
        found = np.zeros((len(words), self.values.shape[1]))
        for i, word in enumerate(words):
            row = self.rows.get(word, self.rows.get(word.lower()))
            if row is not None:
                found[i] = self.values[row]
        return found


def read_vectors(lines: Iterable[str], *, most: int = MOST) -> WordVectors:
    """Read a word and its numbers from each line; a first line with two counts is skipped.

    Parameters
    ----------
    lines
        What the file has.
    most
        How many words to read.

    Raises
    ------
    ValueError
        If a line doesn't have as many numbers as the first, or there are no lines.
    """
    rows: dict[str, int] = {}
    values: list[npt.NDArray[np.float32]] = []
    size = 0  # how many numbers a word has
    for number, line in enumerate(lines, 1):
        if len(rows) == most:
            break
        fields = line.split()
        if number == 1 and len(fields) == 2 and line.replace(" ", "").strip().isdigit():
            continue
        size = size or max(len(fields) - 1, 1)
        word = " ".join(fields[:-size])  # some words have spaces
        if not word:
            raise ValueError(f"line {number} doesn't have a word and {size} numbers")
        try:
            vector = np.array(fields[-size:], dtype=np.float32)
        except ValueError:
            raise ValueError(f"line {number} doesn't have {size} numbers") from None
        length = float(np.linalg.norm(vector))
        if not np.isfinite(length):
            raise ValueError(f"line {number} has a number that isn't finite")
        if word not in rows:
            rows[word] = len(values)
            values.append(vector / np.float32(length or 1.0))
    if not values:
        raise ValueError("there are no vectors")
    return WordVectors(rows, np.array(values))
