"""An estimate: a figure with its interval, or the reason why there is none."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Literal, NamedTuple, TypeAlias

Reason: TypeAlias = Literal[
    "",
    "no data",
    "empty class",
    "one cluster",
    "few clusters",
    "few items",
    "all alike",
    "separated",
    "singular",
    "no convergence",
    "no overlap",
    "few raters",
    "unequal numbers",
    "poor resamples",
    "unknown people",
]
REASONS: Mapping[Reason, str] = {
    "no data": "there is nothing to measure",
    "empty class": "the class or group that the figure is of has no members",
    "one cluster": "all is of one video, scenario or person, so others can't be spoken for",
    "few clusters": "there are fewer than 10 clusters, of which an interval would be too narrow",
    "few items": "there are fewer than 10 items with several answers, too few for a figure",
    "all alike": "all are the same, which is no evidence that others are",
    "separated": "the ratings are divided so completely that no finite odds fit them best",
    "singular": "what the model tells apart isn't apart in the data",
    "no convergence": "the model's fit doesn't converge",
    "no overlap": "nothing was judged by two people or more",
    "few raters": "fewer than three people judged, too few to see how each of them errs",
    "unequal numbers": "units have different numbers of ratings",
    "poor resamples": "over 5 % of the resamples have no such figure, or nearly all lie beside it",
    "unknown people": "it isn't recorded who judged or typed",
}
"""Reasons for a missing figure or interval, by the name that all formats print."""


class Estimate(NamedTuple):
    """A figure and the bounds of its interval.

    Parameters
    ----------
    value
        NaN where there is none.
    low, high
        The bounds, which hold the value; NaN where there is no interval.
    reason
        Why there is no value, or no interval. It is empty where both are there, and for a figure
        that is given without an interval.
    left_out
        In how many resamples the figure is undefined; the interval is that of the others.
    """

    value: float
    low: float = math.nan
    high: float = math.nan
    reason: Reason = ""
    left_out: int = 0

    @property
    def is_known(self) -> bool:
        """True if there is a value."""
        return not math.isnan(self.value)

    @property
    def has_interval(self) -> bool:
        """True if there are bounds."""
        return not math.isnan(self.low)


def undefined(reason: Reason) -> Estimate:
    """Make an estimate without a value."""
    return Estimate(math.nan, reason=reason)


def part(some: float, whole: float, missing: Reason = "empty class") -> Estimate:
    """Compute the share of a whole, without an interval; undefined if the whole is 0."""
    return Estimate(some / whole) if whole > 0 else undefined(missing)


def named(estimates: Mapping[str, Estimate]) -> dict[str, float | Reason]:
    """Figures without intervals as fields of a record: each has its reason beside it."""
    return {
        name: value
        for key, one in estimates.items()
        for name, value in ((key, one.value), (f"{key}_reason", one.reason))
    }


def explained(given: Iterable[Estimate | object]) -> list[str]:
    """Return a line with the meaning of each reason that estimates, or records' fields, name."""
    names = [one.reason if isinstance(one, Estimate) else one for one in given]
    return [f"{name}: {meaning}" for name, meaning in REASONS.items() if name in names]
