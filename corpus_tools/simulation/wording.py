"""Simulated workers, and how they put a command's text and its SDC trees together.

The model: a worker has habits that are drawn once (politeness, capitals, a rate of misspelt
words, a rate of phrases that fit several things), and types each word and phrase by them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from g3.sdc.clauses import SDC, SDCType, Span
from g3.short_repr import short_repr

POLITE = ("please", "could you please", "i need you to")
_ROWS = ("qwertyuiop", "asdfghjkl", "zxcvbnm")
_SHORTEST = 4
"""Shorter words are typed right."""


@dataclass(frozen=True, slots=True)
class Worker:
    """Habits of a simulated worker."""

    id: str
    """Identifier, which marks the worker as simulated."""
    misspelling: float
    """Probability that a word of four letters or more is misspelt."""
    vagueness: float
    """Probability that a phrase may fit other things too."""
    politeness: float
    """Probability of an introduction."""
    capitals: bool
    full_stop: bool
    """True if sentences begin with a capital, and end with a full stop."""


def draw_workers(count: int, seed: int) -> tuple[Worker, ...]:
    """Draw workers; the first are the same for any number of them.

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
    """Return a word with one slip: a letter left out, doubled, swapped, or a key beside."""
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


Spell: TypeAlias = Callable[[str], str]
"""Spelling of a word by a worker."""


@short_repr
@dataclass(slots=True)
class Wording:
    """A command as it is typed."""

    spell: Spell = str
    """Spelling of each word."""
    capitals: bool = False
    """True if sentences begin with one."""
    text: str = ""
    """Text typed so far."""
    groundings: dict[int, tuple[SDC, tuple[str, ...]]] = field(default_factory=dict)
    """Ids of what clauses are grounded in, by the identity of the clause, which is kept too."""

    def say(self, words: str) -> tuple[Span, ...]:
        """Type words, and return where they stand."""
        spans = []
        for word in words.split():
            typed = self.spell(word)
            if self.capitals and (not self.text or self.text.endswith(".")):
                typed = typed[0].upper() + typed[1:]
            self.text += " " if self.text else ""
            spans.append(Span(len(self.text), typed))
            self.text += typed
        return tuple(spans)

    def mark(self, sign: str) -> None:
        """Type a punctuation mark right after the last word."""
        self.text += sign

    def ground(self, clause: SDC, *ids: str) -> SDC:
        """Note a clause's groundings, and return it."""
        self.groundings[id(clause)] = (clause, ids)
        return clause

    def grounding(self, clause: SDC) -> tuple[str, ...] | None:
        """Return ids of groundings of a clause; None if none were noted."""
        found = self.groundings.get(id(clause))
        return None if found is None else found[1]

    def leaf(self, words: str, *ids: str) -> SDC:
        """Type a leaf OBJECT."""
        return self.ground(SDC("OBJECT", words=self.say(words)), *ids)


def clause(
    type_: SDCType,
    relation: tuple[Span, ...],
    *landmarks: SDC,
    figure: SDC | None = None,
) -> SDC:
    """Return an internal clause; an EVENT without a figure is an imperative without its agent."""
    if figure is None and type_ == "EVENT":
        figure = SDC("OBJECT")
    return SDC(
        type_,
        relation=relation,
        figure=() if figure is None else (figure,),
        landmark1=landmarks[:1],
        landmark2=landmarks[1:],
    )
