"""Counts for Table 2: how often people agree that a video shows a command."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.util import find_spec
from typing import Literal

import numpy as np

from corpus_tools.corpus.estimate import Estimate
from corpus_tools.corpus.rater_agreement import DawidSkene, dawid_skene, krippendorff_alpha
from corpus_tools.runtime.parallel import Executor
from eval.statistics.estimates import BoolArray
from eval.statistics.intervals import bootstrap, clopper_pearson, crossed, gee, two_way, wilson
from eval.statistics.ordinal import CumulativeLink, cliffs_delta, cumulative_link, no_link
from eval.statistics.ratings import (
    Ratings,
    majorities,
    of_study,
    ratings_of,
    repeated,
)
from g3.annotation import Judgment
from g3.errors import CorpusError, FormatError
from g3.short_repr import short_repr

Configuration = Literal["original", "random"]


@short_repr
@dataclass(frozen=True, slots=True)
class Row:
    """A configuration of Table 2.

    Parameters
    ----------
    share
        Judgments that agree or agree strongly, with whole videos resampled.
    two_way
        The share for other videos and other raters.
    wilson, exact
        The share with judgments assumed independent; the interval is too narrow.
    n, pairs, videos, raters
        Numbers of judgments, pairs, videos and raters; `videos` are those that the commands were
        typed for, which are the clusters.
    shown
        Number of videos that the commands were shown with.
    majority
        Share of the pairs on which more than half of the judgments agree.
    weighed
        Share of the pairs that show the command, by Dawid and Skene's model of raters' individual
        errors; without an interval.
    model
        The share by generalised estimating equations, with videos as clusters; None unless
        requested.
    crossed
        The share by a mixed model with crossed effects of videos and raters; None unless requested.
    """

    configuration: Configuration
    share: Estimate
    two_way: Estimate
    wilson: Estimate
    exact: Estimate
    n: int
    pairs: int
    videos: int
    raters: int
    majority: float
    weighed: Estimate
    shown: int
    model: Estimate | None = None
    crossed: Estimate | None = None


@short_repr
@dataclass(frozen=True, slots=True)
class Results:
    """Table 2, with other results of the judgments.

    Parameters
    ----------
    left_out
        For each other study, its number of judgments and the share that agrees, by configuration.
    repeats
        Number of judgments by somebody who had judged the same pair before; they count.
    alpha
        Krippendorff's α of the five points, over all pairs; without an interval.
    delta
        Cliff's δ between the ratings of the two configurations; without an interval.
    link
        The cumulative-link model of the ratings; None unless requested.
    """

    rows: tuple[Row, ...]
    study: str
    left_out: Mapping[str, Mapping[str, float]]
    repeats: int
    alpha: Estimate
    delta: Estimate
    link: CumulativeLink | None = None


def table_2(
    judgments: Sequence[Judgment],
    *,
    seed: int,
    draws: int,
    study: str = "",
    models: bool = False,
    executor: Executor | None = None,
) -> Results:
    """Make Table 2 of human judgments.

    Parameters
    ----------
    study
        Name of the study to count; the study with most judgments if empty, for another one may be
        of the same pairs.
    draws, executor
        Number of resamples for the intervals, and their executor
        (:func:`eval.statistics.estimates.resampled_sums`).
    models
        True to fit the models too, which takes seconds and needs statsmodels.
    """
    if models and find_spec("statsmodels") is None:
        raise CorpusError("--models needs statsmodels", fix="pip install 'corpus-tools-g3[study]'")
    if not judgments:
        raise FormatError(
            "the corpus has no judgments",
            fix="give one with ratings of videos, or warehouse-simulated-ratings to try it",
        )
    mine = of_study(judgments, study)
    others = Counter(j.study for j in judgments if j.study != mine[0].study)
    ratings = ratings_of(mine)
    rng = np.random.default_rng(seed)
    together = dawid_skene(ratings.pair, ratings.rater, ratings.agrees.astype(np.int64), 2)
    if not all(j.subject for j in mine):
        together = replace(together, reason="unknown people")
    rows = tuple(
        _row(
            name, ratings.only(of), together, rng=rng, draws=draws, models=models, executor=executor
        )
        for name, of in _configurations(ratings)
        if of.any()
    )
    left_out = {
        other: {"judgments": n, **_shares([j for j in judgments if j.study == other])}
        for other, n in sorted(others.items())
    }
    shown = [ratings.rating[of] for _, of in _configurations(ratings)]
    link = None
    if models:
        predictor = ratings.original[:, None].astype(np.float64)
        has_both = all(len(result) for result in shown)
        link = (
            cumulative_link(ratings.rating, predictor, ratings.video)
            if has_both
            else no_link("empty class")
        )
    return Results(
        rows,
        mine[0].study,
        left_out,
        repeated(mine),
        krippendorff_alpha(ratings.units(), "ordinal"),
        cliffs_delta(*shown),
        link,
    )


def _configurations(ratings: Ratings) -> tuple[tuple[Configuration, BoolArray], ...]:
    return (("original", ratings.original), ("random", ~ratings.original))


def _shares(judgments: Sequence[Judgment]) -> dict[str, float]:
    ratings = ratings_of(judgments)
    return {
        name: float(ratings.agrees[of].mean()) for name, of in _configurations(ratings) if of.any()
    }


def _row(
    configuration: Configuration,
    ratings: Ratings,
    together: DawidSkene,
    *,
    rng: np.random.Generator,
    draws: int,
    models: bool,
    executor: Executor | None,
) -> Row:
    agrees, n = ratings.agrees, len(ratings)
    by_people = together.reason != "unknown people"
    nobody = Estimate(float(agrees.mean()), reason="unknown people")
    pairs, videos, raters = (
        len(np.unique(index)) for index in (ratings.pair, ratings.video, ratings.rater)
    )
    mixed = None
    if models:
        mixed = crossed(agrees, ratings.video, ratings.rater) if by_people else nobody
    return Row(
        configuration,
        bootstrap(agrees, ratings.video, rng=rng, draws=draws, executor=executor),
        two_way(agrees, ratings.video, ratings.rater) if by_people else nobody,
        wilson(int(agrees.sum()), n),
        clopper_pearson(int(agrees.sum()), n),
        n,
        pairs,
        videos,
        raters,
        float(majorities(agrees, ratings.pair).mean()),
        together.share(np.unique(ratings.pair), 1),
        len(np.unique(ratings.shown)),
        gee(agrees, ratings.video) if models else None,
        mixed,
    )
