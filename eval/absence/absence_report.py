"""A table of how often it is seen that something isn't there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
from rich.table import Table

from corpus_tools.corpus.estimate import Estimate, explained, named, part, undefined
from eval.absence.absence_evidence import AbsenceEvidence
from eval.tables.formats import document, figure_table, table_text
from g3.language.similarity.learned_lexicon import likeness_identity
from g3.language.similarity.presence import least_alike

FALSE_ALARMS = 0.05
"""The share of false alarms at which corpora are compared."""
LISTED = 10


def figures(evidence: AbsenceEvidence, threshold: float | None = None) -> dict[str, Any]:
    """What share of commands alarms at a threshold, by what there is to be seen.

    What is less present is absent. If it is left out, the threshold is the largest that alarms
    wrongly for at most `FALSE_ALARMS` of the commands.
    """
    own = np.array(evidence.own)
    known = Estimate(threshold) if threshold is not None else _largest(own)
    shares = {
        name: part(int((np.array(values) < known.value).sum()), len(values), "no data")
        if known.is_known
        else known
        for name, values in (
            ("false_alarms", evidence.own),
            ("seen_removed", evidence.removed),
            ("seen_any_noun", evidence.any_noun),
        )
    }
    return named({"threshold": known, **shares})


def _largest(own: np.ndarray[Any, np.dtype[np.float64]]) -> Estimate:
    if not len(own):
        return undefined("no data")
    steps = np.unique(own[own <= 1])
    allowed = [float(step) for step in steps if np.mean(own < step) <= FALSE_ALARMS]
    return Estimate(max(allowed, default=0.0))


def render(
    evidence: Sequence[AbsenceEvidence],
    form: Literal["text", "json"],
    metadata: Mapping[str, object],
    *,
    terminal: bool = False,
) -> str:
    """The figures of each corpus, at the shipped threshold and at `FALSE_ALARMS`."""
    known = {**metadata, "likeness": likeness_identity(), "threshold": least_alike()}
    rows: list[dict[str, Any]] = [
        {
            "corpus": one.corpus,
            "commands": len(one.own),
            "removals": len(one.removed),
            "shipped": figures(one, least_alike()),
            "at_5_percent": figures(one),
            "false_alarms": [
                {"noun": noun, "naming": value}
                for noun, value in one.alarms
                if value < least_alike()
            ],
        }
        for one in evidence
    ]
    if form == "json":
        return document({"rows": rows}, known)
    tables = {
        f"Alarms below {least_alike():g}": _table(rows, "shipped"),
        f"Alarms at {FALSE_ALARMS:.0%} false ones": _table(rows, "at_5_percent"),
    }
    notes = explained(
        field
        for row in rows
        for which in ("shipped", "at_5_percent")
        for field in row[which].values()
    )
    for row in rows:
        nouns = dict.fromkeys(alarm["noun"] for alarm in row["false_alarms"])
        if nouns:
            notes.append(f"false alarms in {row['corpus']}: {', '.join(list(nouns)[:LISTED])}")
    return table_text(tables, notes, known, terminal=terminal)


def _table(rows: Sequence[Mapping[str, Any]], which: str) -> Table:
    def shown(row: Mapping[str, Any], name: str) -> str:
        return row[which][f"{name}_reason"] or f"{row[which][name]:.3f}"

    cells = (
        (
            f"{row['corpus']} ({row['commands']})",
            shown(row, "threshold"),
            shown(row, "false_alarms"),
            f"{shown(row, 'seen_removed')} of {row['removals']}",
            shown(row, "seen_any_noun"),
        )
        for row in rows
    )
    return figure_table(("", "Threshold", "False alarms", "What was removed", "Any noun"), cells)
