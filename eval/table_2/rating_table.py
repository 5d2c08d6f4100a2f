"""Table 2 of the paper: how often people agree that a video shows a command."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib.util import find_spec
from typing import Literal

import numpy as np
from rich.table import Table

from corpus_tools.corpus.rater_agreement import krippendorff_alpha
from corpus_tools.runtime.parallel import Executor
from corpus_tools.simulation.simulated_raters import STUDY as SIMULATED
from eval.statistics.crossed_model import crossed
from eval.statistics.estimates import FEWEST_BESIDE, BoolArray, Estimate, beside
from eval.statistics.intervals import bootstrap, clopper_pearson, gee, two_way, wilson
from eval.statistics.ordinal import CumulativeLink, cliffs_delta, cumulative_link
from eval.statistics.raters import dawid_skene, majorities
from eval.statistics.ratings import Ratings, of_study, ratings_of, repeated
from eval.tables.formats import Format, comments, delimited, document, interval, table_text
from eval.tables.latex import estimate, tabular
from g3.annotation import Judgment
from g3.errors import CorpusError, FormatError
from g3.short_repr import short_repr

Configuration = Literal["original", "random"]
PAPER: dict[Configuration, float] = {"original": 0.91, "random": 0.11}
PAPER_SOURCE = "Tellex et al. (AAAI 2011), Table 2"
BOUNDS = "{:.3f} to {:.3f}"
MODELS = ("GEE", "Crossed model")
COLUMNS = (
    "configuration", "precision", "low", "high", "n", "pairs", "videos", "raters", "majority",
    "weighed", "wilson_low", "wilson_high", "exact_low", "exact_high", "two_way_low",
    "two_way_high", "shown", "gee", "gee_low", "gee_high", "crossed", "crossed_low", "crossed_high",
    "paper",
)  # fmt: skip


@short_repr
@dataclass(frozen=True, slots=True)
class Row:
    """A configuration of Table 2.

    Parameters
    ----------
    share
        Judgments that agree or agree strongly, with whole videos resampled.
    two_way
        The same for other videos and other raters.
    wilson, exact
        The same with judgments taken for independent, which is too narrow.
    n, pairs, videos, raters
        How many there are; `videos` are those that the commands were typed for, which are the
        clusters.
    shown
        How many videos the commands were shown with.
    majority
        The part of the pairs of which more than half of the judgments agree.
    weighed
        The part of the pairs that show the command, by Dawid and Skene's model of raters who
        err each in their own way.
    model
        By generalised estimating equations, with videos as clusters; None unless asked for.
    crossed
        By a mixed model with crossed effects of videos and raters; None unless asked for.
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
    weighed: float
    shown: int
    model: Estimate | None = None
    crossed: Estimate | None = None


@short_repr
@dataclass(frozen=True, slots=True)
class Results:
    """Table 2, and what else the judgments say.

    Parameters
    ----------
    study
        The study whose judgments are counted.
    left_out
        For each other study, how many judgments it has and what part agrees by configuration.
    repeats
        How many judgments are by somebody who had judged the same pair before; they count.
    alpha
        Krippendorff's α of the five points, over all pairs.
    delta
        Cliff's δ between the ratings of the two configurations.
    link
        The cumulative-link model of the ratings; None unless asked for.
    """

    rows: tuple[Row, ...]
    study: str
    left_out: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    repeats: int = 0
    alpha: float | None = None
    delta: float = float("nan")
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
        Whose judgments are counted; the study that has most of them if empty, for another one
        may be of the same pairs.
    draws, executor
        Resamples for the intervals, and who makes them
        (:func:`eval.statistics.resampling.resampled_sums`).
    models
        Whether to fit the models too, which takes seconds and needs statsmodels.

    Raises
    ------
    FormatError
        If there are no judgments, or no such study.
    CorpusError
        If statsmodels isn't installed and `models` need it.
    """
    if models and find_spec("statsmodels") is None:
        raise CorpusError("--models needs statsmodels", fix="pip install 'corpus-tools-g3[study]'")
    if not judgments:
        raise FormatError("the corpus has no judgments", fix="give one with ratings of videos")
    mine = of_study(judgments, study)
    others = Counter(j.study for j in judgments if j.study != mine[0].study)
    ratings = ratings_of(mine)
    rng = np.random.default_rng(seed)
    together = dawid_skene(ratings.pair, ratings.rater, ratings.agrees.astype(np.int64), 2)
    shows = together.posterior[:, 1] > 0.5
    rows = tuple(
        _row(name, ratings.only(of), shows, rng=rng, draws=draws, models=models, executor=executor)
        for name, of in _configurations(ratings)
        if of.any()
    )
    left_out = {
        other: {"judgments": n, **_shares([j for j in judgments if j.study == other])}
        for other, n in sorted(others.items())
    }
    shown = [ratings.rating[of] for _, of in _configurations(ratings)]
    has_both = all(len(found) for found in shown)
    link = None
    several = all(len(np.unique(of)) > 1 for of in (ratings.rating, ratings.video))
    if models and has_both and several:
        predictor = ratings.original[:, None].astype(np.float64)
        link = cumulative_link(ratings.rating, predictor, ratings.video)
    return Results(
        rows,
        mine[0].study,
        left_out,
        repeated(mine),
        krippendorff_alpha(ratings.units(), "ordinal"),
        cliffs_delta(*shown) if has_both else float("nan"),
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
    shows: BoolArray,
    *,
    rng: np.random.Generator,
    draws: int,
    models: bool,
    executor: Executor | None,
) -> Row:
    agrees, n = ratings.agrees, len(ratings)
    pairs, videos, raters = (
        len(np.unique(index)) for index in (ratings.pair, ratings.video, ratings.rater)
    )
    return Row(
        configuration,
        bootstrap(agrees, ratings.video, rng=rng, draws=draws, executor=executor),
        two_way(agrees, ratings.video, ratings.rater),
        wilson(int(agrees.sum()), n),
        clopper_pearson(int(agrees.sum()), n),
        n,
        pairs,
        videos,
        raters,
        float(majorities(agrees, ratings.pair).mean()),
        float(shows[np.unique(ratings.pair)].mean()),
        len(np.unique(ratings.shown)),
        gee(agrees, ratings.video) if models else None,
        crossed(agrees, ratings.video, ratings.rater) if models else None,
    )


def render(
    results: Results,
    form: Format,
    metadata: Mapping[str, object],
    *,
    terminal: bool = False,
) -> str:
    """Table 2 in one of the formats, with the paper's figures beside."""
    about = {"judged_by": judged_by(results.study), "study": results.study, **metadata}
    if form == "json":
        return document(_content(results), about)
    if form == "csv":
        return delimited([_flat(row) for row in results.rows], about, columns=COLUMNS)
    if form == "latex":
        return _latex(results, about)
    return _table(results, about, terminal=terminal)


def paper_figure(row: Row) -> float | None:
    """The paper's figure beside a row."""
    return beside(PAPER[row.configuration], row.pairs)


def judged_by(study: str) -> str:
    """Who gave a study's ratings."""
    return "simulated raters" if study == SIMULATED else "people"


def notes(results: Results) -> list[str]:
    """What a reader should know of the figures, and why they differ from the paper's."""
    found = [
        f"95%: percentile interval with whole videos resampled: {_clusters(results.rows)}",
        "videos, raters: both as clusters, which speaks for other raters too",
        "independent: Wilson's interval, too narrow, for judgments of a video are alike",
        "majority, weighed: part of the pairs, by most judgments or by Dawid and Skene's model",
        f"paper: {PAPER_SOURCE}. It differs because it doesn't tell which judgments it counts, nor "
        "whether single ones or pairs: each rater who differs lowers a share of judgments, and "
        f"is outvoted in a majority. It is left out beside fewer than {FEWEST_BESIDE} pairs",
    ]
    if any(row.model is not None for row in results.rows):
        found.append(
            "GEE: estimating equations with videos as clusters; crossed model: linear, with random "
            "effects of videos and of raters"
        )
    if results.alpha is not None:
        found.append(f"Krippendorff's alpha of the five points: {results.alpha:.3f}")
    if not np.isnan(results.delta):
        found.append(f"Cliff's delta between the configurations: {results.delta:.3f}")
    if results.link is not None:
        odds = results.link.odds_ratio()
        found.append(
            "odds of a higher rating with the original video, against the random one: "
            f"{odds.value:.0f} times ({odds.low:.0f} to {odds.high:.0f}; cumulative link, "
            "errors robust to videos)"
        )
    if results.repeats:
        found.append(
            f"{results.repeats} judgments count that are by somebody who had judged the pair before"
        )
    for name, of in results.left_out.items():
        shares = ", ".join(f"{k} {v:.3f}" for k, v in of.items() if k != "judgments")
        found.append(f"left out: study {name}, {of['judgments']:.0f} judgments ({shares})")
    return found


def _clusters(rows: Sequence[Row]) -> str:
    """Which videos are the clusters, and how many."""
    each = (f"{row.configuration} {row.videos}, shown with {row.shown}" for row in rows)
    return f"those that the commands were typed for ({'; '.join(each)})"


def _bounds(estimate: Estimate) -> dict[str, float]:
    return {"low": estimate.low, "high": estimate.high}


def _content(results: Results) -> dict[str, object]:
    rows = []
    for row in results.rows:
        rows.append(
            {
                "configuration": row.configuration,
                "precision": row.share.value,
                **_bounds(row.share),
                "n": row.n,
                "pairs": row.pairs,
                "videos": row.videos,
                "raters": row.raters,
                "majority": row.majority,
                "weighed": row.weighed,
                "two_way": _bounds(row.two_way),
                "wilson": _bounds(row.wilson),
                "clopper_pearson": _bounds(row.exact),
                "shown": row.shown,
                "gee": None if row.model is None else row.model._asdict(),
                "crossed": None if row.crossed is None else row.crossed._asdict(),
                "paper": paper_figure(row),
            }
        )
    return {
        "rows": rows,
        "alpha": results.alpha,
        "cliffs_delta": results.delta,
        "odds_ratio": None if results.link is None else results.link.odds_ratio()._asdict(),
        "repeats": results.repeats,
        "left_out": results.left_out,
        "notes": notes(results),
    }


def _flat(row: Row) -> dict[str, object]:
    found: dict[str, object] = {
        "configuration": row.configuration,
        "precision": row.share.value,
        **_bounds(row.share),
        "paper": paper_figure(row),
    }
    found |= {
        name: getattr(row, name)
        for name in ("n", "pairs", "videos", "raters", "majority", "weighed", "shown")
    }
    for name in ("wilson", "exact", "two_way"):
        for bound, value in _bounds(getattr(row, name)).items():
            found[f"{name}_{bound}"] = value
    for name, one in (("gee", row.model), ("crossed", row.crossed)):
        columns = (name, f"{name}_low", f"{name}_high")
        found |= dict(zip(columns, one or (None,) * 3, strict=True))
    return found


def _table(results: Results, metadata: Mapping[str, object], *, terminal: bool) -> str:
    table = Table()
    table.add_column("Video")
    headings = (
        "Agree",
        "95%",
        "Videos, raters",
        "Independent",
        "Majority",
        "Weighed",
        "Paper",
        "n",
        "Pairs",
    )
    has_models = any(row.model is not None for row in results.rows)
    for heading in (*headings, *(MODELS if has_models else ())):
        table.add_column(heading, justify="right")
    for row in results.rows:
        table.add_row(
            row.configuration,
            f"{row.share.value:.3f}",
            *(interval(*e[1:], BOUNDS) for e in (row.share, row.two_way, row.wilson)),
            f"{row.majority:.2f}",
            f"{row.weighed:.2f}",
            "-" if (paper := paper_figure(row)) is None else f"{paper:.2f}",
            str(row.n),
            str(row.pairs),
            *(f"{e[0]:.3f} ({interval(*e[1:], BOUNDS)})" for e in (row.model, row.crossed) if e),
        )
    title = f"{judged_by(results.study).capitalize()} who agree that the video shows the command"
    return table_text({title: table}, notes(results), metadata, terminal=terminal)


def _latex(results: Results, metadata: Mapping[str, object]) -> str:
    cells = [
        (
            row.configuration,
            estimate(*row.share, "{:.3f}"),
            f"{row.majority:.2f}",
            "-" if (paper := paper_figure(row)) is None else f"{paper:.2f}",
            str(row.n),
            *(estimate(*one, "{:.3f}") for one in (row.model, row.crossed) if one),
        )
        for row in results.rows
    ]
    has_models = any(row.model is not None for row in results.rows)
    headings = ("Video", "Agree", "Majority", "Paper", "$n$", *(MODELS if has_models else ()))
    return tabular(headings, cells, comments=[*comments(metadata), *notes(results)])
