"""Changes of a study's file, and those that alter items or texts that people have already had."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import msgspec
from sqlalchemy import func, select
from sqlalchemy.orm import Session

from annotation_app.people.participants import has_consented
from annotation_app.store.models import Answer, Item, Person, Study, TaskName
from annotation_app.studies.study_file import StudyConfig
from annotation_app.tasks.task_registry import find_task
from corpus_tools.world.scenarios.documents import Field, field_name

SHOWN = (
    "title", "summary", "prompt", "styles", "drawing", "instructions", "practice_items",
    "suggestions", "suggestions_from", "practice",
)  # fmt: skip
"""Settings of a task that people see or meet before they answer."""
AGREED = ("consent", "questions", "qualification", "payment")
ROBOT = "{robot}"
LOCALE = "locale"
"""The field that alters all that people read."""


@dataclass(frozen=True, slots=True)
class Asked:
    """Numbers of answers so far, by task, and of people who have agreed to take part."""

    answers: Mapping[TaskName, int]
    people: int


@dataclass(frozen=True, slots=True)
class Change:
    """A changed field of the file, with old and new values as text, empty where there is none.

    `alters` names the agreements and answers that it affects.
    """

    field: str
    before: str
    after: str
    alters: str


def asked_so_far(session: Session, study: Study) -> Asked:
    """Return the numbers of answers and of agreements in a study."""
    counts = session.execute(
        select(Item.task, func.count(Answer.id))
        .join(Answer, Answer.item_id == Item.id)
        .where(Item.study_id == study.id)
        .group_by(Item.task)
    )
    people = sum(has_consented(person, study.id) for person in session.scalars(select(Person)))
    answers: dict[TaskName, int] = dict(counts.all())
    return Asked(answers, people)


def changes(before: StudyConfig, after: StudyConfig, asked: Asked) -> list[Change]:
    """Return the differences between two study files."""
    old, new = (dict(_leaves(msgspec.to_builtins(config))) for config in (before, after))
    return [
        Change(
            field_name(field),
            _shown(old.get(field)),
            _shown(new.get(field)),
            _alters(field, before, after, asked),
        )
        for field in dict.fromkeys((*old, *new))
        if old.get(field) != new.get(field)
    ]


def _alters(field: Field, before: StudyConfig, after: StudyConfig, asked: Asked) -> str:
    """Return the agreements and answers that a change of a field alters, as text."""
    touched: set[str] = {str(field[0])}
    if touched == {"robot"}:
        uses = {"statement": before.statement, "consent": before.consent}
        touched |= {name for name, text in uses.items() if ROBOT in text}
    if touched == {LOCALE}:
        touched.add("consent")
    found = []
    if touched & set(AGREED) and asked.people:
        found.append(f"{_count(asked.people, 'person has', 'people have')} agreed to the old one")
    for task, count in asked.answers.items():
        if count and _is_of(task, field, touched, after):
            found.append(f"{_count(count, 'answer', 'answers')} to {task} came before")
    return "; ".join(found)


def _is_of(task: TaskName, field: Field, touched: Iterable[str], after: StudyConfig) -> bool:
    """Check that a field is about the view of people who do a task."""
    if field == (LOCALE,):
        return True
    if field[:2] == ("tasks", task):
        return field[2] in SHOWN or task not in after.tasks
    known = find_task(task)
    return known is not None and bool(set(touched) & set(known.reads))


def _leaves(value: Any, field: Field = ()) -> Iterator[tuple[Field, Any]]:
    """Yield the values in a record; a list is one value."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from _leaves(inner, (*field, key))
    else:
        yield field, value


def _shown(value: Any) -> str:
    if value is None or value == "":
        return ""
    if isinstance(value, (list, tuple)):
        return "\n".join(map(_shown, value))
    if isinstance(value, dict):
        parts = ((key, _shown(inner)) for key, inner in value.items())
        return "; ".join(f"{key}: {text}" for key, text in parts if text)
    return ("yes" if value else "no") if isinstance(value, bool) else str(value)


def _count(number: int, one: str, several: str) -> str:
    return f"{number} {one if number == 1 else several}"
