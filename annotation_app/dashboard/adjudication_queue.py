"""What people disagree about, and the decisions of adjudicators."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Select, exists, func, select
from sqlalchemy.orm import Session, aliased

from annotation_app.core.problems import Refusal
from annotation_app.items.new_items import REPLACED
from annotation_app.items.submissions import add_event
from annotation_app.people.participants import subject_of
from annotation_app.store.models import Answer, Event, Item, Person, Record, Slot, Study, TaskName
from annotation_app.tasks.task_record import Adjudication, Compared
from annotation_app.tasks.task_registry import find_task, tasks
from annotation_app.work import adoption


@dataclass(frozen=True, slots=True)
class Dispute:
    """An item with several answers, none of which was adopted."""

    item: str
    task: TaskName
    command: str
    answers: int


@dataclass(frozen=True, slots=True)
class Side:
    """An answer, to be compared with another one.

    Parameters
    ----------
    shown
        What the task's template shows of it.
    """

    answer: int
    subject: str
    seconds: float | None
    shown: Any


@dataclass(frozen=True, slots=True)
class Comparison:
    """The answers to an item, side by side.

    Parameters
    ----------
    compared
        What the task makes of them.
    agreement
        How much the first two agree.
    """

    item: str
    task: TaskName
    command: str
    sides: tuple[Side, ...]
    compared: Compared
    agreement: float


def adjudication_of(item: Item) -> Adjudication | None:
    """How people decide between an item's answers, if they do."""
    task = find_task(item.task)
    return None if task is None else task.adjudication


def disputes(session: Session, study_id: str) -> list[Dispute]:
    """What is to be decided, oldest first: all answers that are wanted are there."""
    ids = disputed(study_id)
    rows = session.execute(
        select(Item, func.count(Answer.id))
        .join(Answer, Answer.item_id == Item.id)
        .where(Item.id.in_(ids), Answer.excluded.is_(False))
        .group_by(Item.id)
        .order_by(func.min(Answer.id))
    )
    return [Dispute(item.id, item.task, item.payload["text"], count) for item, count in rows]


def disputed(study_id: str, among: Sequence[str] | None = None) -> Select[str]:
    """The ids of items with several answers, all that are wanted, none of them adopted.

    Parameters
    ----------
    among
        Ids of items of the study, to look at no others.
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
        .having(func.count(Answer.id) > 1)
    )


def compare(session: Session, item: Item, adjudication: Adjudication) -> Comparison:
    """An item's answers side by side."""
    rows = session.execute(
        select(Answer, Person)
        .join(Person, Person.id == Answer.person_id)
        .where(Answer.item_id == item.id, Answer.excluded.is_(False))
        .order_by(Answer.id)
    ).all()
    bodies = [answer.body for answer, _ in rows]
    compared = adjudication.compare(session, item, bodies)
    sides = tuple(
        Side(answer.id, subject_of(person), answer.seconds, shown)
        for (answer, person), shown in zip(rows, compared.sides, strict=True)
    )
    agreement = adjudication.agreement(*bodies[:2]) if len(bodies) > 1 else 1.0
    return Comparison(item.id, item.task, item.payload["text"], sides, compared, agreement)


def choose(
    session: Session,
    study: Study,
    item: Item,
    person: Person,
    answer_id: int,
    *,
    uuid: str,
    now: float,
) -> None:
    """Adopt one of an item's answers.

    Raises
    ------
    Refusal
        If it isn't one of them.
    """
    answer = session.get(Answer, answer_id)
    if answer is None or answer.item_id != item.id or answer.excluded:
        raise Refusal(422, "Choose one of the answers.")
    if _is_known(session, person, uuid):
        return
    add_event(
        session, item, person.id, name="adjudicate", uuid=uuid, body={"answer": answer_id}, now=now
    )
    adoption.adopt(session, study, item, answer)


def edit(
    session: Session,
    study: Study,
    item: Item,
    person: Person,
    body: Record,
    *,
    uuid: str,
    now: float,
) -> None:
    """Adopt an answer of the adjudicator's own, made of the others."""
    if _is_known(session, person, uuid):
        return
    sent = {"body": body}
    adoption.adjudicate(session, study, item, person, uuid=uuid, sent=sent, body=body, now=now)


def _is_known(session: Session, person: Person, uuid: str) -> bool:
    known = select(Event.id).where(Event.person_id == person.id, Event.uuid == uuid)
    return session.scalar(known) is not None
