"""Which load a command is about, by all of its words: evidence that survives a wrong parse.

A clause's factor sees the words of that clause. Here a conditional logit over all loads of a world
sees the whole command by a few generic features: a learned lexicon, likeness of words and labels,
sides and distances among loads alike. It learns from what was done, so that no clauses are needed.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.optimize import minimize

from g3.groundings import FloatArray
from g3.language.lexicon.field_words import normalise
from g3.language.lexicon.word_sets import CONCEPT_WORDS
from g3.language.similarity.learned_lexicon import (
    LEAST_ALIKE,
    Lexicon,
    Naming,
    likeness,
    terms,
)

FADES = 0.05
"""A word counts less by this share with each word before it: what is handled is named early."""
DEFAULT_L2 = 1.0
FEATURES = ("words", "telling word", "likeness", "first label", "distance", "side", "nearness")
"""Of a load, in the order of the weights."""
_SCALE = np.array([0.3, 1.0, 3.0, 1.0, 1.0, 1.0, 1.0])
"""Brings features to about the same size, so that one prior suits all weights."""
_LEFT, _RIGHT = (frozenset(CONCEPT_WORDS[side].split()) for side in ("left", "right"))


class Load(NamedTuple):
    """What could be picked up.

    Parameters
    ----------
    labels
        In the map.
    distance
        From the robot, in m.
    bearing
        Counter-clockwise from where the robot faces, in radians from -pi to pi.
    """

    labels: tuple[str, ...]
    distance: float
    bearing: float


@dataclass(frozen=True)
class LoadChoice:
    """A command, the loads of its world, and which of them was meant.

    Parameters
    ----------
    words
        The command, in lower case, without punctuation.
    loads
        What could be picked up.
    right
        Which it was; none where that isn't known.
    corpus, scenario
        Where it is from.
    """

    words: tuple[str, ...]
    loads: tuple[Load, ...]
    right: tuple[bool, ...] = ()
    corpus: str = ""
    scenario: str = ""

    @property
    def kinds(self) -> list[str]:
        """All labels of each load, with blanks between: its name in a lexicon."""
        return [" ".join(load.labels) for load in self.loads]

    @cached_property
    def telling(self) -> list[tuple[str, ...]]:
        """The labels of each load without those that most loads have; all of them if none is left.

        What nearly everything is called tells nothing apart: "pallet".
        """
        counts = Counter(label for load in self.loads for label in load.labels)
        common = {label for label, count in counts.items() if 2 * count > len(self.loads)}
        return [
            tuple(x for x in load.labels if x not in common) or load.labels for load in self.loads
        ]


@dataclass(frozen=True, slots=True, eq=False)
class LoadChooser:
    """What was learned of which load commands are about.

    Parameters
    ----------
    lexicon
        Words and labels.
    weights
        Of `FEATURES`, shape (7,).
    """

    lexicon: Lexicon
    weights: FloatArray

    @classmethod
    def fit(cls, choices: Sequence[LoadChoice], *, l2: float = DEFAULT_L2) -> LoadChooser:
        """Learn a lexicon and the weights of features.

        Each scenario's features are computed with a lexicon that hasn't seen it, as they will be
        for new worlds.

        Parameters
        ----------
        choices
            Commands with what was meant.
        l2
            Strength of the regularisation.
        """
        scenarios = dict.fromkeys(c.scenario for c in choices if _tells(c))
        designs, right = [], []
        for scenario in scenarios:
            lexicon = lexicon_of(c for c in choices if c.scenario != scenario)
            own = [c for c in choices if c.scenario == scenario and _tells(c)]
            designs += [features(c, lexicon) for c in own]
            right += [np.array(c.right) for c in own]
        return cls(lexicon_of(choices), _conditional_logit(designs, right, l2))

    def log_probability(self, choice: LoadChoice) -> FloatArray:
        """The logarithm of the probability that each load is meant, shape (loads,)."""
        score = features(choice, self.lexicon) @ self.weights
        result: FloatArray = score - np.logaddexp.reduce(score)
        return result


def lexicon_of(choices: Iterable[LoadChoice]) -> Lexicon:
    """A lexicon learned from what commands were about."""
    return Lexicon.learn(
        Naming(choice.words, kind, choice.corpus, 1.0 / sum(choice.right))
        for choice in choices
        for kind, right in zip(choice.kinds, choice.right, strict=False)
        if right
    )


def features(choice: LoadChoice, lexicon: Lexicon) -> FloatArray:
    """`FEATURES` of each load, shape (loads, 7)."""
    text = terms(choice.words)
    early = np.exp(-FADES * np.array([term.place for term in text]))[:, None]
    known = [*lexicon.table(text, choice.kinds) * early, np.zeros(len(choice.loads))]
    names = [" ".join(labels) for labels in choice.telling]
    alike = np.array([[likeness(t.written, name) for name in names] for t in text])
    alike = np.maximum(alike.reshape(len(text), len(names)) - LEAST_ALIKE, 0.0) * early
    columns = (
        np.sum(known, axis=0),
        np.max(known, axis=0),
        alike.max(axis=0, initial=0.0),
        _first_label(choice),
        -np.log([max(load.distance, 1.0) for load in choice.loads]),
        *_among_alike(choice),
    )
    result: FloatArray = np.column_stack(columns) * _SCALE
    return result


def _first_label(choice: LoadChoice) -> FloatArray:
    """1 for the loads that have the first word among their labels which some, not all, have."""
    labels = [{normalise(label) for label in own} for own in choice.telling]
    for word in map(normalise, choice.words):
        found = np.array([word in own for own in labels], dtype=float)
        if 0 < found.sum() < len(found):
            return found
    return np.zeros(len(labels))


def _among_alike(choice: LoadChoice) -> tuple[FloatArray, FloatArray]:
    """How far to the side that words name each load is among those alike; else how near it is.

    From -1, for the last, to 1 for the first of them; 0 for what has no like.
    """
    first = next((w for w in choice.words if w in _LEFT or w in _RIGHT), "")
    bearing = np.array([load.bearing for load in choice.loads])
    order = bearing if first in _LEFT else -bearing
    alike = np.array([[a.labels == b.labels for b in choice.loads] for a in choice.loads])
    nothing = np.zeros(len(choice.loads))
    if first:
        return _rank(order, alike), nothing
    return nothing, _rank(-np.array([load.distance for load in choice.loads]), alike)


def _rank(order: FloatArray, alike: npt.NDArray[np.bool_]) -> FloatArray:
    """How many of those alike come after each one, less those before it, as a share."""
    beats = np.sign(order[:, None] - order[None, :]) * alike
    result: FloatArray = beats.sum(axis=1) / np.maximum(alike.sum(axis=1) - 1, 1)
    return result


def _tells(choice: LoadChoice) -> bool:
    return any(choice.right) and not all(choice.right)


def _conditional_logit(
    designs: Sequence[FloatArray], right: Sequence[npt.NDArray[np.bool_]], l2: float
) -> FloatArray:
    """Weights under which what was meant is most probable."""
    if not designs:
        return np.zeros(len(FEATURES))
    rows = np.vstack(designs)
    starts = np.cumsum([0, *(len(design) for design in designs[:-1])])
    of_row = np.repeat(np.arange(len(designs)), [len(design) for design in designs])
    is_right = np.concatenate(right)

    def shares(score: FloatArray) -> tuple[FloatArray, FloatArray]:
        top = np.maximum.reduceat(score, starts)
        mass = np.exp(score - top[of_row])
        total = np.add.reduceat(mass, starts)
        return mass / total[of_row], top + np.log(total)

    def objective(weights: FloatArray) -> tuple[float, FloatArray]:
        score = rows @ weights
        all_of, log_all = shares(score)
        own, log_own = shares(np.where(is_right, score, -np.inf))
        value = float((log_all - log_own).sum() + 0.5 * l2 * weights @ weights)
        return value, rows.T @ (all_of - own) + l2 * weights

    found: FloatArray = minimize(objective, np.zeros(rows.shape[1]), jac=True, method="L-BFGS-B").x
    return found
