"""Table 2 of the paper, with its figures beside: how often people agree."""

from __future__ import annotations

from collections.abc import Mapping

from corpus_tools.corpus.estimate import Estimate, explained, named
from corpus_tools.runtime.text_tables import figure_table
from corpus_tools.simulation.simulated_raters import STUDY as SIMULATED
from eval.statistics.estimates import FEWEST_BESIDE, NO_PAPER, beside
from eval.statistics.ratings import judged_by
from eval.table_2.rating_shares import Configuration, Results, Row
from eval.tables.formats import (
    Format,
    comments,
    delimited,
    document,
    figure,
    interval,
    stated,
    table_text,
    value,
)
from eval.tables.latex import estimate, tabular

PAPER: dict[Configuration, float] = {"original": 0.91, "random": 0.11}
PAPER_SOURCE = "Tellex et al. (AAAI 2011), Table 2"
BOUNDS = "{:.3f} to {:.3f}"
MODELS = ("GEE", "Crossed model")
COUNTS = ("n", "pairs", "videos", "raters", "majority")
BOUNDED = ("low", "high", "reason")
COLUMNS = (
    "configuration", "precision", *BOUNDED, *COUNTS, "weighed", "weighed_reason",
    *(f"{of}_{part}" for of in ("wilson", "exact", "two_way") for part in BOUNDED),
    "shown", "gee", *(f"gee_{part}" for part in BOUNDED),
    "crossed", *(f"crossed_{part}" for part in BOUNDED), "paper",
)  # fmt: skip


def render(
    results: Results,
    form: Format,
    metadata: Mapping[str, object],
    *,
    verbose: bool = False,
    terminal: bool = False,
) -> str:
    """Render Table 2 in one of the formats, with the paper's figures unless it is authored.

    A text has the intervals and shares by other methods where `verbose` asks for them. The
    metadata's ``is_authored`` is true of an authored corpus.
    """
    is_authored = bool(metadata.get("is_authored"))
    about = {"judged_by": judged_by(results.study), "study": results.study, **metadata}
    if form == "json":
        return document(_content(results, is_authored), about)
    if form == "csv":
        both = _of_both(results)
        rows = [{**_flat(row, results.study, is_authored), **both} for row in results.rows]
        return delimited(rows, about, columns=(*COLUMNS, *both))
    if form == "latex":
        return _latex(results, about, is_authored)
    return _text(results, about, is_authored, verbose=verbose, terminal=terminal)


def paper_figure(row: Row, study: str, is_authored: bool) -> float | None:
    """Return the paper's figure beside a row; none beside simulated raters' judgments."""
    is_invented = is_authored or study == SIMULATED
    return beside(PAPER[row.configuration], row.pairs, is_authored=is_invented)


def _has_paper(results: Results, is_authored: bool) -> bool:
    return not is_authored and results.study != SIMULATED


def notes(results: Results, is_authored: bool = False) -> list[str]:
    """Return notes on the figures, and on their difference from the paper's."""
    videos = (f"{r.configuration} {r.videos}, shown with {r.shown}" for r in results.rows)
    result = [
        "95%: percentile interval with whole videos resampled: those that the commands were typed "
        f"for ({'; '.join(videos)})",
        "videos, raters: both as clusters, which speaks for other raters too",
        "independent: Wilson's interval, too narrow, for judgments of a video are alike",
        "majority, weighed: part of the pairs, by most judgments or by Dawid and Skene's model",
    ]
    papers = (
        f"paper: {PAPER_SOURCE}. It doesn't state which judgments it counts, nor whether it "
        "counts single ones or pairs: each rater who differs lowers a share of judgments, and "
        f"is outvoted in a majority. It is left out beside fewer than {FEWEST_BESIDE} pairs"
    )
    result.append(papers if _has_paper(results, is_authored) else NO_PAPER)
    if any(row.model is not None for row in results.rows):
        result.append(
            "GEE: estimating equations with videos as clusters; crossed model: linear, with random "
            "effects of videos and of raters"
        )
    result += [
        f"Krippendorff's alpha of the five points: {stated(results.alpha, '{:.3f}')}",
        f"Cliff's delta between the configurations: {stated(results.delta, '{:.3f}')}",
    ]
    if results.link is not None:
        odds = results.link.odds_ratio()
        result.append(
            "odds of a higher rating with the original video, against the random one: "
            f"{stated(odds, '{:.3g}')}, as a ratio (cumulative link, errors robust to videos)"
        )
    result += explained(_estimates(results))
    if results.repeats:
        result.append(
            f"{results.repeats} judgments count that are by somebody who had judged the pair before"
        )
    for name, of in results.left_out.items():
        shares = ", ".join(f"{k} {v:.3f}" for k, v in of.items() if k != "judgments")
        result.append(f"left out: study {name}, {of['judgments']:.0f} judgments ({shares})")
    return result


def _estimates(results: Results) -> list[Estimate]:
    """Return all figures of the table and its notes."""
    result: list[Estimate | None] = [results.alpha, results.delta]
    for row in results.rows:
        result += [row.share, row.two_way, row.wilson, row.exact, row.weighed]
        result += [row.model, row.crossed]
    if results.link is not None:
        result.append(results.link.odds_ratio())
    return [one for one in result if one is not None]


def _bounds(one: Estimate) -> dict[str, object]:
    return {part: getattr(one, part) for part in BOUNDED}


def _content(results: Results, is_authored: bool) -> dict[str, object]:
    rows = [
        {
            "configuration": row.configuration,
            "precision": row.share.value,
            **_bounds(row.share),
            **{name: getattr(row, name) for name in COUNTS},
            **named({"weighed": row.weighed}),
            "two_way": _bounds(row.two_way),
            "wilson": _bounds(row.wilson),
            "clopper_pearson": _bounds(row.exact),
            "shown": row.shown,
            "gee": row.model,
            "crossed": row.crossed,
            "paper": paper_figure(row, results.study, is_authored),
        }
        for row in results.rows
    ]
    return {
        "rows": rows,
        **named({"alpha": results.alpha, "cliffs_delta": results.delta}),
        "odds_ratio": None if results.link is None else results.link.odds_ratio(),
        "repeats": results.repeats,
        "left_out": results.left_out,
        "notes": notes(results, is_authored),
    }


def _flat(row: Row, study: str, is_authored: bool) -> dict[str, object]:
    result: dict[str, object] = {
        "configuration": row.configuration,
        "precision": row.share.value,
        **_bounds(row.share),
        **named({"weighed": row.weighed}),
        "paper": paper_figure(row, study, is_authored),
    }
    result |= {name: getattr(row, name) for name in (*COUNTS, "shown")}
    for name in ("wilson", "exact", "two_way"):
        result |= {f"{name}_{part}": one for part, one in _bounds(getattr(row, name)).items()}
    for name, model in (("gee", row.model), ("crossed", row.crossed)):
        columns = (name, *(f"{name}_{part}" for part in BOUNDED))
        result |= dict(zip(columns, model[:4] if model else (None,) * 4, strict=True))
    return result


def _of_both(results: Results) -> dict[str, object]:
    """Return figures of both configurations together, which CSV repeats in each row."""
    odds = None if results.link is None else results.link.odds_ratio()
    result: dict[str, object] = {
        **named({"alpha": results.alpha, "cliffs_delta": results.delta}),
    }
    if odds is not None:
        result |= {"odds_ratio": odds.value}
        result |= {f"odds_ratio_{part}": one for part, one in _bounds(odds).items()}
    return result


def _text(
    results: Results,
    metadata: Mapping[str, object],
    is_authored: bool,
    *,
    verbose: bool,
    terminal: bool,
) -> str:
    has_models = any(row.model is not None for row in results.rows)
    papers = ("Paper",) if _has_paper(results, is_authored) else ()
    table = figure_table(
        ("Video", "Agree", "95%", "Videos, raters", "Majority", *papers, "n", "Pairs")
    )
    others = figure_table(("Video", "Independent", "Weighed", *(MODELS if has_models else ())))
    for row in results.rows:
        paper = (figure(paper_figure(row, results.study, is_authored)) for _ in papers)
        table.add_row(
            row.configuration,
            f"{row.share.value:.3f}",
            *(interval(e, BOUNDS) for e in (row.share, row.two_way)),
            f"{row.majority:.2f}",
            *paper,
            str(row.n),
            str(row.pairs),
        )
        others.add_row(
            row.configuration,
            interval(row.wilson, BOUNDS),
            value(row.weighed),
            *(stated(e, "{:.3f}") for e in (row.model, row.crossed) if e),
        )
    judges = judged_by(results.study).capitalize()
    tables = {f"{judges} who agree that the video shows the command": table}
    if has_models or verbose:
        tables["By other methods"] = others
    return table_text(tables, notes(results, is_authored), metadata, terminal=terminal)


def _latex(results: Results, metadata: Mapping[str, object], is_authored: bool) -> str:
    papers = ("Paper",) if _has_paper(results, is_authored) else ()
    cells = [
        (
            row.configuration,
            estimate(row.share, "{:.3f}"),
            f"{row.majority:.2f}",
            *(figure(paper_figure(row, results.study, is_authored)) for _ in papers),
            str(row.n),
            *(estimate(one, "{:.3f}") for one in (row.model, row.crossed) if one),
        )
        for row in results.rows
    ]
    has_models = any(row.model is not None for row in results.rows)
    headings = ("Video", "Agree", "Majority", *papers, "$n$", *(MODELS if has_models else ()))
    return tabular(headings, cells, comments=[*comments(metadata), *notes(results, is_authored)])
