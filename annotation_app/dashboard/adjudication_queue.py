"""Items on which people disagree, and which await a decision."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

from sqlalchemy import Select, exists, func, select
from sqlalchemy.orm import Session, aliased

from annotation_app.items.new_items import REPLACED
from annotation_app.people.participants import subject_of
from annotation_app.people.person_names import shown_name
from annotation_app.store.models import Answer, Event, Item, Person, Slot, TaskName
from annotation_app.tasks.task_record import Adjudication, Compared
from annotation_app.tasks.task_registry import find_task, tasks


@dataclass(frozen=True, slots=True)
class Dispute:
    """An item with answers none of which was adopted."""

    item: str
    task: TaskName
    command: str
    answers: int


@dataclass(frozen=True, slots=True)
class Side:
    """An answer, the first of which has the number 1, to be compared with others.

    `shown` is what the task's template shows of it, `same_as` are the numbers of those that say the
    same.
    """

    answer: int
    number: int
    subject: str
    person: str
    seconds: float | None
    adopted: bool
    shown: Any
    same_as: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Comparison:
    """The answers to an item, side by side.

    `agreement` is how much any two agree, on average; `is_waiting` is so if there is room for one
    more answer.
    """

    item: str
    task: TaskName
    command: str
    sides: tuple[Side, ...]
    compared: Compared
    agreement: float
    is_waiting: bool


def adjudication_of(item: Item) -> Adjudication | None:
    """Return the task's way of deciding between an item's answers, if it has one."""
    task = find_task(item.task)
    return None if task is None else task.adjudication


def disputes(session: Session, study_id: str) -> list[Dispute]:
    """Return the items that await a decision, oldest first: all wanted answers are there."""
    return _listed(session, disputed(study_id))


def waiting(session: Session, study_id: str) -> list[Dispute]:
    """Return the items that wait for one more answer that an adjudicator has requested."""
    ids = select(Item.id).where(
        Item.study_id == study_id,
        ~Item.subject.startswith(REPLACED),
        exists().where(Event.item_id == Item.id, Event.name == "ask"),
        exists().where(Slot.item_id == Item.id, Slot.answered.is_(False)),
        ~exists().where(Answer.item_id == Item.id, Answer.adopted),
    )
    return _listed(session, ids)


def disputed(study_id: str, among: Sequence[str] | None = None) -> Select[str]:
    """Select the ids of items with all answers that are wanted, none of them adopted.

    With `among`, ids of items of the study, it looks at no others.
    """
    here = Item.study_id == study_id if among is None else Item.id.in_(among)
    other = aliased(Answer)
    decided = [task.name for task in tasks() if task.adjudication is not None]
    return (
        select(Item.id)
        .join(Answer, Answer.item_id == Item.id)
        .where(
            here,
            Item.task.in_(decided),
            Answer.excluded.is_(False),
            ~Item.subject.startswith(REPLACED),
            ~exists().where(other.item_id == Item.id, other.adopted),
            ~exists().where(Slot.item_id == Item.id, Slot.answered.is_(False)),
        )
        .group_by(Item.id)
    )


def compare(session: Session, item: Item, adjudication: Adjudication, salt: bytes) -> Comparison:
    """Return an item's answers side by side."""
    rows = session.execute(
        select(Answer, Person)
        .join(Person, Person.id == Answer.person_id)
        .where(Answer.item_id == item.id, Answer.excluded.is_(False))
        .order_by(Answer.id)
    ).all()
    bodies = [answer.body for answer, _ in rows]
    compared = adjudication.compare(session, item, bodies, salt)
    essences = [adjudication.essence(body) for body in bodies]
    sides = tuple(
        Side(
            answer.id,
            i + 1,
            subject_of(person),
            shown_name(person),
            answer.seconds,
            answer.adopted,
            shown,
            tuple(j + 1 for j, one in enumerate(essences) if j != i and one == essences[i]),
        )
        for i, ((answer, person), shown) in enumerate(zip(rows, compared.sides, strict=True))
    )
    pairs = [adjudication.agreement(one, other) for one, other in combinations(bodies, 2)]
    agreement = sum(pairs) / len(pairs) if pairs else 1.0
    slot = select(Slot.id).where(Slot.item_id == item.id, Slot.answered.is_(False)).limit(1)
    is_waiting = session.scalar(slot) is not None
    return Comparison(
        item.id, item.task, item.command or item.video, sides, compared, agreement, is_waiting
    )


def _listed(session: Session, ids: Select[str]) -> list[Dispute]:
    rows = session.execute(
        select(Item, func.count(Answer.id))
        .join(Answer, Answer.item_id == Item.id)
        .where(Item.id.in_(ids), Answer.excluded.is_(False))
        .group_by(Item.id)
        .order_by(func.min(Answer.id))
    )
    return [Dispute(item.id, item.task, item.command or item.video, count) for item, count in rows]
