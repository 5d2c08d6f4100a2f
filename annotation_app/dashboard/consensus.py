"""How much a study's people agree, task by task."""

from __future__ import annotations

from dataclasses import dataclass

from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.store.models import Answer, Event, Item, Record, TaskName
from annotation_app.tasks.task_registry import tasks


@dataclass(frozen=True, slots=True)
class Agreement:
    """A measure of agreement.

    Parameters
    ----------
    value
        None where too little has been answered twice, or everybody says the same all the time.
    units
        What was answered by two people or more: commands, clauses, pairs.
    """

    task: TaskName
    measure: str
    value: float | None
    units: int


def agreement(session: Session, study_id: str) -> list[Agreement]:
    """What can be measured so far, of all tasks that are answered by several people."""
    rows = session.execute(
        select(Answer.task, Answer.item_id, Answer.body)
        .join(Item, Item.id == Answer.item_id)
        .join(Event, Event.id == Answer.event_id)
        # Adjudicators have seen what the others answered.
        .where(
            Item.study_id == study_id,
            Item.attention.is_(False),
            Answer.excluded.is_(False),
            Event.name != "adjudicate",
        )
        .order_by(Answer.id)
    )
    bodies: dict[TaskName, dict[str, list[Record]]] = {}
    for task_name, item_id, body in rows:
        bodies.setdefault(task_name, {}).setdefault(item_id, []).append(body)
    return [
        Agreement(task.name, found.measure, found.value, found.units)
        for task in tasks()
        for found in task.agreement(list(bodies.get(task.name, {}).values()))
    ]
