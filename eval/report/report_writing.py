"""A report's files: the page, and the same as JSON, CSV and LaTeX."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import msgspec

from corpus_tools.runtime.atomic_folder import check_target, write_folder
from eval.judging import judge_report
from eval.report.plan_results import Compared, PlanRow, Plans
from eval.report.report_contents import Contents
from eval.report.report_page import (
    MEASURES,
    check_installed,
    name_of,
    page,
    paper_figure,
    plots_of,
)
from eval.table_1.correspondence_table import render
from eval.table_2 import rating_table as rated
from eval.table_3.plan_report import TITLES
from eval.table_3.plan_rows import ALONE
from eval.tables.comparison_report import COLUMNS as COMPARISON_COLUMNS
from eval.tables.comparison_report import shown_p
from eval.tables.formats import delimited, document, estimate_of
from eval.tables.latex import RULE, estimate, tabular, text
from eval.tables.plot_style import Plot

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
    found = {
        "report.html": page(contents, plots),
        MARKER: _document(contents),
        "table-1.csv": render(contents.table_1, "csv", about),
        "table-1.tex": render(contents.table_1, "latex", about),
    }
    if contents.curve:
        points = [asdict(p) for p in contents.curve]
        columns = ("type", "sdcs", "error", "low", "high", "reason")
        found["learning-curve.csv"] = delimited(points, {}, columns=columns)
    if contents.table_2:
        ratings = {"table": 2, "corpus": str(contents.provenance["corpus_hash"])}
        found["table-2.csv"] = rated.render(contents.table_2, "csv", ratings)
        found["table-2.tex"] = rated.render(contents.table_2, "latex", ratings)
    if contents.plans:
        rows = [row for plans in contents.plans for row in _rows(plans)]
        found["table-3.csv"] = delimited(rows, {}, columns=PLAN_COLUMNS)
        found["table-3.tex"] = "\n\n".join(map(_latex, contents.plans))
        compared = [
            {"table": plans.name, "judge": judge, **msgspec.to_builtins(c)}
            for plans in contents.plans
            for judge, several in (
                ("automatic", plans.file.comparisons),
                ("people", plans.file.people_compared),
            )
            for c in several
        ]
        found["table-3-comparisons.csv"] = delimited(
            compared, {}, columns=("table", "judge", "subset", "verdict", *COMPARISON_COLUMNS)
        )
    return found


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
        made["table_2"] = json.loads(rated.render(contents.table_2, "json", {}))
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
