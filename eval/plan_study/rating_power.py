"""Expected precision and duration of a set of plans to rate, before any rating."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from corpus_tools.corpus.estimate import Estimate, Reason, undefined
from eval.plan_study.plan_validity import FIGURES, figures
from eval.plan_study.rating_sample import KINDS, RIGHT, WRONG, DistinctPlan, Sample
from eval.plan_study.study_pairs import ANSWERS
from eval.plan_study.study_plans import CONFIGURATIONS
from eval.statistics.estimates import FEWEST_CLUSTERS, FloatArray, percentiles
from eval.statistics.power import own_shares
from eval.statistics.ratings import codes

ASSUMED = {WRONG: 0.15, RIGHT: 0.85}
"""Share of the plans that most people call right, by the judge's verdict.

Of the AAAI-11 corpus's pairs it is .04 and .89 (`ct eval --judge-validity`), but plans are nearer
misses than videos of other scenarios.
"""
CORRELATION = 0.1
"""Correlation between plans of a scenario; .11 between the pairs of a video there that the judge
refuses."""
ANSWER_S = 10.0
"""Time to read the command and to answer, in seconds, without the video."""
STUDIES = 2000


@dataclass(frozen=True, slots=True)
class Planned:
    """A rating set as planned."""

    plans: Mapping[str, int]
    """Number of plans by the judge's verdict, each once."""
    without: int
    """Number of commands in a configuration without a plan."""
    stopped: int
    """Number of drawn plans that physics stopped; nobody rates them."""
    pairs: Mapping[str, int]
    """Number of rated plans, by the judge's verdict."""
    configurations: Mapping[str, Mapping[str, int]]
    """Number of rated plans by configuration and verdict; a plan of two counts in both."""
    scenarios: int
    raters: int
    seconds_each: float
    """Mean duration of a pair, in seconds."""
    minutes: float
    """Duration of all pairs for one person, in minutes."""
    half_widths: Mapping[str, float]
    """Expected half widths of the figures' 95 % intervals; NaN where there will be none."""
    unknown: Mapping[str, Reason]
    """Reasons for missing half widths, by figure."""

    @property
    def total(self) -> int:
        """Number of pairs."""
        return sum(self.pairs.values())


def planned(
    plans: Sequence[DistinctPlan],
    sample: Sample,
    seconds: Sequence[float],
    *,
    without: int,
    stopped: int,
    seed: int,
) -> Planned:
    """Plan a sample, with the numbers of commands without a plan and of plans physics stopped."""
    chosen = [p for p in plans if p.run in sample.chance]
    whole = float(sum(seconds)) + ANSWER_S * len(chosen)
    widths = half_widths(plans, sample, np.random.default_rng(seed))
    return Planned(
        _by_kind(plans),
        without,
        stopped,
        _by_kind(chosen),
        {c: _by_kind([p for p in chosen if c in p.configurations]) for c in CONFIGURATIONS},
        len({p.record.scenario for p in chosen}),
        ANSWERS,
        whole / max(len(chosen), 1),
        whole / 60,
        {name: width.value for name, width in widths.items()},
        {name: width.reason for name, width in widths.items() if width.reason},
    )


def half_widths(
    plans: Sequence[DistinctPlan],
    sample: Sample,
    rng: np.random.Generator,
    *,
    shares: Mapping[str, float] = ASSUMED,
    correlation: float = CORRELATION,
    studies: int = STUDIES,
) -> dict[str, Estimate]:
    """Half widths that the figures' 95 % intervals have in simulated studies, without intervals.

    As :func:`eval.statistics.power.simulated_half_width` does for a share. Each scenario's own
    shares are drawn from beta distributions with the given correlation, the majority of each
    pair from those. The half width is that of the middle of the studies' figures.

    `shares` are the part of the plans that most people call right, by the judge's verdict; the
    correlation is between plans of a scenario, of the same verdict.
    """
    chosen = [p for p in plans if p.run in sample.chance]
    if not chosen:
        return dict.fromkeys(FIGURES, undefined("no data"))
    said = np.array([KINDS.index(p.kind) for p in chosen])
    place = codes([p.record.scenario for p in chosen])
    weight = 1 / np.array([sample.chance[p.run] for p in chosen])
    share = np.array([shares[kind] for kind in KINDS])
    own = own_shares(share, correlation, (studies, int(place.max()) + 1, len(KINDS)), rng)
    people = rng.random((studies, len(chosen))) < own[:, place, said]
    of_kind = weight[:, None] * (said[:, None] == np.arange(len(KINDS)))
    yes = people @ of_kind
    there = [_by_kind(plans)[kind] for kind in KINDS]
    counts = np.stack([of_kind.sum(axis=0) - yes, yes, np.broadcast_to(there, yes.shape)], axis=-2)
    return {
        name: _half_width(drawn) for name, drawn in zip(FIGURES, figures(counts).T, strict=True)
    }


def _half_width(drawn: FloatArray) -> Estimate:
    defined = drawn[np.isfinite(drawn)]
    middle = float(np.median(defined)) if len(defined) else np.nan
    found = percentiles(middle, drawn, FEWEST_CLUSTERS)
    return found._replace(value=(found.high - found.low) / 2, low=np.nan, high=np.nan)


def _by_kind(plans: Sequence[DistinctPlan]) -> dict[str, int]:
    return {kind: sum(p.kind == kind for p in plans) for kind in KINDS}
