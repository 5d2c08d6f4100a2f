"""All answers of a study as tables, for other programs."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Mapping

import msgspec
from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.items.item_scenes import films_of
from annotation_app.people.participants import subject_of
from annotation_app.store.models import Answer, Item, Person, Record, Study
from annotation_app.tasks.task_record import AnswerTable
from annotation_app.tasks.task_registry import tasks
from g3.errors import FormatError

FIELDS = (
    "answer", "task", "item", "video", "command", "subject", "surplus", "adopted", "attention",
    "at", "seconds", "body", "metadata",
)  # fmt: skip
_FORMULA = ("=", "+", "-", "@", "\t", "\r", "\n")


def to_jsonl(session: Session, study: Study) -> bytes:
    """A line of JSON for each answer."""
    return msgspec.json.Encoder().encode_lines(list(rows(session, study)))


def to_csv(session: Session, study: Study) -> bytes:
    """A row for each answer, its body as JSON; no cell is taken for a formula."""
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerow(FIELDS)
    for row in rows(session, study):
        writer.writerow([safe_cell(_flat(row)[name]) for name in FIELDS])
    return text.getvalue().encode()


def to_parquet(session: Session, study: Study) -> bytes:
    """A table with a row for each answer, its body as JSON.

    Raises
    ------
    FormatError
        If pyarrow isn't installed.
    """
    try:
        import pyarrow as pa  # noqa: PLC0415 - large, and not always installed
        import pyarrow.parquet as pq  # noqa: PLC0415 - as above
    except ImportError as error:
        raise FormatError(
            "Parquet files are written with pyarrow, which isn't installed",
            fix="pip install 'corpus-tools-g3[parquet]'",
        ) from error
    types = {"answer": pa.int64(), "at": pa.float64(), "seconds": pa.float64()}
    types |= dict.fromkeys(("surplus", "adopted", "attention"), pa.bool_())
    schema = pa.schema([(name, types.get(name, pa.string())) for name in FIELDS])
    listed = [_flat(row) for row in rows(session, study)]
    content = io.BytesIO()
    pq.write_table(pa.Table.from_pylist(listed, schema=schema), content)
    return content.getvalue()


TABLES: Mapping[str, AnswerTable] = {
    "csv": AnswerTable("Answers (CSV)", "text/csv", to_csv),
    "jsonl": AnswerTable("Answers (JSONL)", "application/x-ndjson", to_jsonl),
    "parquet": AnswerTable("Answers (Parquet)", "application/vnd.apache.parquet", to_parquet),
    **{name: table for task in tasks() for name, table in task.tables.items()},
}
"""What can be written to one file, by its format."""


def safe_cell(value: object) -> object:
    """A value that spreadsheets take for text if it is text.

    A quotation mark before it keeps them from running what looks like a formula.
    """
    if not isinstance(value, str):
        return value
    return f"'{value}" if value.lstrip(" ").startswith(_FORMULA) else value


def _flat(row: Record) -> Record:
    return row | {name: msgspec.json.encode(row[name]).decode() for name in ("body", "metadata")}


def rows(session: Session, study: Study) -> Iterator[Record]:
    """The answers in the order in which they came, with fields `FIELDS`."""
    films = films_of(session, study.id)
    found = session.execute(
        select(Answer, Item, Person)
        .join(Item, Item.id == Answer.item_id)
        .join(Person, Person.id == Answer.person_id)
        .where(Item.study_id == study.id)
        .order_by(Answer.id)
    )
    for answer, item, person in found:
        yield {
            "answer": answer.id,
            "task": item.task,
            "item": item.id,
            "video": item.payload["video"],
            "command": item.payload.get("text", ""),
            "subject": subject_of(person),
            "surplus": answer.surplus,
            "adopted": answer.adopted,
            "attention": item.attention,
            "at": answer.at,
            "seconds": answer.seconds,
            "body": answer.body,
            "metadata": films[video].metadata if (video := item.payload["video"]) in films else {},
        }
