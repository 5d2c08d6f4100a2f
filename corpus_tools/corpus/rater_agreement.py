"""Agreement of several people: Krippendorff's α and Fleiss' κ."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from functools import partial
from typing import Any, Literal, TypeAlias

import numpy as np

from corpus_tools.corpus.estimate import Estimate, undefined

Level: TypeAlias = Literal["nominal", "ordinal", "interval"]


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
