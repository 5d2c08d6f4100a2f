"""All answers of a study as tables, for other programs."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from functools import partial
from itertools import islice
from typing import IO

import msgspec
from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.items.elapsed import iso
from annotation_app.items.item_scenes import films_of
from annotation_app.items.replaced_videos import video_digests
from annotation_app.people.participants import platform_knowledge, subject_of
from annotation_app.people.person_names import anonymous_name
from annotation_app.store.models import Answer, Event, Item, Person, Record, Remark, Study
from annotation_app.studies.study_file import restored
from annotation_app.tasks.task_record import AnswerTable, write_csv
from annotation_app.tasks.task_registry import tasks
from annotation_app.work.answer_flags import answer_flags
from corpus_tools.runtime.parquet import import_pyarrow

FIELDS = (
    "answer", "task", "item", "video", "command", "subject", "surplus", "adopted", "attention",
    "at", "seconds", "suggestion", "unchanged", "likeness", "flags", "body", "metadata", "excluded",
    "reason", "video_sha256", "platform", "person",
)  # fmt: skip


BATCH = 500
"""Number of answers in memory at a time."""
ROW_GROUP = 10_000
"""Number of rows of a Parquet file that are compressed together."""


def to_jsonl(session: Session, study: Study, file: IO[bytes], *, excluded: bool = False) -> None:
    """Write a line of JSON for each answer."""
    encode = msgspec.json.Encoder().encode
    for row in rows(session, study, excluded=excluded):
        file.write(encode(row) + b"\n")


def to_csv(session: Session, study: Study, file: IO[bytes], *, excluded: bool = False) -> None:
    """Write a row for each answer, its body as JSON; no cell is taken for a formula."""
    write_csv(file, FIELDS, (_flat(r).values() for r in rows(session, study, excluded=excluded)))


def to_parquet(session: Session, study: Study, file: IO[bytes], *, excluded: bool = False) -> None:
    """Write a row for each answer, its body as JSON; a FormatError without pyarrow."""
    pa, pq = import_pyarrow()
    types = {"answer": pa.int64(), **dict.fromkeys(("seconds", "likeness"), pa.float64())}
    names = ("surplus", "adopted", "attention", "unchanged", "excluded")
    types |= dict.fromkeys(names, pa.bool_())
    schema = pa.schema([(name, types.get(name, pa.string())) for name in FIELDS])
    listed = map(_flat, rows(session, study, excluded=excluded))
    with pq.ParquetWriter(file, schema) as writer:
        while some := list(islice(listed, ROW_GROUP)):
            writer.write_table(pa.Table.from_pylist(some, schema=schema))


def reports_to_csv(session: Session, study: Study, file: IO[bytes]) -> None:
    """Write a row for each reported problem and each skipped item."""
    found = session.execute(
        select(Event, Item, Person)
        .join(Item, Item.id == Event.item_id)
        .join(Person, Person.id == Event.person_id)
        .where(Item.study_id == study.id, Event.name.in_(("flag", "skip")))
        .order_by(Event.id)
        .execution_options(yield_per=BATCH)
    )
    columns = ("kind", "task", "item", "video", "command", "subject", "at", "reason", "person")
    listed = (
        (
            *(event.name, item.task, item.id, item.video, item.command, subject_of(person)),
            *(iso(event.at), event.body.get("reason", ""), anonymous_name(person)),
        )
        for event, item, person in found
    )
    write_csv(file, columns, listed)


OF_ALL_TASKS: Mapping[str, AnswerTable] = {
    "csv": AnswerTable("Answers (CSV)", "text/csv", to_csv, "a row for each answer, for sheets;"),
    "jsonl": AnswerTable(
        "Answers (JSONL)", "application/x-ndjson", to_jsonl, "the same, for programs;"
    ),
    "parquet": AnswerTable(
        "Answers (Parquet)",
        "application/vnd.apache.parquet",
        to_parquet,
        "the same, smallest;",
    ),
    "reports.csv": AnswerTable(
        "Reports and skips (CSV)", "text/csv", reports_to_csv, "reported problems, skipped items"
    ),
}
TABLES: Mapping[str, AnswerTable] = {
    **OF_ALL_TASKS,
    **{name: table for task in tasks() for name, table in task.tables.items()},
}
"""Formats of the tables that can be written to one file."""
WITH_EXCLUDED: Mapping[str, Callable[[Session, Study, IO[bytes]], None]] = {
    "csv": partial(to_csv, excluded=True),
    "jsonl": partial(to_jsonl, excluded=True),
    "parquet": partial(to_parquet, excluded=True),
}
"""Writers of the tables that include excluded answers, and the reasons."""


def tables_of(session: Session, study: Study) -> dict[str, AnswerTable]:
    """Return the tables that a study can fill: those of its tasks, also of earlier ones."""
    there = session.scalars(select(Item.task).where(Item.study_id == study.id).distinct())
    names = {*restored(study.config).tasks, *there}
    of_tasks = (task.tables for task in tasks() if task.name in names)
    return {**OF_ALL_TASKS, **{name: table for found in of_tasks for name, table in found.items()}}


def file_name(study: str, form: str, *, excluded: bool = False) -> str:
    """Return the name of an exported file, which says what it holds."""
    what, _, ending = form.rpartition(".")
    with_excluded = "-with-excluded" if excluded and form in WITH_EXCLUDED else ""
    return f"{study}-{what or 'answers'}{with_excluded}.{ending}"


def _flat(row: Record) -> Record:
    return row | {name: msgspec.json.encode(row[name]).decode() for name in ("body", "metadata")}


def chosen_to_csv(
    session: Session, study: Study, file: IO[bytes], answers: Collection[int]
) -> None:
    """Write a row for each of some answers, by their ids, as :func:`to_csv` does."""
    found = rows(session, study, excluded=True, only=answers)
    write_csv(file, FIELDS, (_flat(row).values() for row in found))


def rows(
    session: Session,
    study: Study,
    *,
    excluded: bool = False,
    only: Collection[int] | None = None,
) -> Iterator[Record]:
    """Yield the answers as they came, with fields `FIELDS`; if wanted also excluded ones.

    `only` has the ids of those that are wanted; None for all.

    A few are in memory at a time. PostgreSQL can do so within a transaction only:
    ``reading(engine, one_state=True)``.
    """
    reasons = _reasons(session, study) if excluded else {}
    films = films_of(session, study.id)
    digests = video_digests(session, study.id)
    knowledge = platform_knowledge(session, study.id)
    found = session.execute(
        select(Answer, Item, Person)
        .join(Item, Item.id == Answer.item_id)
        .join(Person, Person.id == Answer.person_id)
        .where(
            Item.study_id == study.id,
            *(() if excluded else (Answer.excluded.is_(False),)),
            *(() if only is None else (Answer.id.in_(only),)),
        )
        .order_by(Answer.id)
        .execution_options(yield_per=BATCH)
    )
    for answer, item, person in found:
        provenance = answer.provenance or {}
        flags = answer_flags(item.payload, answer.body, answer.provenance, answer.seconds)
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
            "at": iso(answer.at),
            "seconds": answer.seconds,
            "suggestion": provenance.get("suggestion", ""),
            "unchanged": provenance.get("unchanged"),
            "likeness": provenance.get("likeness"),
            "flags": "; ".join(flags),
            "body": answer.body,
            "metadata": films[video].metadata if (video := item.payload["video"]) in films else {},
            "excluded": answer.excluded,
            "reason": reasons.get(answer.id, "") if answer.excluded else "",
            "video_sha256": digests.get(item.payload["video"], ""),
            "platform": knowledge.get(person.id, ""),
            "person": anonymous_name(person),
        }


def _reasons(session: Session, study: Study) -> dict[int, str]:
    """Return the reasons why answers were last excluded, by their ids."""
    found = session.execute(
        select(Remark.answer_id, Remark.text)
        .join(Answer, Answer.id == Remark.answer_id)
        .join(Item, Item.id == Answer.item_id)
        .where(Item.study_id == study.id, Remark.kind.in_(("excluded", "had redone")))
        .order_by(Remark.id)
    )
    return {one.answer_id: one.text for one in found}
