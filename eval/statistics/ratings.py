"""Judgments as arrays, and joint answers of raters."""

from __future__ import annotations

from collections import Counter
from collections.abc import Container, Hashable, Iterable, Sequence
from dataclasses import dataclass, fields

import numpy as np

from corpus_tools.simulation.simulated_raters import STUDY as SIMULATED
from eval.statistics.estimates import BoolArray, IntArray
from g3.annotation import RATINGS, Judgment
from g3.errors import FormatError
from g3.short_repr import short_repr

AGREES = 4
"""Lowest of the five points that agrees that the video shows the command."""


def judged_by(study: str) -> str:
    """Return the kind of raters of a study."""
    return "simulated raters" if study == SIMULATED else "people"


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class Ratings:
    """Judgments of commands with videos, each array of shape (n,)."""

    rating: IntArray
    """From 1, strongly disagree, to 5, strongly agree."""
    original: BoolArray
    """True where the command was shown with the video that it was typed for."""
    pair: IntArray
    """Index of the command with the video that it was shown with."""
    command: IntArray
    """Index of the command."""
    video: IntArray
    """Index of the video that the command was typed for."""
    shown: IntArray
    """Index of the video that the command was shown with."""
    rater: IntArray
    """Index of the person."""

    def __len__(self) -> int:
        return len(self.rating)

    @property
    def agrees(self) -> BoolArray:
        """True where somebody agrees or agrees strongly, shape (n,)."""
        result: BoolArray = self.rating >= AGREES
        return result

    def only(self, chosen: BoolArray) -> Ratings:
        """Select judgments, with the same indices."""
        return Ratings(*(getattr(self, field.name)[chosen] for field in fields(self)))

    def units(self) -> list[list[int]]:
        """Return the ratings of each pair."""
        order = np.argsort(self.pair, kind="stable")
        starts = np.flatnonzero(np.diff(self.pair[order], prepend=-1))
        return [part.tolist() for part in np.split(self.rating[order], starts[1:])]


def ratings_of(judgments: Iterable[Judgment]) -> Ratings:
    """Convert judgments to arrays, in their order."""
    rows = list(judgments)
    return Ratings(
        np.array([RATINGS.index(j.rating) + 1 for j in rows], dtype=np.int64),
        np.array([j.command_video == j.shown_video for j in rows], dtype=np.bool_),
        codes([shown_pair(j) for j in rows]),
        codes([(j.command, j.command_video) for j in rows]),
        codes([j.command_video for j in rows]),
        codes([j.shown_video for j in rows]),
        codes([j.subject for j in rows]),
    )


def agrees(judgment: Judgment) -> bool:
    """Check that somebody agrees, or agrees strongly."""
    return RATINGS.index(judgment.rating) + 1 >= AGREES


def shown_pair(judgment: Judgment) -> tuple[str, str, str]:
    """Return the command, the video that it was typed for, and the one shown with it."""
    return judgment.command, judgment.command_video, judgment.shown_video


def of_study(judgments: Sequence[Judgment], study: str = "") -> list[Judgment]:
    """Return the judgments of a study; of the largest one if it isn't named.

    Several studies may be of the same pairs, such as a trial run and the real one.
    """
    studies = Counter(j.study for j in judgments)
    chosen = study or max(studies, key=lambda name: (studies[name], name), default="")
    if study and study not in studies:
        raise FormatError.unknown("study", study, sorted(studies))
    return [j for j in judgments if j.study == chosen]


def codes(values: Sequence[Hashable]) -> IntArray:
    """Assign numbers to the different values, from 0 in the order of first appearance."""
    numbers: dict[Hashable, int] = {}
    return np.array([numbers.setdefault(value, len(numbers)) for value in values], dtype=np.int64)


def check_judgments(judgments: Iterable[Judgment], videos: Container[str]) -> None:
    """Refuse judgments of commands that were typed for no known video."""
    for row, j in enumerate(judgments, start=1):
        if j.command_video not in videos:
            raise FormatError(
                f"no command was typed for the video {j.command_video!r}",
                where=f"judgments.jsonl: line {row}",
                fix="correct command_video, or add the command",
            )


def repeated(judgments: Iterable[Judgment]) -> int:
    """Count judgments by somebody who had judged the same pair before in the study."""
    rows = [(j.study, j.subject, *shown_pair(j)) for j in judgments if j.subject]
    return len(rows) - len(set(rows))


def majorities(agrees: BoolArray, pair: IntArray) -> BoolArray:
    """Return for each pair whether more than half of its judgments agree, in order."""
    _, index = np.unique(pair, return_inverse=True)
    result: BoolArray = 2 * np.bincount(index, weights=agrees) > np.bincount(index)
    return result
