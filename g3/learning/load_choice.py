"""Choice of the load that a command is about: evidence that survives a wrong parse.

A clause's factor sees the words of that clause. Here a conditional logit over all loads of a world
sees the whole command by a few generic features: a learned lexicon, labels, sides and distances
among loads alike. It learns from what was done, so that no clauses are needed.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.special import expit, softmax
from threadpoolctl import threadpool_limits

from g3.groundings import FloatArray
from g3.language.lexicon.field_words import normalise
from g3.language.lexicon.tables import WORDS, members, written
from g3.language.similarity.learned_lexicon import Lexicon, Naming, Term, terms
from g3.short_repr import short_repr

ROLES = ("first word", "each later word", "word after a preposition")
"""Weights of a logistic function: evidence that a word names the load."""
THINGS = ("words", "first label", "distance", "side", "nearness")
"""Evidence of a load: weights of a conditional logit."""
CENTRE = np.array([0.0, -0.3, -1.0, 1.0, 0.0, 0.0, 0.0, 0.0])
"""Parameters where nothing was learned from, those of `ROLES` first."""
STEPS = 20
UNRELATED, RELATED = 1.0, 4.0
"""Prior counts of each person's commands that are unrelated or related to their outcomes."""


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """Evidence of a command's words and a world for its loads.

    Parameters
    ----------
    odds
        Likelihood ratio of each word for each load if the word names it; shape (words, loads).
    roles
        `ROLES` of each word, shape (words, 3).
    things
        `THINGS` but the words, of each load, shape (loads, 4).
    """

    odds: FloatArray
    roles: FloatArray
    things: FloatArray

    def score(self, parameters: FloatArray) -> FloatArray:
        """Score each load, in nats but for a constant; shape (loads,)."""
        roles, weights = np.split(parameters, [len(ROLES)])
        names = expit(self.roles @ roles)[:, None]
        words = np.log1p(names * (self.odds - 1)).sum(axis=0)
        return np.column_stack((words, self.things)) @ weights


def fit(
    evidence: Sequence[Evidence],
    right: Sequence[npt.NDArray[np.bool_]],
    counted: FloatArray,
    l2: float,
) -> FloatArray:
    """Parameters under which what was meant is most probable.

    Parameters
    ----------
    evidence, right
        Evidence on the loads of each command, and the meant load.
    counted
        Weight of each command, shape (commands,).
    l2
        Strength of the prior that draws parameters to `CENTRE`.
    """
    if not evidence:
        return CENTRE
    rows = _Rows(evidence, right, counted)

    def objective(parameters: FloatArray) -> tuple[float, FloatArray]:
        away = parameters - CENTRE
        value, slope = rows.loss(parameters)
        return value + 0.5 * l2 * float(away @ away), slope + l2 * away

    return lbfgs(objective, CENTRE)


class _Rows:
    """All commands, with a row for each load, and one for each word with each load."""

    def __init__(
        self,
        evidence: Sequence[Evidence],
        right: Sequence[npt.NDArray[np.bool_]],
        counted: FloatArray,
    ) -> None:
        sizes = np.array([len(one.things) for one in evidence])
        self.starts = np.cumsum([0, *sizes[:-1]])
        self.command = np.repeat(np.arange(len(sizes)), sizes)
        self.right = np.concatenate(right)
        self.counted = counted
        self.things = np.vstack([one.things for one in evidence])
        self.roles = np.vstack([np.repeat(e.roles, len(e.things), axis=0) for e in evidence])
        self.above = np.concatenate([one.odds.ravel() for one in evidence]) - 1
        of_load = [
            np.tile(np.arange(start, start + size), len(one.roles))
            for one, start, size in zip(evidence, self.starts, sizes, strict=True)
        ]
        self.load = np.concatenate(of_load).astype(int)

    def loss(self, parameters: FloatArray) -> tuple[float, FloatArray]:
        """Negative logarithm of the likelihood, and its gradient."""
        roles, weights = np.split(parameters, [len(ROLES)])
        names = expit(self.roles @ roles)
        mixed = 1 + names * self.above
        words = np.bincount(self.load, np.log(mixed), len(self.things))
        columns = np.column_stack((words, self.things))
        score = columns @ weights
        share, log_all = self._shares(score)
        share_right, log_right = self._shares(np.where(self.right, score, -np.inf))
        slope = (share - share_right) * self.counted[self.command]
        of_word = slope[self.load] * weights[0] * self.above / mixed * names * (1 - names)
        value = float(self.counted @ (log_all - log_right))
        return value, np.concatenate((self.roles.T @ of_word, columns.T @ slope))

    def _shares(self, score: npt.NDArray[Any]) -> tuple[FloatArray, FloatArray]:
        top = np.maximum.reduceat(score, self.starts)
        mass = np.exp(score - top[self.command])
        total = np.add.reduceat(mass, self.starts)
        return mass / total[self.command], top + np.log(total)


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """Outcomes of commands, and their writers.

    Parameters
    ----------
    people
        Author of each command.
    probable, chance
        Probability of the outcome, given the command and by chance; shape (commands,).
    """

    people: Sequence[str]
    probable: FloatArray
    chance: FloatArray

    def unrelated(self, shares: Mapping[str, float]) -> dict[str, float]:
        """Return the share of each person's commands that are unrelated to their outcomes.

        By expectation maximisation with a Beta prior.
        """
        who, result = np.array(self.people), dict(shares)
        for _ in range(STEPS):
            related = self.related(result)
            for person in dict.fromkeys(self.people):
                of_person = related[who == person]
                result[person] = float(
                    (UNRELATED + (1 - of_person).sum()) / (UNRELATED + RELATED + len(of_person))
                )
        return result

    def related(self, shares: Mapping[str, float]) -> FloatArray:
        """Return the probability that each command is related to its outcome, shape (commands,)."""
        unrelated = np.array([shares.get(person, unknown_person({})) for person in self.people])
        both = (1 - unrelated) * self.probable
        return both / (both + unrelated * self.chance)


def unknown_person(shares: Mapping[str, float]) -> float:
    """Return the share of a new person: the mean over people, with the prior as one of them."""
    return float(np.mean([UNRELATED / (UNRELATED + RELATED), *shares.values()]))


DEFAULT_L2 = 1.0
PARAMETERS = (*ROLES, *THINGS)
"""Names of the learned weights, in their order."""
ROUNDS = 3
"""Number of rounds of learning lexicon and parameters, with estimates of reliability between."""
_LEFT, _RIGHT = (written(members("concept")[side]) for side in ("left", "right"))


class Load(NamedTuple):
    """A thing that could be picked up.

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
        The meant load; none where that isn't known.
    corpus, scenario
        Names of its corpus and scenario.
    person
        Its author; empty if unknown.
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

        A name of nearly everything distinguishes nothing: "pallet".
        """
        counts = Counter(label for load in self.loads for label in load.labels)
        common = {label for label, count in counts.items() if 2 * count > len(self.loads)}
        return [
            tuple(x for x in load.labels if x not in common) or load.labels for load in self.loads
        ]


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class LoadChooser:
    """Learned choice of the load that a command is about.

    Parameters
    ----------
    weights
        Values of `PARAMETERS`, shape (8,).
    unrelated
        Probability that a command of an unknown person has nothing to do with the outcome.
    people
        Such probabilities of each person who taught it, as ``corpus/person``; a file of a model has
        none.
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
            evidence = _evidence_elsewhere(telling, choices, counted)
            count = np.array([counted.get(c, 1.0) for c in telling])
            weights = fit(evidence, right, count, l2)
            if once_more and evidence:
                probable = np.array(
                    [
                        softmax(e.score(weights))[r].sum()
                        for e, r in zip(evidence, right, strict=True)
                    ]
                )
                seen = Seen(people, probable, np.array([flags.mean() for flags in right]))
                shares = seen.unrelated(shares)
                counted = dict(zip(telling, seen.related(shares).tolist(), strict=True))
        return cls(lexicon_of(choices, counted), weights, unknown_person(shares), shares)

    def log_probability(self, choice: LoadChoice) -> FloatArray:
        """Return the log-probability that each load is meant, shape (loads,)."""
        share = softmax(evidence(choice, self.lexicon).score(self.weights))
        return np.log((1 - self.unrelated) * share + self.unrelated / len(share))


def lexicon_of(
    choices: Iterable[LoadChoice], counted: Mapping[LoadChoice, float] = MappingProxyType({})
) -> Lexicon:
    """Learn a lexicon from the loads of commands, of which some may count less."""
    return Lexicon.learn(
        Naming(choice.words, kind, choice.corpus, counted.get(choice, 1.0) / sum(choice.right))
        for choice in choices
        for kind, right in zip(choice.kinds, choice.right, strict=False)
        if right
    )


def evidence(choice: LoadChoice, lexicon: Lexicon) -> Evidence:
    """Return the evidence of a command's words for each load, with a lexicon."""
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
    """Return the evidence of each command, with a lexicon that hasn't seen its scenario."""
    lexicons = {
        scenario: lexicon_of((c for c in choices if c.scenario != scenario), counted)
        for scenario in dict.fromkeys(c.scenario for c in telling)
    }
    return [evidence(c, lexicons[c.scenario]) for c in telling]


def _is_placed(term: Term, words: Sequence[str]) -> bool:
    """Check that a word stands in a phrase that a preposition of place begins."""
    for word in reversed(words[: term.place]):
        if word in WORDS["place_prepositions"]:
            return True
        if word not in WORDS["articles"] and not terms([word]):
            return False
    return False


def _first_label(choice: LoadChoice) -> FloatArray:
    """1 for the loads that have the first word among their labels which some, not all, have."""
    labels = [{normalise(label) for label in load_labels} for load_labels in choice.telling]
    for word in map(normalise, choice.words):
        matches = np.array([word in load_labels for load_labels in labels], dtype=float)
        if 0 < matches.sum() < len(matches):
            return matches
    return np.zeros(len(labels))


def _among_alike(choice: LoadChoice) -> tuple[FloatArray, FloatArray]:
    """Return how far each load is to the named side among those alike; else how near it is.

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
    """Return the share of those alike that come after each one, less those before it."""
    beats = np.sign(order[:, None] - order[None, :]) * alike
    result: FloatArray = beats.sum(axis=1) / np.maximum(alike.sum(axis=1) - 1, 1)
    return result


def lbfgs(
    objective: Callable[[FloatArray], tuple[float, FloatArray]], start: FloatArray, **options: Any
) -> FloatArray:
    """Minimise a function; shape (parameters,).

    Parameters
    ----------
    objective
        The function's value and gradient at a point, shape (parameters,).
    **options
        SciPy's options, such as ``maxiter`` (:func:`scipy.optimize.minimize`).
    """
    from scipy import optimize  # noqa: PLC0415 - a fifth of a second, which only training waits for

    how: Any = options  # SciPy's stubs want every name written out
    # The vectors are short: BLAS threads cost more than they bring, twentyfold on a busy machine.
    with threadpool_limits(limits=1, user_api="blas"):
        minimum = optimize.minimize(objective, start, jac=True, method="L-BFGS-B", options=how)
    return minimum.x
