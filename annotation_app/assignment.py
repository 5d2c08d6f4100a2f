"""Who gets which item: slots are leased for a time, on any database."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, TypeAlias

from sqlalchemy import (
    BindParameter,
    ColumnElement,
    Select,
    bindparam,
    exists,
    func,
    or_,
    select,
    update,
)
from sqlalchemy.orm import Session, aliased

from annotation_app.database import changed_rows
from annotation_app.models import Answer, Handout, Item, Person, Slot, Study, Task

Reason: TypeAlias = Literal["done", "blocked", "all taken", "nothing to do"]
"""Why somebody gets no item: they have done all there is for them, they may not take
part, others are at work on what is left, or there is nothing (left) in the study."""


# Statements are built once: that takes several times as long as to run them.
_STUDY: BindParameter[str] = bindparam("of_study")
_TASK: BindParameter[str] = bindparam("of_task")
_WHO: BindParameter[str] = bindparam("who")
_NOW: BindParameter[float] = bindparam("at_present")


@dataclass(frozen=True, slots=True)
class Lease:
    """An item that is somebody's until a time."""

    item: Item
    expires_at: float


def lock_person(session: Session, person_id: str) -> None:
    """Let no other transaction do anything for a person until this one ends."""
    if session.get_bind().dialect.name != "sqlite":  # there is one writer at a time
        session.execute(select(Person.id).where(Person.id == person_id).with_for_update())


def take(
    session: Session,
    study_id: str,
    task: Task,
    person: Person,
    *,
    now: float,
    lease_s: float,
    attention_share: float = 0.0,
) -> Lease | Reason:
    """Give a person an item to work on, the one that they already have if there is one.

    A slot is free if it is neither answered nor leased. Nobody gets an item whose subject
    they have answered, which they have skipped, or of which they are the author. The
    statement that takes a slot checks again that it is free, so that of two at once only
    one gets it and the other tries the next.

    Parameters
    ----------
    attention_share
        Part of a person's items whose right answers are known.
    """
    lock_person(session, person.id)
    if person.blocked_at is not None:
        return "blocked"
    about = {"of_study": study_id, "of_task": task, "who": person.id}
    held = _held(session, study_id, task, person, now=now, lease_s=lease_s)
    if held is not None:
        return held
    if _wants_attention(session, study_id, task, person, attention_share):
        lease = _attention(session, study_id, task, person, now=now, lease_s=lease_s)
        if lease is not None:
            return lease
    while True:
        slot_id = session.scalar(_free_slot(task == "rate"), {**about, "at_present": now})
        if slot_id is None:
            return _reason(session, about)
        taken = changed_rows(
            session,
            update(Slot)
            .where(Slot.id == slot_id, *is_free(now))
            .values(person_id=person.id, expires_at=now + lease_s),
        )
        if taken == 1:
            item = session.scalars(select(Item).join(Slot).where(Slot.id == slot_id)).one()
            return _handed_out(session, item, person, now=now, lease_s=lease_s)


def skip(session: Session, item_id: str, person: Person, *, now: float) -> None:
    """Give an item back that the person has and hasn't answered, and won't get again."""
    session.execute(
        update(Slot).where(*_is_held(item_id, person)).values(person_id=None, expires_at=None)
    )
    session.execute(
        update(Handout)
        .where(Handout.item_id == item_id, Handout.person_id == person.id)
        .values(skipped_at=now)
    )


def extend(session: Session, item_id: str, person: Person, *, now: float, lease_s: float) -> bool:
    """Lease an item on to the person who has it; whether they still have it."""
    extended = changed_rows(
        session,
        update(Slot).where(*_is_held(item_id, person)).values(expires_at=now + lease_s),
    )
    return extended == 1


def was_handed_out(session: Session, item_id: str, person_id: str) -> bool:
    """Whether an item is or was the person's, so that they may answer it."""
    return session.get(Handout, (item_id, person_id)) is not None


def handed_out(session: Session, item_id: str, person_id: str) -> tuple[Item, Study] | None:
    """An item that is or was the person's, and its study."""
    row = session.execute(_HANDED_OUT, {"item": item_id, "who": person_id}).first()
    return None if row is None else (row[0], row[1])


def is_free(now: float | BindParameter[float]) -> tuple[ColumnElement[bool], ...]:
    """What is true of slots that are neither answered nor leased."""
    return Slot.answered.is_(False), or_(Slot.person_id.is_(None), Slot.expires_at < now)


def _is_held(item_id: str, person: Person) -> tuple[ColumnElement[bool], ...]:
    return Slot.item_id == item_id, Slot.person_id == person.id, Slot.answered.is_(False)


def _handed_out(
    session: Session, item: Item, person: Person, *, now: float, lease_s: float
) -> Lease:
    if not was_handed_out(session, item.id, person.id):
        session.add(Handout(item_id=item.id, person_id=person.id, at=now))
        session.flush()
    return Lease(item, now + lease_s)


def _held(
    session: Session, study_id: str, task: Task, person: Person, *, now: float, lease_s: float
) -> Lease | None:
    """The item that the person has, even past its time if nobody else has taken it."""
    about = {"of_study": study_id, "of_task": task, "who": person.id}
    item = session.scalars(_HELD, about).first()
    if item is None or not extend(session, item.id, person, now=now, lease_s=lease_s):
        return None
    return Lease(item, now + lease_s)


def _wants_attention(
    session: Session, study_id: str, task: Task, person: Person, share: float
) -> bool:
    """Whether the person has had fewer attention checks than the share of what they did."""
    if not share:
        return False
    done, checks = session.execute(
        select(func.count(), func.count().filter(Item.attention))
        .select_from(Answer)
        .join(Item, Item.id == Answer.item_id)
        .where(Item.study_id == study_id, Item.task == task, Answer.person_id == person.id)
    ).one()
    return bool(checks < int((done + 1) * share))


def _attention(
    session: Session, study_id: str, task: Task, person: Person, *, now: float, lease_s: float
) -> Lease | None:
    """An item whose right answer is known, with a slot of the person's own."""
    about = {"of_study": study_id, "of_task": task, "who": person.id}
    item = session.scalars(_ATTENTION, about).first()
    if item is None:
        return None
    session.add(Slot(item_id=item.id, person_id=person.id, expires_at=now + lease_s))
    return _handed_out(session, item, person, now=now, lease_s=lease_s)


def _is_new() -> tuple[ColumnElement[bool], ...]:
    """What is true of items that a person may get, if there is a free slot."""
    other = aliased(Slot)
    return (
        or_(Item.author_id.is_(None), Item.author_id != _WHO),
        ~exists().where(other.item_id == Item.id, other.person_id == _WHO),
        ~exists().where(
            Handout.item_id == Item.id,
            Handout.person_id == _WHO,
            Handout.skipped_at.is_not(None),
        ),
        ~exists().where(
            Answer.person_id == _WHO,
            Answer.task == Item.task,
            Answer.subject == Item.subject,
        ),
    )


def _of_task() -> tuple[ColumnElement[bool], ...]:
    return Item.study_id == _STUDY, Item.task == _TASK, Item.attention.is_(False)


@functools.cache
def _free_slot(shuffled: bool) -> Select[int]:
    order = (func.random(),) if shuffled else (Item.rank, Item.id, Slot.id)
    return (
        select(Slot.id)
        .join(Item)
        .where(*_of_task(), *is_free(_NOW), *_is_new())
        .order_by(*order)
        .limit(1)
        .with_for_update(of=Slot, skip_locked=True)
    )


_ATTENTION = (
    select(Item)
    .where(Item.study_id == _STUDY, Item.task == _TASK, Item.attention, *_is_new())
    .order_by(func.random())
)
_UNANSWERED = select(Slot.id).join(Item).where(*_of_task(), Slot.answered.is_(False)).limit(1)
_UNANSWERED_NEW = _UNANSWERED.where(*_is_new())
_ANSWERED = (
    select(Answer.id)
    .join(Item)
    .where(Item.study_id == _STUDY, Item.task == _TASK, Answer.person_id == _WHO)
    .limit(1)
)
_HELD = (
    select(Item)
    .join(Slot)
    .where(
        Item.study_id == _STUDY,
        Item.task == _TASK,
        Slot.person_id == _WHO,
        Slot.answered.is_(False),
    )
    .order_by(Item.rank, Item.id)
    .limit(1)
)
_HANDED_OUT = (
    select(Item, Study)
    .join(Handout, Handout.item_id == Item.id)
    .join(Study, Study.id == Item.study_id)
    .where(Item.id == bindparam("item"), Handout.person_id == _WHO)
)


def _reason(session: Session, about: Mapping[str, str]) -> Reason:
    if session.scalar(_UNANSWERED_NEW, about) is not None:
        return "all taken"
    if session.scalar(_ANSWERED, about) is not None:
        return "done"
    return "nothing to do" if session.scalar(_UNANSWERED, about) is None else "done"
