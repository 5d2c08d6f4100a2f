"""How far a judge agrees with people on pairs of commands and videos: kappa, precision, recall."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from corpus_tools.corpus.estimate import Estimate, Reason, undefined
from eval.statistics.estimates import BoolArray, FloatArray, IntArray, percentiles, ratio
from g3.short_repr import short_repr

Resampled = Callable[[FloatArray], FloatArray]
"""Makes sums over resampled videos from counts by video."""


@short_repr
@dataclass(frozen=True, slots=True)
class Agreement:
    """A verdict against the majority of people."""

    counts: dict[str, int]
    """Pairs by what people and the judge say."""
    kappa: Estimate
    """Cohen's κ; undefined where one side says the same of everything, for it is 0 then whatever
    the other says."""
    precision: Estimate
    """The part of what the judge calls right that people accept."""
    recall: Estimate
    """The part of what people accept that the judge calls right."""
    accuracy: Estimate
    """The part of which both say the same."""

    @property
    def n(self) -> int:
        """How many pairs there are."""
        return sum(self.counts.values())


def agreement(
    people: Sequence[bool], judge: Sequence[bool], video: IntArray, resampled: Resampled
) -> Agreement:
    """Compare what a judge says with what people say, with whole videos resampled.

    `video` is the code of each pair's video, shape (n,).
    """
    counts = confusion(people, judge)
    tables = _tables(np.array(people, dtype=np.bool_), np.array(judge, dtype=np.bool_), video)
    drawn = resampled(tables) if len(tables) else np.zeros((1, 2, 2))
    whole = tables.sum(axis=0)

    def bounded(figure: Callable[[FloatArray], FloatArray], missing: Reason) -> Estimate:
        missing = missing if len(tables) else "no data"
        return percentiles(float(figure(whole)), figure(drawn), len(tables), missing)

    vary = whole.any(axis=0).all() and whole.any(axis=1).all()
    kappa = bounded(cohens_kappa, "all alike")
    return Agreement(
        counts,
        kappa if vary or not len(tables) else undefined("all alike"),
        bounded(_precision, "empty class"),
        bounded(_recall, "empty class"),
        bounded(_accuracy, "no data"),
    )


def confusion(people: Sequence[bool], judge: Sequence[bool]) -> dict[str, int]:
    """How many pairs there are of each thing that people and the judge say."""
    said = list(zip(people, judge, strict=True))
    words = {True: "yes", False: "no"}
    return {
        f"people_{words[p]}_judge_{words[j]}": said.count((p, j))
        for p in (True, False)
        for j in (True, False)
    }


def cohens_kappa(table: FloatArray) -> FloatArray:
    """Agreement of two raters beyond chance: J. Cohen (Educ. Psychol. Meas. 20, 1960).

    The table has counts by what each of them says, shape (..., k, k), and the result shape (...);
    NaN where both say the same of everything.
    """
    total = table.sum(axis=(-2, -1))
    same = ratio(np.trace(table, axis1=-2, axis2=-1), total)
    by_chance = (table.sum(axis=-1) * table.sum(axis=-2)).sum(axis=-1)
    chance = ratio(by_chance, total**2)
    return ratio(same - chance, 1 - chance)


def _precision(table: FloatArray) -> FloatArray:
    return ratio(table[..., 1, 1], table[..., :, 1].sum(axis=-1))


def _recall(table: FloatArray) -> FloatArray:
    return ratio(table[..., 1, 1], table[..., 1, :].sum(axis=-1))


def _accuracy(table: FloatArray) -> FloatArray:
    return ratio(np.trace(table, axis1=-2, axis2=-1), table.sum(axis=(-2, -1)))


def _tables(people: BoolArray, said: BoolArray, video: IntArray) -> FloatArray:
    """Counts by video, of what people say and of what the judge says, shape (videos, 2, 2)."""
    tables = np.zeros((len(np.unique(video)), 2, 2))
    np.add.at(tables, (video, people.astype(int), said.astype(int)), 1.0)
    return tables
