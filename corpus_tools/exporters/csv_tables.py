"""A corpus as tables: the items of its lists are rows."""

from __future__ import annotations

import csv
import io
import unicodedata
from collections.abc import Iterable, Sequence
from typing import TextIO

from corpus_tools.corpus.corpus_model import Corpus
from g3.groundings import Grounding, PhysicalObject, Place
from g3.sdc.clauses import all_words, breadth_first

_FORMULA = "=+-@−"
"""Beginnings of formulas, also in their full-width and small forms (＝, ﹦)."""
_BEFORE = "".join(
    map(chr, (*range(0x21), 0x7F, 0x85, 0xA0, 0xAD, 0xFEFF, *range(0x2000, 0x2010), 0x3000))
)
"""Spaces and invisible characters that spreadsheets skip before a formula."""


def csv_files(corpus: Corpus) -> dict[str, bytes]:
    """Commands, clauses, objects, judgments and outcomes, each with a header.

    A clause is in a row of its own for each annotation that it is in, with its number breadth
    first. Objects are where they are at first. Lengths are in metres, angles in radians.
    """
    tables: dict[str, tuple[Sequence[str], Iterable[Sequence[object]]]] = {
        "commands": (
            ("id", "text", "scenario", "video", "subject"),
            ((c.id, c.text, c.scenario, c.video, c.subject) for c in corpus.commands.values()),
        ),
        "clauses": (
            ("annotation", "command", "context", "source", "clause", "type", "words", "groundings",
             "correct"),
            _clauses(corpus),
        ),
        "objects": (
            ("context", "id", "labels", "is_robot", "x", "y", "z", "yaw", "poses"),
            (
                (context.id, item.id, " ".join(item.labels), item.id == context.agent_id,
                 *item.trajectory.xyz[0].tolist(), float(item.trajectory.yaw[0]),
                 len(item.trajectory))
                for context in corpus.contexts.values()
                for item in context.objects
            ),
        ),
        "judgments": (
            ("id", "command", "command_video", "shown_video", "rating", "subject", "study"),
            ((j.id, j.command, j.command_video, j.shown_video, j.rating, j.subject, j.study)
             for j in corpus.judgments),
        ),
        "outcomes": (
            ("id", "scenario", "context", "command", "video", "picked", "put", "on", "unknown"),
            ((o.id, o.scenario, o.context, o.command, o.video, " ".join(o.picked), o.put,
              " ".join(o.on), " ".join(o.unknown)) for o in corpus.outcomes),
        ),
    }  # fmt: skip
    return {f"{name}.csv": _table(*table) for name, table in tables.items()}


def safe_cell(value: object) -> object:
    """Return a value that spreadsheets take for text if it is text.

    A quotation mark before it keeps them from running what looks like a formula.

    >>> safe_cell("＝HYPERLINK(A1)")
    "'＝HYPERLINK(A1)"
    """
    if not isinstance(value, str) or not value:
        return value
    first = unicodedata.normalize("NFKC", value.lstrip(_BEFORE)[:1])
    return f"'{value}" if value[0] in "\t\r\n" or (first and first in _FORMULA) else value


def write_rows(
    text: TextIO,
    header: Sequence[str],
    rows: Iterable[Iterable[object]],
    *,
    line_end: str = "\r\n",
) -> None:
    """Write a header and rows as CSV: the one way in which all exports do, by :func:`safe_cell`."""
    writer = csv.writer(text, lineterminator=line_end)
    writer.writerow(header)
    writer.writerows(map(safe_cell, row) for row in rows)


def _clauses(corpus: Corpus) -> Iterable[Sequence[object]]:
    for annotation in corpus.annotations:
        rows = zip(
            breadth_first(annotation.sdcs), annotation.groundings, annotation.correct, strict=True
        )
        for node, (sdc, groundings, correct) in enumerate(rows):
            label = "" if correct is None else "right" if correct else "wrong"
            yield (
                annotation.id, annotation.command.id, annotation.context.id, annotation.source,
                node, sdc.type, " ".join(word.text for word in all_words(sdc)),
                "; ".join(map(_named, groundings)), label,
            )  # fmt: skip


def _named(grounding: Grounding) -> str:
    if isinstance(grounding, PhysicalObject):
        return grounding.id
    if isinstance(grounding, Place):
        x, y = grounding.prism.xy.mean(axis=0).tolist()
        return grounding.name or f"place at {x:.2f} {y:.2f}"
    path = grounding.trajectory
    return f"path from {path.t[0]:.2f} to {path.t[-1]:.2f} s"


def _table(header: Sequence[str], rows: Iterable[Sequence[object]]) -> bytes:
    text = io.StringIO()
    write_rows(text, header, rows)
    return text.getvalue().encode()
