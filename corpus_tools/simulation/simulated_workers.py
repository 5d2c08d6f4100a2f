"""Simulated workers: how they type.

The model: a worker has habits that are drawn once (politeness, capitals, a rate of misspelt
words, a rate of phrases that fit several things), and types each word and phrase by them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

POLITE = ("please", "could you please", "i need you to")
_ROWS = ("qwertyuiop", "asdfghjkl", "zxcvbnm")
_SHORTEST = 4
"""Shorter words are typed right."""


@dataclass(frozen=True, slots=True)
class Worker:
    """Somebody's habits."""

    id: str
    """Says that the worker is simulated."""
    misspelling: float
    """Probability that a word of four letters or more is misspelt."""
    vagueness: float
    """Probability that a phrase may fit other things too."""
    politeness: float
    """Probability of an introduction."""
    capitals: bool
    full_stop: bool
    """Whether sentences begin and end as they should."""


def draw_workers(count: int, seed: int) -> tuple[Worker, ...]:
    """Workers; the first are the same however many there are.

    Misspelling is Beta(1, 30), vagueness Beta(2, 10), politeness Beta(1, 4); two in three
    use capitals and full stops.
    """
    return tuple(_draw(number, np.random.default_rng([seed, number])) for number in range(count))


def _draw(number: int, rng: np.random.Generator) -> Worker:
    return Worker(
        id=f"simulated-{number:04}",
        misspelling=float(rng.beta(1, 30)),
        vagueness=float(rng.beta(2, 10)),
        politeness=float(rng.beta(1, 4)),
        capitals=bool(rng.random() < 2 / 3),
        full_stop=bool(rng.random() < 2 / 3),
    )


def misspell(word: str, rng: np.random.Generator) -> str:
    """A word with one slip: a letter left out, doubled, swapped with the next, or a key beside."""
    if len(word) < _SHORTEST or not word.isalpha():
        return word
    at = int(rng.integers(1, len(word) - 1))
    before, letter, after = word[:at], word[at], word[at + 1 :]
    slip = int(rng.integers(4))
    if slip == 0:
        return before + after
    if slip == 1:
        return before + letter + letter + after
    if slip == 2:
        return before + after[0] + letter + after[1:]
    return before + _beside(letter, rng) + after


def _beside(letter: str, rng: np.random.Generator) -> str:
    row = next((row for row in _ROWS if letter in row), letter)
    at = row.index(letter)
    near = row[max(0, at - 1) : at] + row[at + 1 : at + 2]
    return near[int(rng.integers(len(near)))] if near else letter
