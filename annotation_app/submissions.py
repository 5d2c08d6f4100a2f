"""Keeping what people send: answers once each, drafts until there is an answer."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any, Literal

from sqlalchemy import (
    JSON,
    BindParameter,
    Executable,
    Float,
    Integer,
    String,
    bindparam,
    insert,
    select,
    update,
)
from sqlalchemy.orm import Session

from annotation_app.assignment import is_free, lock_person
from annotation_app.database import changed_rows, core, dialect_of, inserting
from annotation_app.models import Answer, Draft, Event, Handout, Item, Person, Record, Slot


@dataclass(frozen=True, slots=True)
class Receipt:
    """What has become of an answer that was sent.

    Parameters
    ----------
    state
        ``accepted``; ``surplus``: kept, though its slot had gone to somebody else;
        ``repeated``: there is one already, and this one is in the event table only.
    event_id
        Of the event that the answer is from.
    answer
        The answer, if this event has made it now; it is written with what becomes of it.
    """

    state: Literal["accepted", "surplus", "repeated"]
    event_id: int
    answer: Answer | None = None


def submit(
    session: Session,
    item: Item,
    person: Person,
    *,
    uuid: str,
    sent: Record,
    body: Record,
    now: float,
) -> Receipt:
    """Keep an answer to an item. The same event sent again gives the same receipt.

    A late answer takes a free slot of the item, if its own has gone to somebody else.

    Parameters
    ----------
    item
        It is or was the person's.
    uuid
        Made by the sender, one for each answer.
    sent
        What came, for the event.
    body
        What is to be kept of it: it has been validated.
    """
    lock_person(session, person.id)
    known = session.scalar(_KNOWN, {"who": person.id, "uuid": uuid})
    if known is not None:
        return _receipt(session, known)
    event = add_event(session, item, person, name="submit", uuid=uuid, body=sent, now=now)
    about = {"item": item.id, "who": person.id, "of_task": item.task, "of_subject": item.subject}
    handed_out_at, is_answered = session.execute(_BEFORE, about).one()
    if is_answered:
        return Receipt("repeated", event)
    surplus = not _fill_slot(session, item, person, now)
    answer = Answer(
        item_id=item.id,
        person_id=person.id,
        task=item.task,
        subject=item.subject,
        event_id=event,
        body=body,
        surplus=surplus,
        seconds=0.0 if handed_out_at is None else now - handed_out_at,
        at=now,
    )
    session.add(answer)
    return Receipt("surplus" if surplus else "accepted", event, answer)


def was_received(session: Session, person: Person, uuid: str) -> bool:
    """Whether somebody has sent an event before."""
    lock_person(session, person.id)
    return session.scalar(_KNOWN, {"who": person.id, "uuid": uuid}) is not None


def add_event(
    session: Session,
    item: Item,
    person: Person,
    *,
    name: Literal["submit", "skip", "flag", "adjudicate"],
    uuid: str,
    body: Record,
    now: float,
) -> int:
    """Keep what somebody sent, as it came; the event's id."""
    values = {"uuid": uuid, "item_id": item.id, "person_id": person.id, "name": name}
    return int(session.execute(_ADD_EVENT, {**values, "body": body, "at": now}).scalar_one())


def save_draft(
    session: Session, item: Item, person: Person, *, revision: int, body: Record, now: float
) -> bool:
    """Keep a draft unless there is an answer, or a draft with a later revision.

    Returns
    -------
    bool
        Whether it was kept.
    """
    lock_person(session, person.id)
    values = {
        "item": item.id,
        "who": person.id,
        "of_task": item.task,
        "of_subject": item.subject,
        "sent_revision": revision,
        "sent_body": body,
        "at_present": now,
    }
    return session.scalar(_keep_draft(dialect_of(session)), values) is not None


ANSWER, EVENT, HANDOUT, SLOT = map(core, (Answer, Event, Handout, Slot))
_ITEM: BindParameter[str] = bindparam("item", type_=String)
_WHO: BindParameter[str] = bindparam("who", type_=String)
_NOW: BindParameter[float] = bindparam("at_present", type_=Float)
_KNOWN = select(EVENT.c.id).where(EVENT.c.person_id == _WHO, EVENT.c.uuid == bindparam("uuid"))
_SURPLUS = select(ANSWER.c.surplus).where(ANSWER.c.event_id == bindparam("event"))
_ANSWERED = select(ANSWER.c.id).where(
    ANSWER.c.person_id == _WHO,
    ANSWER.c.task == bindparam("of_task"),
    ANSWER.c.subject == bindparam("of_subject"),
)
_HANDED_OUT_AT = select(HANDOUT.c.at).where(HANDOUT.c.item_id == _ITEM, HANDOUT.c.person_id == _WHO)
_BEFORE = select(_HANDED_OUT_AT.scalar_subquery(), _ANSWERED.exists())
_ADD_EVENT = insert(EVENT).returning(EVENT.c.id)
_FILL_OWN = (
    update(SLOT)
    .where(SLOT.c.item_id == _ITEM, SLOT.c.person_id == _WHO, SLOT.c.answered.is_(False))
    .values(answered=True)
)
_FREE = (
    select(SLOT.c.id)
    .where(SLOT.c.item_id == _ITEM, *is_free(_NOW))
    .limit(1)
    .with_for_update(skip_locked=True)
)
_FILL_FREE = (
    update(SLOT)
    .where(SLOT.c.id == _FREE.scalar_subquery(), *is_free(_NOW))
    .values(answered=True, person_id=_WHO, expires_at=_NOW)
)


@functools.cache
def _keep_draft(dialect: str) -> Executable:
    sent: dict[str, BindParameter[Any]] = {
        "item_id": _ITEM,
        "person_id": _WHO,
        "revision": bindparam("sent_revision", type_=Integer),
        "body": bindparam("sent_body", type_=JSON),
        "at": _NOW,
    }
    draft = inserting(dialect, Draft).from_select(
        list(sent), select(*sent.values()).where(~_ANSWERED.exists())
    )
    changed = {name: draft.excluded[name] for name in ("revision", "body", "at")}
    statement: Executable = draft.on_conflict_do_update(
        index_elements=["item_id", "person_id"],
        set_=changed,
        where=core(Draft).c.revision < draft.excluded.revision,
    ).returning(core(Draft).c.revision)
    return statement


def _fill_slot(session: Session, item: Item, person: Person, now: float) -> bool:
    """Give the answer the person's slot of the item, else a free one; whether there is one."""
    about = {"item": item.id, "who": person.id}
    own = changed_rows(session, _FILL_OWN, about)
    if own or item.attention:
        return own == 1
    return changed_rows(session, _FILL_FREE, {**about, "at_present": now}) == 1


def _receipt(session: Session, event_id: int) -> Receipt:
    surplus = session.scalar(_SURPLUS, {"event": event_id})
    if surplus is None:
        return Receipt("repeated", event_id)
    return Receipt("surplus" if surplus else "accepted", event_id)
