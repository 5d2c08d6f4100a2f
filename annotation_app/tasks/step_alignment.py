"""Alignment of two cuts of an episode into steps, by time and by text.

A cut is a list of steps in order; each lasts until the next one begins, the last to the episode's
end. Steps are aligned in order, each with at most one of the other cut's.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from rapidfuzz.distance import Levenshtein

LEAST_LIKENESS = 0.4
"""Least mean of overlap and text likeness from which two steps are taken for the same one: those
of other texts must be at nearly the same time, those at other times have nearly the same text."""
LEAST_OVERLAP = 0.5
"""Least overlap of two steps whose texts are compared as descriptions of the same moment."""


@dataclass(frozen=True, slots=True)
class Step:
    """A step with its times from the episode's first frame, in seconds."""

    start_s: float
    end_s: float
    text: str


class Pair(NamedTuple):
    """Two aligned steps by their numbers, and their likeness from 0 to 1."""

    one: int
    other: int
    likeness: float


def steps_from(
    starts: Sequence[tuple[float, str]], duration_s: float, fps: float | None = None
) -> list[Step]:
    """Return the steps that begin at some times; on whole frames if the rate is given."""
    times = [round(start * fps) / fps if fps else start for start, _ in starts]
    ends = [*times[1:], max(duration_s, times[-1])] if times else []
    return [Step(a, b, text) for a, b, (_, text) in zip(times, ends, starts, strict=True)]


def overlap(one: Step, other: Step) -> float:
    """Return the intersection of two steps over their union, in time; 1 for equal ones."""
    if (one.start_s, one.end_s) == (other.start_s, other.end_s):
        return 1.0
    both = min(one.end_s, other.end_s) - max(one.start_s, other.start_s)
    either = max(one.end_s, other.end_s) - min(one.start_s, other.start_s)
    return max(both, 0.0) / either if either > 0 else 0.0


def text_distance(one: str, other: str) -> float:
    """Return the characters to change (Levenshtein) over those of the longer text, 0 to 1."""
    return float(Levenshtein.normalized_distance(one, other))


def likeness(one: Step, other: Step) -> float:
    """Return the mean of overlap and text likeness; 0 for steps that are far apart."""
    apart_s = max(one.start_s, other.start_s) - min(one.end_s, other.end_s)
    if apart_s > max(one.end_s - one.start_s, other.end_s - other.start_s):
        return 0.0
    return (overlap(one, other) + 1.0 - text_distance(one.text, other.text)) / 2


def aligned(
    one: Sequence[Step],
    other: Sequence[Step],
    score: Callable[[Step, Step], float] = likeness,
    least: float = LEAST_LIKENESS,
) -> list[Pair]:
    """Return the pairs of steps, in order, whose scores have the largest sum.

    Parameters
    ----------
    one, other
        The two cuts.
    score
        The likeness of two steps, from 0 to 1.
    least
        Pairs of a smaller score are none.
    """
    scores = np.zeros((len(one), len(other)))
    for i, mine in enumerate(one):
        for j, theirs in enumerate(other):
            found = score(mine, theirs)
            scores[i, j] = found if found >= least else 0.0
    best = np.zeros((len(one) + 1, len(other) + 1))
    for i in range(len(one)):
        for j in range(len(other)):
            best[i + 1, j + 1] = max(best[i, j + 1], best[i + 1, j], best[i, j] + scores[i, j])
    pairs: list[Pair] = []
    i, j = len(one), len(other)
    while i and j:
        if best[i, j] == best[i - 1, j]:
            i -= 1
        elif best[i, j] == best[i, j - 1]:
            j -= 1
        else:
            i, j = i - 1, j - 1
            pairs.append(Pair(i, j, float(scores[i, j])))
    return pairs[::-1]


def cut_likeness(one: Sequence[Step], other: Sequence[Step]) -> float:
    """Return the likeness of two cuts: 1 if they are equal, 0 if no step has a like one."""
    total = len(one) + len(other)
    return 2 * sum(pair.likeness for pair in aligned(one, other)) / total if total else 1.0


def time_agreement(one: Sequence[Step], other: Sequence[Step]) -> float:
    """Return the share of the episode in which both cuts are in the same step, by time alone."""
    whole = max(step.end_s for step in (*one, *other)) if one and other else 0.0
    if whole <= 0:
        return 0.0
    common = 0.0
    for pair in aligned(one, other, overlap, 0.0):
        mine, theirs = one[pair.one], other[pair.other]
        common += min(mine.end_s, theirs.end_s) - max(mine.start_s, theirs.start_s)
    return common / whole


def text_agreement(one: Sequence[Step], other: Sequence[Step]) -> list[float]:
    """Return the likeness of the texts of steps that overlap by half or more, from 0 to 1.

    Capitals don't matter.
    """
    return [
        1.0 - text_distance(one[pair.one].text.casefold(), other[pair.other].text.casefold())
        for pair in aligned(one, other, overlap, LEAST_OVERLAP)
    ]
