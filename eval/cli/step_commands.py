"""``ct eval subtasks``: models that cut episodes into steps, against people."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from corpus_tools.options import OUT, ExistingPath, format_option
from eval.cli.modes import is_terminal, write

if TYPE_CHECKING:
    from collections.abc import Sequence

    from corpus_tools.episodes.step_errors import StepErrors, StepFate, StepMeasure
    from corpus_tools.tables.table_reading import Row

COLUMNS = ("answer", "video", "model", "suggestion", "state")
"""Columns that the table needs."""


@click.command(
    "subtasks",
    short_help="Measure models' steps by people's corrections.",
    epilog="\b\nExamples:\n"
    "  ct annotate export steps.csv --format proposed-steps.csv\n"
    "  ct eval subtasks steps.csv\n"
    "  ct eval subtasks steps.csv --json",
)
@click.argument(
    "path", type=ExistingPath("`ct annotate export --format proposed-steps.csv` makes it")
)
@format_option(about="For people, or for programs.")
@OUT
def subtasks(*, path: Path, form: Literal["text", "json"], out: Path | None) -> None:
    """Show how often people kept the steps that each model proposed for episodes.

    PATH is the table proposed-steps.csv of a study's export. The figures are those of its
    dashboard: shares of the steps, the distance of texts, and how far beginnings were moved, with
    95 % intervals by a bootstrap over episodes.
    """
    from corpus_tools.episodes.step_errors import errors_by_model
    from corpus_tools.tables.table_reading import read_table
    from eval.tables.formats import document
    from g3.errors import FormatError

    errors = errors_by_model(_fate(row) for row in read_table(path, COLUMNS))
    if not errors:
        fix = "export it when people have corrected proposed steps"
        raise FormatError("the table has no steps", where=str(path), fix=fix)
    if form == "json":
        import msgspec

        write(document({"models": msgspec.to_builtins(errors)}, {"steps": str(path)}), out)
    else:
        write(_text(errors, path, terminal=is_terminal(out)), out)


def _fate(row: Row) -> tuple[str, bool, StepFate]:
    from corpus_tools.episodes.step_errors import ADDED, STATES, StepFate
    from g3.errors import FormatError

    def number(column: str) -> float | None:
        text = row.text(column).strip()
        try:
            value = float(text) if text else None
        except ValueError:
            value = float("nan")
        if value is not None and not abs(value) < float("inf"):
            fix = "export the table again"
            raise FormatError(f"{text!r:.40} is no number", where=row.where(column), fix=fix)
        return value

    state = row.text("state")
    if state not in (*STATES, ADDED):
        fix = f"the states are: {'; '.join((*STATES, ADDED))}"
        raise FormatError(f"{state!r:.40} is no state", where=row.where("state"), fix=fix)
    fate = StepFate(
        row.text("video"),
        row.text("answer"),
        state,
        row.text("decided").lower() != "false",
        number("moved_s"),
        number("text_distance") or 0.0,
    )
    return row.text("model"), row.text("suggestion") == "shown", fate


def _text(errors: Sequence[StepErrors], path: Path, *, terminal: bool) -> str:
    from corpus_tools.corpus.estimate import REASONS
    from corpus_tools.runtime.text_tables import figure_table
    from eval.tables.formats import cell, table_text

    rows = [
        [cell(name), *(cell(getattr(one, name)) for one in errors)]
        for name in ("episodes", "answers", "steps", "undecided")
    ]
    for number, measure in enumerate(errors[0].measures if errors else ()):
        figures = (cell(_figure(one.measures[number])) for one in errors)
        rows.append([cell(measure.measure), *figures])
    headings = ["measure", *(f"{one.model}, {one.proposal}" for one in errors)]
    reasons = dict.fromkeys(m.reason for one in errors for m in one.measures if m.reason)
    notes = [f"{reason}: {REASONS[reason]}" for reason in reasons]
    title = "Steps that models proposed, and what people made of them"
    tables = {title: figure_table(headings, rows)}
    return table_text(tables, notes, {"steps": path.name}, terminal=terminal)


def _figure(measure: StepMeasure) -> str:
    if measure.value is None:
        return "-"
    if measure.low is None or measure.high is None:
        return f"{measure.value:.2f}"
    return f"{measure.value:.2f} ({measure.low:.2f} to {measure.high:.2f})"
