"""Errors of a model that proposed steps of episodes, by what people made of its proposals.

Intervals are those of the bootstrap over episodes (percentiles), since the steps of an episode have
their faults in common.

``accepted``, ``text changed``, ``boundary moved`` and ``removed`` are shares of the proposed steps,
``added`` is the number of new steps for each of them. ``text edit distance`` is the mean, and
``boundary error`` the median, over the steps that weren't removed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from corpus_tools.corpus.estimate import Reason

UNCHANGED, TEXT, BOUNDARY, BOTH, REMOVED = (
    "unchanged", "text changed", "boundary moved", "text changed, boundary moved", "removed",
)  # fmt: skip
ADDED = "added"
"""Fate of a step that nobody proposed."""
STATES = (UNCHANGED, TEXT, BOUNDARY, BOTH, REMOVED)
"""Fates of a proposed step."""
FEWEST_EPISODES = 10
"""Number of episodes from which there are intervals."""
DRAWS = 1000
SEED = 0

Floats: TypeAlias = npt.NDArray[np.float64]
Weights: TypeAlias = npt.NDArray[np.int64]
"""Number of times that each episode counts, shape (draws, episodes)."""


@dataclass(frozen=True, slots=True)
class StepFate:
    """The fate of a proposed step in an answer, or a step that the answer adds."""

    episode: str
    answer: str
    state: str
    """One of `STATES`, or `ADDED`."""
    decided: bool = True
    """True if the person accepted or changed it."""
    moved_s: float | None = None
    """Seconds from the proposed beginning to the person's; None without either."""
    text_distance: float = 0.0


@dataclass(frozen=True, slots=True)
class StepMeasure:
    """A figure about a model's steps, with an interval of 95 % if there are enough episodes."""

    measure: str
    value: float | None
    reason: Reason = ""
    low: float | None = None
    high: float | None = None


@dataclass(frozen=True, slots=True)
class StepErrors:
    """The errors of a model."""

    model: str
    proposal: str
    """``shown`` if people saw the steps that their answers are compared with."""
    episodes: int
    answers: int
    steps: int
    """Proposed steps, once for each answer."""
    undecided: int
    """Steps that people who saw them sent unchanged without accepting them."""
    measures: tuple[StepMeasure, ...]


def errors_by_model(fates: Iterable[tuple[str, bool, StepFate]]) -> list[StepErrors]:
    """Return the errors of each model, first against people who saw its proposals.

    Parameters
    ----------
    fates
        The model of each step, whether people saw its proposal, and the step's fate.
    """
    groups: dict[tuple[str, bool], list[StepFate]] = {}
    for model, is_shown, fate in fates:
        groups.setdefault((model, is_shown), []).append(fate)
    return [
        _errors(model, "shown" if is_shown else "not shown", groups[model, is_shown])
        for model, is_shown in sorted(groups, key=lambda key: (key[0], not key[1]))
    ]


def _errors(model: str, proposal: str, fates: Sequence[StepFate]) -> StepErrors:
    episodes = list(dict.fromkeys(fate.episode for fate in fates))
    place = {episode: number for number, episode in enumerate(episodes)}
    steps = [(place[fate.episode], fate) for fate in fates if fate.state != ADDED]
    added = [(place[fate.episode], 1.0) for fate in fates if fate.state == ADDED]
    kept = [(n, step) for n, step in steps if step.state != REMOVED]
    moved = [(n, abs(step.moved_s)) for n, step in kept if step.moved_s is not None]

    def by_episode(rows: Iterable[tuple[int, float]]) -> Floats:
        total = np.zeros(len(episodes))
        for number, value in rows:
            total[number] += value
        return total

    whole = by_episode((n, 1) for n, _ in steps)

    def share(*states: str) -> Floats:
        return by_episode((n, step.state in states) for n, step in steps)

    ratios = {
        "accepted": (share(UNCHANGED), whole),
        "text changed": (share(TEXT, BOTH), whole),
        "boundary moved": (share(BOUNDARY, BOTH), whole),
        "removed": (share(REMOVED), whole),
        "added": (by_episode(added), whole),
        "text edit distance": (
            by_episode((n, step.text_distance) for n, step in kept),
            by_episode((n, 1) for n, _ in kept),
        ),
    }
    weights = np.random.default_rng(SEED).multinomial(
        len(episodes), np.full(len(episodes), 1 / len(episodes)), DRAWS
    )
    measures = [
        _bounded(name, partial(_ratio, some=some, of=of), weights)
        for name, (some, of) in ratios.items()
    ]
    numbers = np.array([n for n, _ in moved], dtype=np.int64)
    seconds = np.array([s for _, s in moved])
    for name, chosen in (
        ("boundary error, s", seconds >= 0),
        ("boundary error where moved, s", seconds > 0),
    ):
        median = partial(_medians, of=numbers[chosen], values=seconds[chosen])
        measures.append(_bounded(name, median, weights))
    undecided = sum(not step.decided for _, step in steps) if proposal == "shown" else 0
    answers = len({fate.answer for fate in fates})
    return StepErrors(
        model, proposal, len(episodes), answers, len(steps), undecided, tuple(measures)
    )


def _bounded(name: str, figure: Callable[[Weights], Floats], weights: Weights) -> StepMeasure:
    """Measure a figure and its interval over draws of episodes, shape (draws, episodes)."""
    [value] = figure(np.ones((1, weights.shape[1]), np.int64))
    if np.isnan(value):
        return StepMeasure(name, None, "no data")
    reason: Reason = "few clusters" if weights.shape[1] < FEWEST_EPISODES else ""
    found = StepMeasure(name, float(value), reason)
    drawn = figure(weights) if not reason else np.array([])
    drawn = drawn[~np.isnan(drawn)]
    if len(drawn) < 0.95 * DRAWS or drawn.min() == drawn.max():
        return found
    low, high = np.quantile(drawn, (0.025, 0.975))
    return replace(found, low=float(low), high=float(high))


def _ratio(weights: Weights, some: Floats, of: Floats) -> Floats:
    """Return the ratio of two sums over weighted episodes, for each row of weights."""
    whole: Floats = weights @ of
    result = np.full(len(weights), np.nan)
    np.divide(weights @ some, whole, out=result, where=whole > 0)
    return result


def _medians(weights: Weights, of: npt.NDArray[np.int64], values: Floats) -> Floats:
    """Return the median of the weighted episodes' values; `of` has the episode of each value."""
    order = np.argsort(values)
    result = np.full(len(weights), np.nan)
    for row, counts in enumerate(weights[:, of[order]]):
        total = np.cumsum(counts)
        if len(total) and total[-1]:
            middle = [(total[-1] - 1) // 2, total[-1] // 2]
            result[row] = values[order][np.searchsorted(total, middle, side="right")].mean()
    return result
