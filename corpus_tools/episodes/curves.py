"""Numbers of an episode over time, such as a robot's state, as curves beside its video."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from corpus_tools.tables.curve_file import LONGEST_NAME, MOST_CURVES, Curve, Values

CURVES = "curves"
"""The folder beside the tables with the curves of each episode."""
MOST_NUMBERS = 64
"""Largest number of numbers of a feature in a frame."""


@dataclass(frozen=True, slots=True, eq=False)
class EpisodeCurves:
    """The curves of an episode."""

    curves: Sequence[Curve]
    rate: float
    """Samples a second."""
    samples: int
    pieces: Iterator[Values]
    """Read as they are needed; errors are raised then. Shape (n, curves)."""


def drawable(features: Iterable[tuple[str, int]]) -> dict[str, int]:
    """Return the features with few enough numbers a frame, up to `MOST_CURVES` numbers in all."""
    chosen: dict[str, int] = {}
    for name, count in features:
        if 0 < count <= MOST_NUMBERS and sum(chosen.values()) + count <= MOST_CURVES:
            chosen[name] = count
    return chosen


def named_curves(feature: str, count: int, names: Sequence[str] = ()) -> list[Curve]:
    """Return the curves of a feature, with its names of numbers if these are as many."""
    names = names if len(names) == count else [str(n) for n in range(1, count + 1)]
    return [Curve(feature[:LONGEST_NAME], name[:LONGEST_NAME]) for name in names]
