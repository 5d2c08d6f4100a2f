"""Table 2 of the paper, with its figures beside: how often people agree."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from corpus_tools.simulation.simulated_raters import STUDY as SIMULATED
from eval.statistics.estimates import FEWEST_BESIDE, Estimate, beside
from eval.table_2.rating_shares import Configuration, Results, Row
from eval.tables.formats import (
    Format,
    comments,
    delimited,
    document,
    figure_table,
    interval,
    table_text,
)
from eval.tables.latex import estimate, tabular

PAPER: dict[Configuration, float] = {"original": 0.91, "random": 0.11}
PAPER_SOURCE = "Tellex et al. (AAAI 2011), Table 2"
BOUNDS = "{:.3f} to {:.3f}"
MODELS = ("GEE", "Crossed model")
COUNTS = ("n", "pairs", "videos", "raters", "majority", "weighed")
COLUMNS = (
    "configuration", "precision", "low", "high", *COUNTS, "wilson_low", "wilson_high", "exact_low",
    "exact_high", "two_way_low", "two_way_high", "shown", "gee", "gee_low",
    "gee_high", "crossed", "crossed_low", "crossed_high", "paper",
)  # fmt: skip


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
    videos = (f"{r.configuration} {r.videos}, shown with {r.shown}" for r in results.rows)
    found = [
        "95%: percentile interval with whole videos resampled: those that the commands were typed "
        f"for ({'; '.join(videos)})",
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


def _bounds(estimate: Estimate) -> dict[str, float]:
    return {"low": estimate.low, "high": estimate.high}


def _content(results: Results) -> dict[str, object]:
    rows = [
        {
            "configuration": row.configuration,
            "precision": row.share.value,
            **_bounds(row.share),
            **{name: getattr(row, name) for name in COUNTS},
            "two_way": _bounds(row.two_way),
            "wilson": _bounds(row.wilson),
            "clopper_pearson": _bounds(row.exact),
            "shown": row.shown,
            "gee": None if row.model is None else row.model._asdict(),
            "crossed": None if row.crossed is None else row.crossed._asdict(),
            "paper": paper_figure(row),
        }
        for row in results.rows
    ]
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
    found |= {name: getattr(row, name) for name in (*COUNTS, "shown")}
    for name in ("wilson", "exact", "two_way"):
        for bound, value in _bounds(getattr(row, name)).items():
            found[f"{name}_{bound}"] = value
    for name, one in (("gee", row.model), ("crossed", row.crossed)):
        columns = (name, f"{name}_low", f"{name}_high")
        found |= dict(zip(columns, one or (None,) * 3, strict=True))
    return found


def _table(results: Results, metadata: Mapping[str, object], *, terminal: bool) -> str:
    has_models = any(row.model is not None for row in results.rows)
    headings = (
        "Video", "Agree", "95%", "Videos, raters", "Independent", "Majority", "Weighed", "Paper",
        "n", "Pairs", *(MODELS if has_models else ()),
    )  # fmt: skip
    table = figure_table(headings)
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
