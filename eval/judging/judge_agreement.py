"""Agreement of a judge with people on pairs of commands and videos: kappa, precision, recall."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from corpus_tools.corpus.estimate import Estimate, Reason, undefined
from eval.statistics.estimates import BoolArray, FloatArray, IntArray, percentiles, ratio
from g3.short_repr import short_repr

Resampled = Callable[[FloatArray], FloatArray]
"""A function from counts by video to sums over resampled videos."""


@short_repr
@dataclass(frozen=True, slots=True)
class Agreement:
    """A verdict against the majority of people."""

    counts: dict[str, int]
    """Pairs by the answers of people and of the judge."""
    kappa: Estimate
    """Cohen's κ; undefined where one side answers all pairs alike, for κ is then 0 regardless of
    the other side."""
    precision: Estimate
    """Share of the pairs accepted by the judge that people accept."""
    recall: Estimate
    """Share of the pairs accepted by people that the judge accepts."""
    accuracy: Estimate
    """Share of pairs with the same answer from both."""

    @property
    def n(self) -> int:
        """Number of pairs."""
        return sum(self.counts.values())


def agreement(
    people: Sequence[bool], judge: Sequence[bool], video: IntArray, resampled: Resampled
) -> Agreement:
    """Compare a judge's answers with people's, with whole videos resampled.

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
    """Count pairs by the answers of people and of the judge."""
    said = list(zip(people, judge, strict=True))
    words = {True: "yes", False: "no"}
    return {
        f"people_{words[p]}_judge_{words[j]}": said.count((p, j))
        for p in (True, False)
        for j in (True, False)
    }


def cohens_kappa(table: FloatArray) -> FloatArray:
    """Agreement of two raters beyond chance: J. Cohen (Educ. Psychol. Meas. 20, 1960).

    The table counts items by the answers of both raters, shape (..., k, k). The result has shape
    (...); NaN where both give one and the same answer to all.
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
    """Count pairs by video, people's answer and the judge's, shape (videos, 2, 2)."""
    tables = np.zeros((len(np.unique(video)), 2, 2))
    np.add.at(tables, (video, people.astype(int), said.astype(int)), 1.0)
    return tables
