"""How much a study's people agree, task by task."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from sqlalchemy.orm import Session

from annotation_app.dashboard.compared_answers import compared_answers
from annotation_app.store.models import Answer, Record, TaskName
from annotation_app.tasks.agreement import Measured
from annotation_app.tasks.task_registry import tasks
from annotation_app.work.answer_flags import is_untouched

ALL, TOUCHED, UNSEEN = "all", "without untouched suggestions", "no suggestion seen"
"""Which answers are measured. Where a program makes suggestions: all, those that are no untouched
suggestion, and those of people who saw none."""


def agreement(session: Session, study_id: str) -> list[Measured]:
    """What can be measured so far, of all tasks that are answered by several people."""
    rows = session.execute(
        compared_answers(study_id, Answer.task, Answer.item_id, Answer.body, Answer.provenance)
    )
    bodies: dict[tuple[TaskName, str], dict[str, list[Record]]] = {}
    for task_name, item_id, body, provenance in rows:
        for group in _groups(provenance):
            bodies.setdefault((task_name, group), {}).setdefault(item_id, []).append(body)
    return [
        replace(found, task=task.name, answers=group)
        for task in tasks()
        for group in ((ALL,) if task.suggestion is None else (ALL, TOUCHED, UNSEEN))
        for found in task.agreement(list(bodies.get((task.name, group), {}).values()))
    ]


def _groups(provenance: Record | None) -> Iterator[str]:
    """Which groups an answer is in; of old ones it isn't known what people saw."""
    yield ALL
    if provenance is None:
        return
    if provenance["suggestion"] != "shown":
        yield UNSEEN
    if not is_untouched(provenance):
        yield TOUCHED
