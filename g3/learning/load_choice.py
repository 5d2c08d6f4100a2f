"""Which load a command is about, by all of its words: evidence that survives a wrong parse.

A clause's factor sees the words of that clause. Here a conditional logit over all loads of a world
sees the whole command by a few generic features: a learned lexicon, labels, sides and distances
among loads alike. It learns from what was done, so that no clauses are needed.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.special import softmax

from g3.groundings import FloatArray
from g3.language.lexicon.field_words import normalise
from g3.language.lexicon.word_sets import ARTICLES, CONCEPT_WORDS, PLACE_PREPOSITIONS
from g3.language.similarity.learned_lexicon import Lexicon, Naming, Term, terms
from g3.learning import choice_fitting
from g3.learning.choice_fitting import ROLES, THINGS, Evidence, Seen, unknown_person
from g3.short_repr import short_repr

DEFAULT_L2 = 1.0
PARAMETERS = (*ROLES, *THINGS)
"""What is learned, in the order of the weights."""
ROUNDS = 3
"""So often lexicon and parameters are learned. Between that it is found who is reliable."""
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


@short_repr
@dataclass(frozen=True)
class LoadChoice:
    """A command, the loads of its world, and which of them was meant.

    Parameters
    ----------
    words
        The command, in lower case, without punctuation.
    right
        Which it was; none where that isn't known.
    corpus, scenario
        Where it is from.
    person
        Who wrote it; empty if unknown.
    """

    words: tuple[str, ...]
    loads: tuple[Load, ...]
    right: tuple[bool, ...] = ()
    corpus: str = ""
    scenario: str = ""
    person: str = ""

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


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class LoadChooser:
    """What was learned of which load commands are about.

    Parameters
    ----------
    weights
        Of `PARAMETERS`, shape (8,).
    unrelated
        How probably a command of somebody unknown has nothing to do with what was done.
    people
        The same of each person who taught it, as ``corpus/person``; a file of a model has none.
    """

    lexicon: Lexicon
    weights: FloatArray
    unrelated: float = 0.0
    people: Mapping[str, float] = field(default_factory=dict)

    @classmethod
    def fit(cls, choices: Sequence[LoadChoice], *, l2: float = DEFAULT_L2) -> LoadChooser:
        """Learn a lexicon, parameters, and whose commands had to do with what was done.

        Each scenario's evidence is computed with a lexicon that hasn't seen it, as it will be for
        new worlds. Commands that probably were unrelated to what was done teach less.
        """
        telling = [c for c in choices if any(c.right) and not all(c.right)]
        right = [np.array(c.right) for c in telling]
        people = [f"{c.corpus}/{c.person}" for c in telling]
        counted: dict[LoadChoice, float] = {}
        shares: dict[str, float] = {}
        for once_more in reversed(range(ROUNDS)):
            known = _evidence_elsewhere(telling, choices, counted)
            count = np.array([counted.get(c, 1.0) for c in telling])
            weights = choice_fitting.fit(known, right, count, l2)
            if once_more and known:
                probable = np.array(
                    [softmax(e.score(weights))[r].sum() for e, r in zip(known, right, strict=True)]
                )
                seen = Seen(people, probable, np.array([own.mean() for own in right]))
                shares = seen.unrelated(shares)
                counted = dict(zip(telling, seen.related(shares).tolist(), strict=True))
        return cls(lexicon_of(choices, counted), weights, unknown_person(shares), shares)

    def log_probability(self, choice: LoadChoice) -> FloatArray:
        """The logarithm of the probability that each load is meant, shape (loads,)."""
        share = softmax(evidence(choice, self.lexicon).score(self.weights))
        return np.log((1 - self.unrelated) * share + self.unrelated / len(share))


def lexicon_of(
    choices: Iterable[LoadChoice], counted: Mapping[LoadChoice, float] = MappingProxyType({})
) -> Lexicon:
    """A lexicon learned from what commands were about, of which some may count less."""
    return Lexicon.learn(
        Naming(choice.words, kind, choice.corpus, counted.get(choice, 1.0) / sum(choice.right))
        for choice in choices
        for kind, right in zip(choice.kinds, choice.right, strict=False)
        if right
    )


def evidence(choice: LoadChoice, lexicon: Lexicon) -> Evidence:
    """What a command's words say of each load, with a lexicon."""
    text = [term for term in terms(choice.words) if " " not in term.form]
    roles = np.array([(1.0, i, _is_placed(term, choice.words)) for i, term in enumerate(text)])
    things = (
        _first_label(choice),
        -np.log([max(load.distance, 1.0) for load in choice.loads]),
        *_among_alike(choice),
    )
    return Evidence(
        np.exp(lexicon.table(text, choice.kinds)),
        roles.reshape(len(text), len(ROLES)),
        np.column_stack(things),
    )


def _evidence_elsewhere(
    telling: Sequence[LoadChoice],
    choices: Sequence[LoadChoice],
    counted: Mapping[LoadChoice, float],
) -> list[Evidence]:
    """The evidence of each command, with a lexicon that hasn't seen its scenario."""
    lexicons = {
        scenario: lexicon_of((c for c in choices if c.scenario != scenario), counted)
        for scenario in dict.fromkeys(c.scenario for c in telling)
    }
    return [evidence(c, lexicons[c.scenario]) for c in telling]


def _is_placed(term: Term, words: Sequence[str]) -> bool:
    """Whether a word stands in a phrase that a preposition of place begins."""
    for word in reversed(words[: term.place]):
        if word in PLACE_PREPOSITIONS:
            return True
        if word not in ARTICLES and not terms([word]):
            return False
    return False


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
