"""Vectors of words, as GloVe, word2vec and fastText write them in text files."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from g3.groundings import FloatArray
from g3.short_repr import short_repr

MOST = 200_000
"""How many words are read: files have the frequent ones first."""

DECIMALS = 6
"""More than single precision has would depend on what is multiplied at once."""


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
