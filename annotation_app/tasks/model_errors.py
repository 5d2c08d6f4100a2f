"""Errors of the models that proposed steps in a study (:mod:`corpus_tools.episodes.step_errors`).

Answers of people who saw no proposal are compared with it too, and reported apart: people who
correct a proposal tend to keep it.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import IO

import msgspec
from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.people.participants import subject_of
from annotation_app.store.models import Answer, Item, Person, Study, TaskName
from annotation_app.tasks.agreement import Measured, ModelErrors
from annotation_app.tasks.task_record import AnswerTable, write_csv
from corpus_tools.episodes.step_errors import ADDED, StepFate, errors_by_model


def model_errors(session: Session, study: Study) -> list[ModelErrors]:
    """Return the errors of each model, first against people who saw its proposals."""
    return [
        ModelErrors(
            TASK,
            one.model,
            "shown" if one.proposal == "shown" else "not shown",
            one.episodes,
            one.answers,
            one.steps,
            one.undecided,
            tuple(
                Measured(
                    m.measure, m.value, one.episodes, reason=m.reason, low=m.low, high=m.high,
                    items=one.episodes,
                )
                for m in one.measures
            ),
        )
        for one in errors_by_model(_fates(session, study))
    ]  # fmt: skip


def _fates(session: Session, study: Study) -> Iterator[tuple[str, bool, StepFate]]:
    for answer, item, _ in _compared(session, study):
        provenance = answer.provenance or {}
        fates = provenance["fates"]
        about = fates["source"], provenance["suggestion"] == "shown"
        for step in fates["steps"]:
            yield (
                *about,
                StepFate(
                    item.id, str(answer.id), step["state"], step["decided"], step.get("moved_s"),
                    step.get("text_distance", 0.0),
                ),
            )  # fmt: skip
        for _ in fates["added"]:
            yield (*about, StepFate(item.id, str(answer.id), ADDED))


def _compared(session: Session, study: Study) -> Iterator[tuple[Answer, Item, Person]]:
    """Yield the answers that are compared with proposals."""
    rows = session.execute(
        select(Answer, Item, Person)
        .join(Item, Item.id == Answer.item_id)
        .join(Person, Person.id == Answer.person_id)
        .where(
            Item.study_id == study.id,
            Item.task == TASK,
            Item.attention.is_(False),
            Answer.excluded.is_(False),
        )
        .order_by(Answer.id)
        .execution_options(yield_per=500)
    )
    for answer, item, person in rows:
        if (answer.provenance or {}).get("fates"):
            yield answer, item, person


TASK: TaskName = "subtasks"


def errors_to_csv(session: Session, study: Study, file: IO[bytes]) -> None:
    """Write a row for each model, group of answers and measure."""
    columns = (
        "study", "model", "proposal", "episodes", "answers", "steps", "undecided", "measure",
        "value", "low", "high", "reason",
    )  # fmt: skip
    rows = (
        (
            *(study.name, row.source, row.proposal, row.items, row.answers, row.parts),
            *(row.undecided, one.measure, one.value, one.low, one.high, one.reason),
        )
        for row in model_errors(session, study)
        for one in row.measures
    )
    write_csv(file, columns, rows)


def errors_to_json(session: Session, study: Study, file: IO[bytes]) -> None:
    """Write the same as JSON."""
    content = {"study": study.name, "models": model_errors(session, study)}
    file.write(msgspec.json.format(msgspec.json.encode(content)) + b"\n")


def steps_to_csv(session: Session, study: Study, file: IO[bytes]) -> None:
    """Write a row for each proposed step in each answer, and for each step that was added."""
    columns = (
        "answer", "video", "subject", "model", "suggestion", "state", "decided", "proposed_s",
        "proposed", "start_s", "text", "moved_s", "text_distance",
    )  # fmt: skip
    write_csv(file, columns, _step_rows(session, study))


def _step_rows(session: Session, study: Study) -> Iterator[tuple[object, ...]]:
    for answer, item, person in _compared(session, study):
        provenance, steps = answer.provenance or {}, answer.body["subtasks"]
        fates = provenance["fates"]
        about = (
            *(answer.id, item.payload["video"], subject_of(person)),
            *(fates["source"], provenance["suggestion"]),
        )
        for fate in fates["steps"]:
            kept = steps[fate["step"]] if fate["step"] is not None else {}
            yield (
                *about, fate["state"], fate["decided"], round(fate["start_s"], 3), fate["text"],
                kept.get("start_s"), kept.get("text"), fate.get("moved_s"),
                fate.get("text_distance"),
            )  # fmt: skip
        for number in fates["added"]:
            step = steps[number]
            yield (*about, ADDED, True, None, None, step["start_s"], step["text"], None, None)


TABLES = {
    "model-errors.csv": AnswerTable(
        "Errors of models (CSV)",
        "text/csv",
        errors_to_csv,
        "of models that proposed steps: how often people changed them",
    ),
    "model-errors.json": AnswerTable(
        "Errors of models (JSON)", "application/json", errors_to_json, "the same"
    ),
    "proposed-steps.csv": AnswerTable(
        "Proposed steps (CSV)", "text/csv", steps_to_csv, "a row for each, and what became of it"
    ),
}
"""Files about the models that proposed steps."""
