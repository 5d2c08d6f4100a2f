"""How much several people agree: Krippendorff's α and Fleiss' κ."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Iterable, Sequence
from typing import Any, Literal, TypeAlias

import numpy as np

Level: TypeAlias = Literal["nominal", "ordinal", "interval"]


def krippendorff_alpha(units: Iterable[Sequence[Any]], level: Level = "nominal") -> float | None:
    """Krippendorff's α, for any number of ratings of each unit.

    K. Krippendorff, "Computing Krippendorff's Alpha-Reliability", 2011, section E: one minus
    the ratio of the disagreement within units to that among all ratings.

    Parameters
    ----------
    units
        The ratings of each unit. Units with fewer than two say nothing and are left out.
        Ratings must be numbers unless the level is nominal.
    level
        What differences between ratings mean.

    Returns
    -------
    float or None
        1 for perfect agreement, 0 for chance. None without variation, where it is undefined.
    """
    paired = [list(unit) for unit in units if len(unit) > 1]
    ratings = [rating for unit in paired for rating in unit]
    totals = Counter(ratings)
    if len(totals) < 2:
        return None
    if level == "nominal":
        expected = float(_unlike(ratings))
        observed = sum(_unlike(unit) / (len(unit) - 1) for unit in paired)
    else:
        scale = _ranks(totals) if level == "ordinal" else {value: value for value in totals}
        mean = np.mean([scale[rating] for rating in ratings])
        numbers = {value: float(scale[value] - mean) for value in totals}
        expected = _squared([numbers[rating] for rating in ratings])
        observed = sum(
            _squared([numbers[rating] for rating in unit]) / (len(unit) - 1) for unit in paired
        )
    return 1.0 - (len(ratings) - 1) * observed / expected


def fleiss_kappa(units: Iterable[Sequence[Hashable]]) -> float | None:
    """Fleiss' κ (Psychological Bulletin 76, 1971), for units with equally many ratings.

    Parameters
    ----------
    units
        The ratings of each unit, at least two.

    Returns
    -------
    float or None
        None if units have different numbers of ratings, or there is no variation.
    """
    rated = [list(unit) for unit in units]
    if not rated or len({len(unit) for unit in rated}) > 1 or len(rated[0]) < 2:
        return None
    totals = Counter(rating for unit in rated for rating in unit)
    if len(totals) < 2:
        return None
    n = len(rated[0])
    observed = 1.0 - float(np.mean([_unlike(unit) for unit in rated])) / (n * (n - 1))
    chance = sum(count**2 for count in totals.values()) / totals.total() ** 2
    return (observed - chance) / (1.0 - chance)


def _unlike(ratings: Sequence[Hashable]) -> int:
    """How many ordered pairs of ratings differ."""
    return int(len(ratings) ** 2 - sum(count**2 for count in Counter(ratings).values()))


def _squared(numbers: Sequence[float]) -> float:
    """The sum of squared differences over ordered pairs."""
    values = np.array(numbers)
    return float(2 * (len(values) * (values**2).sum() - values.sum() ** 2))


def _ranks(totals: Counter[Any]) -> dict[Any, float]:
    """The middle of each value's ranks, so that values differ by the ratings in between."""
    values = sorted(totals)
    counts = np.array([totals[value] for value in values], dtype=np.float64)
    return dict(zip(values, np.cumsum(counts) - counts / 2, strict=True))
