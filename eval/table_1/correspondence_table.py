"""Table 1 as text: a table to read, JSON, CSV or LaTeX."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

from rich.table import Table

from corpus_tools.corpus.estimate import Estimate, explained
from corpus_tools.runtime.text_tables import figure_table
from eval.statistics.estimates import FEWEST_BESIDE, FIGURES, NO_PAPER, beside
from eval.table_1.correspondence import PAPER_SOURCE, PAPER_TABLE_1, Row
from eval.table_1.given_predictions import OURS, ComparedType
from eval.tables.comparison_report import comparison_table, records
from eval.tables.formats import (
    FORMATS,
    Format,
    comments,
    delimited,
    document,
    figure,
    interval,
    left_out,
    table_text,
)
from eval.tables.latex import RULE, estimate, tabular

HEADINGS = ("Precision", "Recall", "F-score", "Accuracy")
COUNTS = ("n", "positives", "commands", "scenarios")
COLUMNS = (
    "type",
    *FIGURES,
    *COUNTS,
    *(f"{name}_{part}" for name in FIGURES for part in ("low", "high", "reason", "left_out")),
    *(f"paper_{name}" for name in FIGURES),
)
"""Columns of the CSV; with several models their name comes first."""
COMPARED = (
    "compared on the same examples: p is of no difference, by McNemar's test for pairs in "
    "clusters, which are scenarios, exact where fewer than 10 of these differ, with Holm's "
    "correction in each list; h is Cohen's effect size"
)


def render(
    rows: Sequence[Row],
    format: Format,  # noqa: A002 - the name of the option
    metadata: Mapping[str, object],
    *,
    others: Mapping[str, Sequence[Row]] = MappingProxyType({}),
    compared: Sequence[ComparedType] = (),
    terminal: bool = False,
) -> str:
    """Render Table 1 in one of the formats, with the paper's figures unless it is authored.

    Parameters
    ----------
    format
        ``table`` to read, ``json``, ``csv`` (metadata as columns that repeat, so that
        files of several runs can be put together) or ``latex`` (a tabular for booktabs).
    metadata
        Metadata to record with the figures: corpus, model, seeds. In JSON they stand at the top
        level. ``is_authored`` is true of an authored corpus.
    others
        The rows of other models by name, on the same examples.
    compared
        Comparisons of these models with the model and with each other.
    terminal
        True if the table goes to a terminal: colours and Unicode lines, else pure ASCII.

    Raises
    ------
    ValueError
        If a key of the metadata is also the name of a column, or no such format exists.
    """
    models = {OURS: rows, **others} if others else {"": rows}
    is_authored = bool(metadata.get("is_authored"))
    if format == "text":
        return _text(models, compared, metadata, terminal=terminal)
    if format == "json":
        return document(_content(rows, others, compared, is_authored), metadata)
    if format == "csv":
        named = [
            {"model": name, **_flat(row, is_authored)}
            for name, rows_of_model in models.items()
            for row in rows_of_model
        ]
        columns = ("model", *COLUMNS) if others else COLUMNS
        return delimited(named, metadata, columns=columns)
    if format == "latex":
        return "\n\n".join(
            _latex(rows_of_model, metadata, name) for name, rows_of_model in models.items()
        )
    raise ValueError(f"{format!r} is no format, expected one of {', '.join(FORMATS)}")


def _figures(row: Row) -> dict[str, object]:
    record: dict[str, object] = {"type": row.type}
    estimates: dict[str, Estimate] = {name: getattr(row, name) for name in FIGURES}
    record |= {name: one.value for name, one in estimates.items()}
    record |= {name: getattr(row, name) for name in COUNTS}
    for name, one in estimates.items():
        record |= {f"{name}_{part}": value for part, value in one._asdict().items()}
        del record[f"{name}_value"]
    return record


def paper_figures(row: Row, is_authored: bool) -> dict[str, float | None]:
    """Return the paper's figures beside a row."""
    papers = PAPER_TABLE_1[row.type]._asdict().items()
    return {name: beside(one, row.n, is_authored=is_authored) for name, one in papers}


def _nested(row: Row, is_authored: bool) -> dict[str, object]:
    return _figures(row) | {"paper": paper_figures(row, is_authored) | {"source": PAPER_SOURCE}}


def _flat(row: Row, is_authored: bool) -> dict[str, object]:
    papers = paper_figures(row, is_authored).items()
    return _figures(row) | {f"paper_{name}": value for name, value in papers}


def _content(
    rows: Sequence[Row],
    others: Mapping[str, Sequence[Row]],
    compared: Sequence[ComparedType],
    is_authored: bool,
) -> dict[str, object]:
    content: dict[str, object] = {"rows": [_nested(row, is_authored) for row in rows]}
    if others:
        content["others"] = {
            name: [_nested(row, is_authored) for row in rows_of_model]
            for name, rows_of_model in others.items()
        }
        content["comparisons"] = [
            {"type": c.type, **record} for c in compared for record in records(c.comparisons)
        ]
    return content


def _text(
    models: Mapping[str, Sequence[Row]],
    compared: Sequence[ComparedType],
    metadata: Mapping[str, object],
    *,
    terminal: bool,
) -> str:
    title = "Performance at predicting the correspondence variable"
    is_authored = bool(metadata.get("is_authored"))
    papers = f"paper: {PAPER_SOURCE}, on its own corpus; none where n < {FEWEST_BESIDE}"
    tables = {
        f"{title}: {name}" if name else title: _table(rows, is_authored, terminal=terminal)
        for name, rows in models.items()
    }
    tables |= {f"Accuracy compared, {c.type}": comparison_table(c.comparisons) for c in compared}
    notes = [
        "95%: percentile interval of a bootstrap over clusters of examples",
        *explained(_estimates(models).values()),
        *left_out(_estimates(models), metadata.get("draws", "the")),
        NO_PAPER if is_authored else papers,
        *([COMPARED] if compared else []),
    ]
    return table_text(tables, notes, metadata, terminal=terminal)


def _estimates(models: Mapping[str, Sequence[Row]]) -> dict[str, Estimate]:
    """Return all figures, by description."""
    return {
        f"{model} {name} of {row.type}".strip(): getattr(row, name)
        for model, rows in models.items()
        for row in rows
        for name in FIGURES
    }


def _table(rows: Sequence[Row], is_authored: bool, *, terminal: bool) -> Table:
    table = figure_table(("Type", *HEADINGS, "n", "True", "Commands"))
    for row in rows:
        estimates: list[Estimate] = [getattr(row, name) for name in FIGURES]
        between = "{:.2f}–{:.2f}" if terminal else "{:.2f}-{:.2f}"
        name = row.type.capitalize() if row.type == "overall" else row.type
        counts = (str(row.n), str(row.positives), str(row.commands))
        table.add_row(name, *(figure(e.value) for e in estimates), *counts, style="bold")
        bounds = (interval(e, between) for e in estimates)
        table.add_row("  95%", *bounds, end_section=is_authored)
        if not is_authored:
            paper = map(figure, paper_figures(row, is_authored).values())
            table.add_row("  paper", *paper, style="dim", end_section=True)
    return table


def _latex(rows: Sequence[Row], metadata: Mapping[str, object], model: str) -> str:
    cells: list[tuple[str, ...]] = []
    is_authored = bool(metadata.get("is_authored"))
    for row in rows:
        estimates: list[Estimate] = [getattr(row, name) for name in FIGURES]
        if row.type == "overall":
            cells.append(RULE)
        name = row.type.capitalize() if row.type == "overall" else row.type
        cells.append((name, *map(estimate, estimates), str(row.n)))
        if not is_authored:
            paper = map(figure, paper_figures(row, is_authored).values())
            cells.append((r"\quad paper$^\dagger$", *paper, ""))
    about = comments(metadata)
    about += [] if is_authored else [f"Rows marked with a dagger: {PAPER_SOURCE}."]
    about += [f"Model: {model}."] if model else []
    about += explained(_estimates({model: rows}).values())
    return tabular(("SDC type", *HEADINGS, "$n$"), cells, comments=about)
