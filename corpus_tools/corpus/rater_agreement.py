"""Agreement of several people, Krippendorff's α and Fleiss' κ, and how each of them errs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from corpus_tools.corpus.estimate import Estimate, Reason, undefined
from g3.groundings import FloatArray
from g3.short_repr import short_repr

Level: TypeAlias = Literal["nominal", "ordinal", "interval"]
IntArray: TypeAlias = npt.NDArray[np.int64]
TOLERANCE = 1e-8
MOST_STEPS = 2000
FEWEST_RATERS = 3
"""Smallest number of raters whose answers can show their errors."""
TINY = float(np.finfo(np.float64).tiny)


def krippendorff_alpha(units: Iterable[Sequence[Any]], level: Level = "nominal") -> Estimate:
    """Krippendorff's α, for any number of ratings of each unit.

    K. Krippendorff, "Computing Krippendorff's Alpha-Reliability", 2011, section E: one minus
    the ratio of the disagreement within units to that among all ratings.

    Parameters
    ----------
    units
        The ratings of each unit. Units with fewer than two say nothing and are left out.
        Ratings must be numbers unless the level is nominal.
    level
        Level of measurement, which defines the difference between ratings.

    Returns
    -------
    Estimate
        1 for perfect agreement, 0 for chance, without an interval. It is undefined where no unit
        has two ratings, and where all ratings are the same.
    """
    paired = Counter(tuple(unit) for unit in units if len(unit) > 1)
    totals = _totals(paired)
    if len(totals) < 2:
        return undefined("all alike" if totals else "no overlap")
    differences: Callable[[Counter[Any]], float] = _unlike
    if level != "nominal":
        scale = _ranks(totals) if level == "ordinal" else {value: value for value in totals}
        mean = sum(scale[value] * count for value, count in totals.items()) / totals.total()
        differences = partial(_squared, {value: float(scale[value] - mean) for value in totals})
    observed = sum(
        count * differences(Counter(unit)) / (len(unit) - 1) for unit, count in paired.items()
    )
    return Estimate(1.0 - (totals.total() - 1) * observed / differences(totals))


def fleiss_kappa(units: Iterable[Sequence[Hashable]]) -> Estimate:
    """Fleiss' κ (Psychological Bulletin 76, 1971), for units with equally many ratings.

    Parameters
    ----------
    units
        The ratings of each unit, at least two.

    Returns
    -------
    Estimate
        Without an interval. It is undefined where units have different numbers of ratings or fewer
        than two, and where all ratings are the same.
    """
    rated = Counter(tuple(unit) for unit in units)
    sizes = {len(unit) for unit in rated}
    if max(sizes, default=0) < 2:
        return undefined("no overlap")
    if len(sizes) > 1:
        return undefined("unequal numbers")
    n = sizes.pop()
    totals = _totals(rated)
    if len(totals) < 2:
        return undefined("all alike")
    unlike = sum(count * _unlike(Counter(unit)) for unit, count in rated.items())
    observed = 1.0 - unlike / rated.total() / (n * (n - 1))
    chance = sum(count**2 for count in totals.values()) / totals.total() ** 2
    return Estimate((observed - chance) / (1.0 - chance))


def _totals(units: Counter[tuple[Any, ...]]) -> Counter[Any]:
    """Count each rating. Equal units are counted, not repeated."""
    totals: Counter[Any] = Counter()
    for unit, count in units.items():
        for rating in unit:
            totals[rating] += count
    return totals


def _unlike(ratings: Counter[Any]) -> float:
    """Count the ordered pairs of ratings that differ."""
    return float(ratings.total() ** 2 - sum(count**2 for count in ratings.values()))


def _squared(numbers: Mapping[Any, float], ratings: Counter[Any]) -> float:
    """Sum the squared differences over ordered pairs of ratings, each of which is a number."""
    # Units are small, so that NumPy would take several times as long.
    first = second = 0.0
    for rating, count in ratings.items():
        number = numbers[rating]
        first += count * number
        second += count * number * number
    return 2.0 * (ratings.total() * second - first * first)


def _ranks(totals: Counter[Any]) -> dict[Any, float]:
    """Return the middle of each value's ranks, so that values differ by the ratings in between."""
    values = sorted(totals)
    counts = np.array([totals[value] for value in values], dtype=np.float64)
    return dict(zip(values, np.cumsum(counts) - counts / 2, strict=True))


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class DawidSkene:
    """A model of raters' individual errors."""

    prevalence: FloatArray
    """Frequency of each true class, shape (classes,)."""
    answers: FloatArray
    """Probability of each rater's answers for each true class, shape (raters, true classes, given
    classes); NaN where nothing is known."""
    posterior: FloatArray
    """Probability of each class for each item, shape (items, classes)."""
    log_likelihood: FloatArray
    """Log-likelihood after each step, which never decreases."""
    reason: Reason = ""
    """Reason for which the model can't show raters' errors; empty if it can."""

    def accuracy(self, rater: int) -> float:
        """Return the probability that a rater's answer is the true class; NaN if unknown."""
        right = np.diagonal(self.answers[rater])
        known = ~np.isnan(right)
        weights = self.prevalence[known]
        return float(right[known] @ weights / weights.sum()) if weights.sum() > 0 else float("nan")

    def share(self, of: IntArray, is_class: int) -> Estimate:
        """Return the share of some items that are probably of a class, without an interval."""
        if self.reason or len(of) == 0:
            return undefined(self.reason or "no data")
        return Estimate(float((self.posterior[of, is_class] > 0.5).mean()))


def dawid_skene(
    item: IntArray, rater: IntArray, given: IntArray, classes: int | None = None
) -> DawidSkene:
    """Estimate true classes and raters' errors together by expectation maximisation.

    A. P. Dawid and A. M. Skene, Applied Statistics 28 (1979). It begins with each item's shares
    of answers, as they do.

    Of each answer there are an item, a rater and the class that was given: numbers from 0 without
    gaps, shape (n,). The number of classes defaults to the greatest given class plus one.

    With fewer than three raters, or where nothing was judged twice, errors can't be separated from
    true classes: the posteriors are the shares of answers then, and `reason` has the reason.
    """
    items, raters = int(item.max(initial=-1)) + 1, int(rater.max(initial=-1)) + 1
    k = classes or int(given.max(initial=-1)) + 1
    if items == 0:
        none = np.zeros((0, k))
        return DawidSkene(
            np.full(k, np.nan), np.zeros((0, k, k)), none, np.zeros(0), reason="no data"
        )
    # An answer adds the column of its rater and class to the sums of its item.
    column = rater * k + given
    counts = np.zeros((items, raters * k))
    np.add.at(counts, (item, column), 1.0)
    posterior = counts.reshape(items, raters, k).sum(axis=1)
    posterior /= posterior.sum(axis=1, keepdims=True)
    trace: list[float] = []
    reason: Reason
    while True:
        prevalence = posterior.mean(axis=0)
        answers = (posterior.T @ counts).reshape(k, raters, k)
        totals = answers.sum(axis=2, keepdims=True)
        answers = np.divide(answers, totals, out=np.full_like(answers, np.nan), where=totals > 0)
        # A rater who never gave an answer may give it all the same, though hardly ever.
        logs = np.log(np.maximum(np.nan_to_num(answers), TINY)).reshape(k, raters * k)
        joint = counts @ logs.T + np.log(np.maximum(prevalence, TINY))
        top = joint.max(axis=1, keepdims=True)
        total = top + np.log(np.exp(joint - top).sum(axis=1, keepdims=True))
        posterior = np.exp(joint - total)
        trace.append(float(total.sum()))
        if len(trace) > 1 and abs(trace[-1] - trace[-2]) <= TOLERANCE * abs(trace[-1]):
            reason = _unidentified(item, rater)
            break
        if len(trace) == MOST_STEPS:
            reason = "no convergence"
            break
    return DawidSkene(prevalence, answers.transpose(1, 0, 2), posterior, np.array(trace), reason)


def _unidentified(item: IntArray, rater: IntArray) -> Reason:
    pairs = np.unique(np.column_stack([item, rater]), axis=0)
    if np.bincount(pairs[:, 0]).max() < 2:
        return "no overlap"
    return "few raters" if len(np.unique(rater)) < FEWEST_RATERS else ""
