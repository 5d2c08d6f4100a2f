"""What is learned for choosing loads by words: parameters, and who taught them reliably.

Each word of a command either names the load or something else. Which it does isn't known, so that
a load's evidence is a mixture over both, for each word: where a word names something else, it tells
nothing of the load. How probably a word names the load depends on its place, and is learned too.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.special import expit

from g3.groundings import FloatArray
from g3.lbfgs import lbfgs
from g3.short_repr import short_repr

ROLES = ("first word", "each later word", "word after a preposition")
"""What tells whether a word names the load: weights of a logistic function."""
THINGS = ("words", "first label", "distance", "side", "nearness")
"""Evidence of a load: weights of a conditional logit."""
CENTRE = np.array([0.0, -0.3, -1.0, 1.0, 0.0, 0.0, 0.0, 0.0])
"""Parameters where nothing was learned from, those of `ROLES` first."""
STEPS = 20
UNRELATED, RELATED = 1.0, 4.0
"""So many commands of each person are taken to have been unrelated to what was done, or related,
besides those that were seen."""


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """What a command's words and a world say of its loads.

    Parameters
    ----------
    odds
        How much likelier each word makes each load if the word names it; shape (words, loads).
    roles
        `ROLES` of each word, shape (words, 3).
    things
        `THINGS` but the words, of each load, shape (loads, 4).
    """

    odds: FloatArray
    roles: FloatArray
    things: FloatArray

    def score(self, parameters: FloatArray) -> FloatArray:
        """How well each load fits, in nats but for a constant; shape (loads,)."""
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
        Of each command: what is known of the loads, and which was meant.
    counted
        How much each command counts, shape (commands,).
    l2
        How strongly parameters are drawn to `CENTRE`.
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
    """What was done for commands, and who wrote them.

    Parameters
    ----------
    people
        Who wrote each command.
    probable, chance
        How probable what was done is, given the command and by chance; shape (commands,).
    """

    people: Sequence[str]
    probable: FloatArray
    chance: FloatArray

    def unrelated(self, shares: Mapping[str, float]) -> dict[str, float]:
        """How much of what each person wrote had nothing to do with what was done.

        By expectation maximisation with a Beta prior.
        """
        who, found = np.array(self.people), dict(shares)
        for _ in range(STEPS):
            related = self.related(found)
            for person in dict.fromkeys(self.people):
                own = related[who == person]
                found[person] = float(
                    (UNRELATED + (1 - own).sum()) / (UNRELATED + RELATED + len(own))
                )
        return found

    def related(self, shares: Mapping[str, float]) -> FloatArray:
        """How probably each command has to do with what was done, shape (commands,)."""
        unrelated = np.array([shares.get(person, unknown_person({})) for person in self.people])
        both = (1 - unrelated) * self.probable
        return both / (both + unrelated * self.chance)


def unknown_person(shares: Mapping[str, float]) -> float:
    """The share of somebody new: the mean over people, with what is thought before as one."""
    return float(np.mean([UNRELATED / (UNRELATED + RELATED), *shares.values()]))
