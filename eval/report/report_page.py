"""A report as one HTML page that needs nothing else."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from functools import partial
from html import escape
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import msgspec

from corpus_tools.corpus.estimate import Estimate
from corpus_tools.runtime.atomic_folder import check_target, write_folder
from eval.judging import judge_report
from eval.judging.judge_report import GROUPS, notes
from eval.judging.judge_validity import VERDICTS, Agreement, Validity
from eval.report.charts import Line, differences, intervals, reliability
from eval.report.plan_results import WHOLE, Compared, PlanRow, Plans, calibration_error
from eval.report.report_contents import Contents
from eval.statistics.estimates import FEWEST_BESIDE, beside
from eval.statistics.ratings import judged_by
from eval.table_1.correspondence import Row
from eval.table_1.correspondence_table import paper_figures, render
from eval.table_1.learning_curve import curve_plot
from eval.table_2 import rating_table as rated
from eval.table_2.rating_shares import Results
from eval.table_2.rating_table import notes as table_2_notes
from eval.table_2.rating_table import paper_figure as paper_2
from eval.table_3.plan_report import PAPER as PAPER_TABLE_3
from eval.table_3.plan_report import TITLES
from eval.table_3.plan_rows import ALONE
from eval.tables import plot_style
from eval.tables.comparison_report import COLUMNS as COMPARISON_COLUMNS
from eval.tables.comparison_report import shown_p
from eval.tables.formats import delimited, document, estimate_of, interval
from eval.tables.latex import RULE, estimate, tabular, text
from eval.tables.plot_style import NARROW, WIDE, Plot
from g3.errors import CorpusError

NAMES = {
    "random": "random cost",
    "nearest": "no model: the nearest load",
    "keywords": "no model: keywords",
    "embeddings": "no model: word embeddings",
    "paper": "the paper's own model",
    "gold-top30": "annotated SDCs, top 30",
    "auto-top30": "extracted SDCs, top 30",
    "gold-all": "annotated SDCs, all",
    "auto-all": "extracted SDCs, all",
    "right": "known right pairs",
    "wrong": "known wrong pairs",
}
MEASURES = {"precision": "right", "theme": "right load"}
"""Titles of verdicts."""
WRONG_PLANS = 25
LISTED = 6
"""Largest number of a setting's values that the page lists."""
COLOURS = ("ink", "grey", "faint", "ground", "blue", "orange", "green", "purple")
THEMED = {getattr(plot_style, name.upper()): name for name in COLOURS}
"""The page's names of the plots' colours, which differ in dark mode."""


def check_installed() -> None:
    """Refuse to begin without the packages that fill templates and draw plots."""
    for package in ("jinja2", "matplotlib"):
        if find_spec(package) is None:
            raise CorpusError(f"reports need {package}", fix="pip install 'corpus-tools-g3[study]'")


def page(contents: Contents, plots: Mapping[str, Plot]) -> str:
    """Return the page; `plots` are those of :func:`plots_of`."""
    from jinja2 import Environment, StrictUndefined  # noqa: PLC0415 - an extra
    from markupsafe import Markup  # noqa: PLC0415 - comes with it

    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters |= {
        "f2": _fixed,
        "f3": partial(_fixed, digits=3),
        "fixed": _fixed,
        "signed": _signed,
        "count": _count,
        "to": _to,
        "signed_to": _signed_to,
        "p": shown_p,
    }
    template = environment.from_string(
        files("eval.report").joinpath("page.html").read_text(encoding="utf-8")
    )
    charts = {name: Markup(_inline(plot)) for name, plot in plots.items()}  # noqa: S704 - ours
    return template.render(
        contents=contents,
        charts=charts,
        paper_1=_paper_1,
        paper_2=paper_2,
        judged_by=judged_by,
        paper_3=paper_figure,
        name_of=name_of,
        titles=TITLES,
        measures=MEASURES,
        wrong_plans=WRONG_PLANS,
        calibration=calibration_error(contents.reliability).value,
        table_2_notes=(
            table_2_notes(contents.table_2, contents.is_authored) if contents.table_2 else []
        ),
        validity_notes=notes(contents.validity) if contents.validity else [],
        agreements=_agreements(contents.validity),
        verdicts=VERDICTS,
        baselines=ALONE,
        fewest_beside=FEWEST_BESIDE,
        provenance=[(key.replace("_", " "), _said(v)) for key, v in contents.provenance.items()],
    )


def plots_of(contents: Contents) -> dict[str, Plot]:
    """Return all plots of a report by the names of their files."""
    plots = {
        "table-1": intervals(_of_table_1(contents), "F-scores of Table 1"),
        "reliability": reliability(contents.reliability, "Reliability of correspondences"),
    }
    if contents.curve:
        bounds = f"range of {contents.repeats} random orders"
        plots["learning-curve"] = curve_plot(contents.curve, bounds)
    if contents.table_2:
        plots["table-2"] = intervals(
            _of_table_2(contents.table_2, is_authored=contents.is_authored), "Table 2"
        )
    for plans in contents.plans:
        plots |= {f"{plans.name}-{name}": plot for name, plot in _of_plans(plans).items()}
    return plots


def _of_plans(plans: Plans) -> dict[str, Plot]:
    plots = {}
    for part, rows in plans.parts().items():
        plots[part] = intervals(_of_table_3(rows, plans), f"Table 3: {TITLES[part]}")
        if compared := plans.compared_on(part):
            title = f"Differences: {TITLES[part]}"
            plots[f"{part}-compared"] = differences(_of_comparisons(compared), title)
    if plans.file.people:
        plots["people"] = intervals(_of_table_3(plans.file.people, plans), "Table 3 by people")
    if plans.file.people_compared:
        lines = _of_comparisons(plans.file.people_compared)
        plots["people-compared"] = differences(lines, "Differences by people")
    if plans.reliability:
        plots["reliability"] = reliability(plans.reliability, "Reliability of plans")
    return plots


def _inline(plot: Plot) -> str:
    """Return a plot as HTML in two widths, of which the page shows that which fits."""
    return "".join(
        f'<div class="{name}">{_themed(plot, width)}</div>'
        for name, width in (("on-wide", WIDE), ("on-narrow", NARROW))
    )


def _themed(plot: Plot, width: float) -> str:
    """Return a plot as an SVG element, in the page's colours and type."""
    svg = plot.saved("svg", width).decode()
    svg = re.sub("<metadata>.*?</metadata>", "", svg[svg.index("<svg") :], flags=re.DOTALL)
    svg = re.sub(r' id="[a-z0-9]+_\d+"', "", svg)  # which other plots have too
    for colour, name in THEMED.items():
        svg = svg.replace(colour, f"var(--{name})")
    return svg.replace("<svg ", f'<svg role="img" aria-label="{escape(plot.title)}" ', 1)


def _of_table_1(contents: Contents) -> list[Line]:
    return [Line(row.type, {"F-score": row.f}, _paper_1(row, contents)) for row in contents.table_1]


def _paper_1(row: Row, contents: Contents) -> float | None:
    """Return the paper's F-score beside a row."""
    return paper_figures(row, contents.is_authored)["f"]


def _of_table_2(results: Results, *, is_authored: bool) -> list[Line]:
    return [
        Line(
            f"{row.configuration} video",
            {"other videos": row.share, "and other raters": row.two_way},
            paper_2(row, results.study, is_authored),
        )
        for row in results.rows
    ]


def _of_table_3(rows: Sequence[PlanRow], plans: Plans) -> list[Line]:
    lines = []
    for row in rows:
        figures = {MEASURES["precision"]: estimate_of(row.precision, row.low, row.high, row.reason)}
        if any(one.theme is not None for one in rows):
            figures[MEASURES["theme"]] = estimate_of(
                row.theme, row.theme_low, row.theme_high, row.theme_reason
            )
        is_baseline = row.configuration in ALONE
        lines.append(Line(name_of(row), figures, paper_figure(row, plans), is_baseline))
    return lines


def paper_figure(row: PlanRow, plans: Plans) -> float | None:
    """Return the paper's figure beside a row, where the corpora are alike."""
    printed = PAPER_TABLE_3.get(row.configuration) if row.subset == WHOLE else None
    return beside(printed, row.n, is_authored=not plans.has_paper)


def name_of(row: PlanRow) -> str:
    """Return a row's name for people."""
    return NAMES.get(row.configuration, row.configuration)


def _of_comparisons(compared: Sequence[Compared]) -> list[Line]:
    pairs: dict[str, dict[str, Estimate]] = {}
    for c in compared:
        figures_of_pair = pairs.setdefault(f"{c.one} − {c.other}", {})
        figures_of_pair[MEASURES[c.verdict]] = estimate_of(c.difference, c.low, c.high, c.reason)
    return [Line(name, figures) for name, figures in pairs.items()]


def _agreements(validity: Validity | None) -> list[tuple[str, str, Agreement]]:
    """Return the agreements with people by verdict and pairs, near misses first."""
    if validity is None:
        return []
    near = [
        (VERDICTS[verdict], f"another video: {GROUPS[name]}", agreement)
        for verdict, groups in validity.near_misses.items()
        for name, agreement in groups.items()
    ]
    own_videos = validity.own_videos.items()
    return [
        *near,
        *((VERDICTS[verdict], "its own video", agreement) for verdict, agreement in own_videos),
    ]


def _said(value: object) -> str:
    """Render a setting as text; long lists are in the JSON beside the page."""
    if isinstance(value, Mapping):
        return "; ".join(f"{key.replace('_', ' ')}: {_said(one)}" for key, one in value.items())
    if isinstance(value, list):
        few = len(value) <= LISTED
        return ", ".join(map(_said, value)) or "none" if few else f"{len(value)} (report.json)"
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)


def _fixed(value: float | None, digits: int = 2) -> str:
    return "–" if value is None or math.isnan(value) else f"{value:.{digits}f}".replace("-", "−")


def _count(value: float | None) -> str:
    return "–" if value is None else f"{value:.4g}"


def _signed(value: float) -> str:
    return f"{value:+.2f}".replace("-", "−")


def _to(low: float | None, high: float | None, digits: int = 2, reason: str = "") -> str:
    shown = interval(estimate_of(0.0, low, high, reason), f"{{:.{digits}f}}–{{:.{digits}f}}")
    return "–" if shown == "-" else shown.replace("-", "−")


def _signed_to(low: float | None, high: float | None, reason: str = "") -> str:
    if low is None or high is None:
        return reason or "–"
    return f"{_signed(low)} to {_signed(high)}"


MARKER = "report.json"
PLAN_COLUMNS = ("table", *PlanRow.__struct_fields__, "paper")


def check_writable(folder: Path) -> None:
    """Refuse a folder that holds anything but an old report, and missing packages."""
    check_installed()
    check_target(folder, force=True, marker=MARKER)


def write_report(contents: Contents, folder: Path) -> list[str]:
    """Write all files, or none, and return their names."""
    plots = plots_of(contents)
    made = {name: f"{text}\n".encode() for name, text in _files(contents, plots).items()}
    for name, plot in plots.items():
        made |= {f"{name}.svg": plot.saved("svg"), f"{name}.pdf": plot.saved("pdf")}
    write_folder(folder, made, force=True, marker=MARKER)
    return sorted(made)


def _files(contents: Contents, plots: Mapping[str, Plot]) -> dict[str, str]:
    about = contents.metadata
    texts = {
        "report.html": page(contents, plots),
        MARKER: _document(contents),
        "table-1.csv": render(contents.table_1, "csv", about),
        "table-1.tex": render(contents.table_1, "latex", about),
    }
    if contents.curve:
        points = [asdict(p) for p in contents.curve]
        columns = ("type", "sdcs", "error", "low", "high", "reason")
        texts["learning-curve.csv"] = delimited(points, {}, columns=columns)
    if contents.table_2:
        authored: dict[str, object] = {"is_authored": contents.is_authored}
        ratings = {"table": 2, "corpus": str(contents.provenance["corpus_hash"]), **authored}
        texts["table-2.csv"] = rated.render(contents.table_2, "csv", ratings)
        texts["table-2.tex"] = rated.render(contents.table_2, "latex", ratings)
    if contents.plans:
        rows = [row for plans in contents.plans for row in _rows(plans)]
        texts["table-3.csv"] = delimited(rows, {}, columns=PLAN_COLUMNS)
        texts["table-3.tex"] = "\n\n".join(map(_latex, contents.plans))
        compared = [
            {"table": plans.name, "judge": judge, **msgspec.to_builtins(c)}
            for plans in contents.plans
            for judge, several in (
                ("automatic", plans.file.comparisons),
                ("people", plans.file.people_compared),
            )
            for c in several
        ]
        texts["table-3-comparisons.csv"] = delimited(
            compared, {}, columns=("table", "judge", "subset", "verdict", *COMPARISON_COLUMNS)
        )
    return texts


def _document(contents: Contents) -> str:
    made: dict[str, Any] = {
        "provenance": contents.provenance,
        "commands": list(contents.commands),
        "table_1": json.loads(render(contents.table_1, "json", contents.metadata)),
        "reliability": [asdict(b) for b in contents.reliability],
        "learning_curve": [asdict(p) for p in contents.curve],
        "errors": [asdict(one) for one in contents.errors],
        "table_2": None,
        "judge_validity": None,
        "table_3": [plans.document for plans in contents.plans],
        "examples": [{"video": e.name, "command": e.command} for e in contents.shown],
    }
    if contents.table_2:
        authored = {"is_authored": contents.is_authored}
        made["table_2"] = json.loads(rated.render(contents.table_2, "json", authored))
    if contents.validity:
        made["judge_validity"] = judge_report.summary(contents.validity)
    return document(made, {})


def _rows(plans: Plans) -> list[dict[str, object]]:
    return [
        {"table": plans.name, **msgspec.to_builtins(row), "paper": paper_figure(row, plans)}
        for row in (*plans.file.rows, *(plans.file.people or ()))
    ]


def _latex(plans: Plans) -> str:
    tables = []
    for part, rows in plans.parts().items():
        title = f"Table 3, {plans.name}: {TITLES[part]}. Judged by a program"
        papers = "; the paper's figures are people's" if plans.has_paper else ""
        tables.append(_rows_latex(f"{title}{papers}.", rows, plans))
        if compared := plans.compared_on(part):
            tables.append(_compared_latex(f"{title}: configurations compared.", compared))
    if plans.file.people:
        title = f"Table 3, {plans.name}. Judged by people"
        tables.append(_rows_latex(f"{title}.", plans.file.people, plans))
        if plans.file.people_compared:
            tables.append(
                _compared_latex(f"{title}: configurations compared.", plans.file.people_compared)
            )
    return "\n\n".join(tables)


def _rows_latex(title: str, rows: Sequence[PlanRow], plans: Plans) -> str:
    cells: list[Sequence[str]] = []
    has_paper = any(paper_figure(row, plans) is not None for row in rows)
    for i, row in enumerate(rows):
        if i and row.configuration not in ALONE and rows[i - 1].configuration in ALONE:
            cells.append(RULE)
        right = estimate(estimate_of(row.precision, row.low, row.high, row.reason))
        load = estimate(estimate_of(row.theme, row.theme_low, row.theme_high, row.theme_reason))
        printed = paper_figure(row, plans)
        paper = [estimate(estimate_of(printed, None, None))] if has_paper else []
        cells.append((text(name_of(row)), right, load, *paper, str(row.n)))
    headings = ("Configuration", "Right", "Right load", *(["Paper"] if has_paper else []), "$n$")
    return tabular(headings, cells, comments=[title])


def _compared_latex(title: str, compared: Sequence[Compared]) -> str:
    cells = [
        (
            f"{text(c.one)} $-$ {text(c.other)}",
            MEASURES[c.verdict],
            estimate(estimate_of(c.difference, c.low, c.high, c.reason), "${:+.2f}$"),
            f"${shown_p(c.adjusted_p)}$",
            f"${c.effect:+.2f}$",
            str(c.n),
        )
        for c in compared
    ]
    return tabular(
        ("", "Measure", "Difference", "$p$, Holm", "$h$", "$n$"), cells, comments=[title]
    )
