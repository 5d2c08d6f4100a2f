"""How much a study's people agree, task by task."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import TypeAlias

import msgspec
from sqlalchemy import ColumnElement, and_, func, select
from sqlalchemy.orm import Session

from annotation_app.store.models import Answer, Record, TaskName
from annotation_app.tasks.agreement import Measured
from annotation_app.tasks.task_registry import task_names, tasks
from annotation_app.work.answer_flags import is_untouched

ALL, TOUCHED, UNSEEN = "all", "without untouched suggestions", "no suggestion seen"
"""Which answers are measured. Where a program makes suggestions: all, those that are no untouched
suggestion, and those of people who saw none."""
_BETWEEN = "\n"
"""Between the gists of an item, which have no such character."""


def agreement(session: Session, study_id: str) -> list[Measured]:
    """What can be measured so far, of all tasks that are answered by several people."""
    answered = _by_gists(session, study_id)
    for key, items in _by_bodies(session, study_id).items():
        answered.setdefault(key, []).extend(items.values())
    return [
        replace(found, task=task.name, answers=group)
        for task in tasks()
        for group in ((ALL,) if task.suggestion is None else (ALL, TOUCHED, UNSEEN))
        for found in task.agreement(answered.get((task.name, group), []))
    ]


_Group: TypeAlias = tuple[TaskName, str]
"""A task, and which of its answers."""


def _by_gists(session: Session, study_id: str) -> dict[_Group, list[list[Record]]]:
    """What was answered to the items of which all answers have gists.

    Items with the same answers are counted by the database, and read once.
    """
    gists = func.aggregate_strings(Answer.gist, _BETWEEN)
    items = (
        select(Answer.task, gists.label("gists"))
        .where(*_compared(study_id), Answer.task.in_(_with_gists()))
        .group_by(Answer.task, Answer.item_id)
        .having(func.count(Answer.gist) == func.count())
        .subquery()
    )
    same = items.c.task, items.c.gists
    rows = select(*same, func.count()).group_by(*same)
    found: dict[_Group, list[list[Record]]] = {}
    for task, texts, count in session.execute(rows):
        bodies = [msgspec.json.decode(text) for text in texts.split(_BETWEEN)]
        found.setdefault((task, ALL), []).extend([bodies] * count)
    return found


def _by_bodies(session: Session, study_id: str) -> dict[_Group, dict[str, list[Record]]]:
    """What was answered to the other items."""
    compared, with_gists = _compared(study_id), _with_gists()
    without = select(Answer.item_id).where(*compared, Answer.gist.is_(None))
    found: dict[_Group, dict[str, list[Record]]] = {}
    for condition in (
        Answer.task.in_([name for name in task_names() if name not in with_gists]),
        and_(Answer.task.in_(with_gists), Answer.item_id.in_(without)),
    ):
        rows = (
            select(Answer.task, Answer.item_id, Answer.body, Answer.provenance)
            .where(*compared, condition)
            .order_by(Answer.id)
        )
        for task, item_id, body, provenance in session.execute(rows):
            for group in _groups(provenance):
                found.setdefault((task, group), {}).setdefault(item_id, []).append(body)
    return found


def _compared(study_id: str) -> tuple[ColumnElement[bool], ...]:
    """That an answer is compared: adjudicators have seen what the others answered."""
    return Answer.study_id == study_id, Answer.kind == "usual", Answer.excluded.is_(False)


def _with_gists() -> list[TaskName]:
    """The tasks whose gists tell all: which group an answer is in they don't."""
    return [task.name for task in tasks() if task.gist is not None and task.suggestion is None]


def _groups(provenance: Record | None) -> Iterator[str]:
    """Which groups an answer is in; of old ones it isn't known what people saw."""
    yield ALL
    if provenance is None:
        return
    if provenance["suggestion"] != "shown":
        yield UNSEEN
    if not is_untouched(provenance):
        yield TOUCHED
