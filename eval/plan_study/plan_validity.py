"""Agreement of the automatic judge with people on plans of which only a sample was rated."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from corpus_tools.corpus.estimate import Estimate, Reason
from eval.judging.judge_agreement import cohens_kappa, confusion
from eval.plan_study.rating_sample import RIGHT, DistinctPlan, Sample, kind_of
from eval.plan_study.study_plans import CONFIGURATIONS
from eval.statistics.estimates import FloatArray, percentiles, ratio
from eval.statistics.ratings import codes
from eval.statistics.resampling import resampled_sums

FIGURES = ("kappa", "precision", "recall", "precision_of_wrong", "same", "people_right")
"""Order of the last axis of :func:`figures`."""
ALL = "all"


@dataclass(frozen=True, slots=True)
class PlanAgreement:
    """The judge against the majority of people on the plans of a configuration, or on all."""

    configuration: str
    """Its name, or ``all``, where a plan of several configurations counts once."""
    plans: int
    """Number of plans, rated or not."""
    rated: int
    counts: Mapping[str, int]
    """Rated plans by the answers of people and of the judge, as ``people_yes_judge_no``."""
    figures: Mapping[str, Estimate]
    """Figures of all plans, by :data:`FIGURES`, with whole scenarios resampled. Precision: share of
    the plans accepted by the judge that people accept. Recall: share of the plans accepted by
    people that the judge accepts."""


def figures(counts: FloatArray) -> FloatArray:
    """Return figures of all plans from weighted counts of rated ones.

    The plans that the judge calls right, and those that it calls wrong, count as many as there
    are. The rated ones only show how people divide them.

    `counts` have shape (..., 3, 2). The last axis is the judge's verdict, wrong or right; the rows
    are the weights of plans that people call wrong, of those that they call right, and the number
    of plans. Figures have shape (..., 6), in the order of :data:`FIGURES`; NaN where the rated
    plans don't determine them.
    """
    rated, there = counts[..., :2, :], counts[..., 2, :]
    shares = ratio(rated, rated.sum(axis=-2, keepdims=True))
    table = np.where(there[..., None, :] > 0, shares * there[..., None, :], 0.0)
    (no_no, no_yes), (yes_no, yes_yes) = (
        (table[..., row, 0], table[..., row, 1]) for row in (0, 1)
    )
    total = there.sum(axis=-1)
    return np.stack(
        [
            cohens_kappa(table),
            ratio(yes_yes, no_yes + yes_yes),
            ratio(yes_yes, yes_no + yes_yes),
            ratio(no_no, no_no + yes_no),
            ratio(no_no + yes_yes, total),
            ratio(yes_no + yes_yes, total),
        ],
        axis=-1,
    )


def agreements(
    plans: Sequence[DistinctPlan],
    sample: Sample,
    people: Mapping[str, bool],
    verdict: str,
    *,
    seed: int,
    draws: int,
) -> list[PlanAgreement]:
    """Return a row for all plans, and one for each configuration.

    `plans` are all, rated or not; `people` has the majority verdict on each rated plan, by its run;
    `verdict` is the judge's verdict to compare.
    """
    rows = []
    for name in (ALL, *CONFIGURATIONS):
        own = [p for p in plans if name in (ALL, *p.configurations)]
        if not own:
            continue
        scenario = codes([p.record.scenario for p in own])
        counts = np.zeros((scenario.max() + 1, 3, 2))
        said = [int(kind_of(p, verdict) == RIGHT) for p in own]
        rated = []
        for plan, place, judge in zip(own, scenario, said, strict=True):
            counts[place, 2, judge] += 1
            if plan.run in people:
                yes = people[plan.run]
                counts[place, int(yes), judge] += 1 / sample.chance[plan.run]
                rated.append((yes, bool(judge)))
        raw = confusion([yes for yes, _ in rated], [judge for _, judge in rated])
        values = figures(counts.sum(axis=0))
        # The same seed for each row, so that all are of the same scenarios.
        rng = np.random.default_rng(seed)
        drawn = figures(resampled_sums(counts, rng=rng, draws=draws))
        bounded = {
            figure: percentiles(float(values[i]), drawn[:, i], len(counts), _missing(figure, raw))
            for i, figure in enumerate(FIGURES)
        }
        rows.append(PlanAgreement(name, len(own), len(rated), raw, bounded))
    return rows


def _missing(figure: str, rated: Mapping[str, int]) -> Reason:
    """Return the reason for an undefined figure."""
    if not sum(rated.values()):
        return "no data"
    return "all alike" if figure == "kappa" else "empty class"


def tells_of_all(plans: Sequence[DistinctPlan], sample: Sample) -> bool:
    """Check that every kind was drawn, which verdicts after the first need."""
    return {p.kind for p in plans} == {p.kind for p in plans if p.run in sample.chance}
