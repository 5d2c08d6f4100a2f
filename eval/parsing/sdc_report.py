"""The figures of extraction as text: a table to read, or JSON."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from rich.table import Table

from corpus_tools.corpus.estimate import explained, named, part
from eval.parsing.sdc_scores import AS_TYPED, FIELDS, NOWHERE, Counts, TestedCommand
from eval.tables.formats import cell, document, figure_table, table_text
from g3.sdc.clauses import SDC_TYPES
from g3.sdc.sdc_notation import format_brackets
from g3.storage.text_lines import split_lines

FIGURES = ("precision", "recall", "f")


def figures(tested: Sequence[TestedCommand]) -> dict[str, Any]:
    """Return the figures over all commands, by name."""
    comparisons = [one.comparison for one in tested]
    typed = sum((c.typed for c in comparisons), Counts())
    untyped = sum((c.untyped for c in comparisons), Counts())
    segments = sum((c.segments for c in comparisons), Counts())
    by_type = {type_: sum((c.by_type[type_] for c in comparisons), Counts()) for type_ in SDC_TYPES}
    result: dict[str, Any] = {}
    for name, counts in (("typed", typed), ("untyped", untyped), ("segmentation", segments)):
        result |= named({f"{name}_{figure}": getattr(counts, figure) for figure in FIGURES})
    exact = part(sum(c.exact for c in comparisons), len(comparisons), "no data")
    return result | {
        **named({"exact": exact}),
        "commands": len(comparisons),
        "constituents": typed.gold,
        "types": {
            type_: named({figure: getattr(counts, figure) for figure in FIGURES})
            | {"n": counts.gold}
            for type_, counts in by_type.items()
        },
    }


def confusion(tested: Sequence[TestedCommand]) -> dict[str, dict[str, int]]:
    """Count letters by annotated and by predicted type and field."""
    total: Counter[tuple[str, str]] = sum((t.comparison.confusion for t in tested), Counter())
    return {
        gold: {to: total[gold, to] for to in (*FIELDS, NOWHERE) if total[gold, to]}
        for gold in (*FIELDS, NOWHERE)
        if any(total[gold, to] for to in (*FIELDS, NOWHERE))
    }


def errors(tested: Sequence[TestedCommand]) -> list[dict[str, object]]:
    """List the commands with inexact trees, those that share least first."""

    def order(one: TestedCommand) -> tuple[float, str]:
        # Trees without words on either side have no F, and nothing in common.
        result = one.comparison.typed.f
        return result.value if result.is_known else 0.0, one.annotated.command.id

    wrong = sorted((one for one in tested if not one.comparison.exact), key=order)
    return [
        {
            "command": one.annotated.command.id,
            "text": one.annotated.command.text,
            **named({"typed_f": one.comparison.typed.f}),
            "gold": format_brackets(one.annotated.sdcs),
            "predicted": format_brackets(one.parse.sdcs),
        }
        for one in wrong
    ]


def render(
    by_kind: Mapping[str, Sequence[TestedCommand]],
    form: Literal["text", "json"],
    metadata: Mapping[str, object],
    *,
    top: int,
    terminal: bool,
) -> str:
    """Render all figures of the tested commands.

    Parameters
    ----------
    by_kind
        The tested commands as typed, and by perturbation.
    top
        Number of errors in a table; JSON has all.
    """
    tested = by_kind[AS_TYPED]
    result = figures(tested)
    wrong = errors(tested)
    perturbed = {kind: figures(own) for kind, own in by_kind.items() if kind != AS_TYPED}
    if form == "json":
        content = {**result, "confusion": confusion(tested), "errors": wrong}
        content |= {"perturbed": perturbed} if perturbed else {}
        return document(content, metadata)
    tables = {
        "Extraction of SDCs from text": _figures_table(result),
        **(
            {"The same commands perturbed": _perturbed_table(result, perturbed)}
            if perturbed
            else {}
        ),
        "Letters by annotated (rows) and extracted type and field": _confusion_table(tested),
        f"Worst errors ({min(top, len(wrong))} of {len(wrong)})": _errors_table(wrong[:top]),
    }
    records = (result, *result["types"].values(), *perturbed.values())
    reasons = explained(field for record in records for field in record.values())
    notes = (f"exact trees: {_shown(result, 'exact')} of {result['commands']} commands", *reasons)
    return table_text(tables, notes, metadata, terminal=terminal)


def _figures_table(record: Mapping[str, Any]) -> Table:
    table = figure_table(("", "Precision", "Recall", "F-score"))
    for name in ("typed", "untyped", "segmentation"):
        cells = (_shown(record, f"{name}_{figure}") for figure in FIGURES)
        table.add_row(name.capitalize(), *cells)
    for type_, of_type in record["types"].items():
        table.add_row(type_, *(_shown(of_type, figure) for figure in FIGURES))
    return table


def _shown(record: Mapping[str, Any], name: str) -> str:
    """Return a figure of a record, or the reason for its absence."""
    return str(record[f"{name}_reason"]) or f"{record[name]:.3f}"


def _perturbed_table(
    record: Mapping[str, object], perturbed: Mapping[str, Mapping[str, object]]
) -> Table:
    names = ("typed_f", "untyped_f", "segmentation_f", "exact")
    rows = (
        (kind, *(_shown(own, name) for name in names))
        for kind, own in {"as typed": record, **perturbed}.items()
    )
    return figure_table(("", *(name.removesuffix("_f").capitalize() for name in names)), rows)


def _confusion_table(tested: Sequence[TestedCommand]) -> Table:
    rows = confusion(tested)
    columns = [name for name in (*FIELDS, NOWHERE) if any(name in row for row in rows.values())]
    cells = ((name, *(str(row.get(c, "")) for c in columns)) for name, row in rows.items())
    return figure_table(("", *columns), cells)


def _errors_table(wrong: Sequence[Mapping[str, object]]) -> Table:
    table = Table(show_header=False)
    for error in wrong:
        table.add_row(cell(error["command"]), cell(error["text"]))
        for name in ("gold", "predicted"):
            for line in split_lines(str(error[name])):
                table.add_row(name, cell(line))
        table.add_row("", "")
    return table
