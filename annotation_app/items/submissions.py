"""Keeping people's work: answers once each, drafts until there is an answer."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any, Literal

from sqlalchemy import (
    JSON,
    BindParameter,
    ColumnElement,
    Float,
    Integer,
    String,
    UpdateBase,
    and_,
    bindparam,
    case,
    delete,
    insert,
    select,
    update,
)
from sqlalchemy.orm import Session

from annotation_app.items.assignment import AnyItem, is_free, lock_person
from annotation_app.items.elapsed import LONGEST_S, since_boot
from annotation_app.store.database import core, dialect_of, inserting
from annotation_app.store.models import Answer, Draft, Event, Handout, Record, Slot


@dataclass(frozen=True, slots=True)
class Receipt:
    """The fate of an answer that was sent."""

    state: Literal["accepted", "surplus", "repeated"]
    """``accepted``; ``surplus``: kept, though its slot had gone to somebody else; ``repeated``:
    there is one already, and this one is in the event table only."""
    answer: int | None = None
    """The answer's id, if it was accepted now."""


def submit(
    session: Session,
    item: AnyItem,
    who: str,
    *,
    uuid: str,
    sent: Record,
    body: Record,
    now: float,
    provenance: Record | None = None,
    gist: str | None = None,
    odd_below_s: float | None = None,
    adopted: bool = True,
) -> Receipt:
    """Keep an answer to an item. The same event sent again gives the same receipt.

    A late answer takes a free slot of the item, if its own has gone to somebody else. The draft
    goes: what somebody typed and took back isn't kept.

    The sender makes a `uuid` for each answer. `sent` is what came, for the event; `body` what is to
    be kept of it, validated; `gist` what is counted and compared. An answer that took
    `odd_below_s` isn't odd.
    """
    # Who inserts waits for whoever has inserted the same, and for whoever has locked the person
    # that the event refers to: nothing else needs to be locked.
    add_event, add_answer = _submitting(dialect_of(session))
    event = {
        "uuid": uuid,
        "item_id": item.id,
        "person_id": who,
        "name": "submit",
        "body": sent,
        "at": now,
    }
    added = session.scalar(add_event, event)
    if added is None:
        return _receipt(session, who, uuid)
    answer = {
        "item_id": item.id,
        "study_id": item.study_id,
        "kind": "attention" if item.attention else "usual",
        "person_id": who,
        "task": item.task,
        "subject": item.subject,
        "event_id": added,
        "body": body,
        "gist": gist,
        "odd_below_s": odd_below_s,
        "provenance": provenance,
        "adopted": adopted,
        "at": now,
        **since_boot(),
    }
    answered = session.scalar(add_answer, answer)
    session.execute(_FORGET_DRAFT, {"item": item.id, "who": who})
    if answered is None:
        return Receipt("repeated")
    about = {"item": item.id, "who": who, "at_present": now}
    if session.scalar(_FILL_OWN, about) or (
        not item.attention and session.scalar(_FILL_FREE, about)
    ):
        return Receipt("accepted", answered)
    session.execute(_MAKE_SURPLUS, {"answer": answered})
    return Receipt("surplus")


def held_s(session: Session, item: AnyItem, who: str, now: float) -> float | None:
    """Return the seconds since an item was handed to a person, None if no clock shows them."""
    about = {"item": item.id, "who": who, "at_present": now, **since_boot()}
    found: float | None = session.scalar(_HELD, about)
    return found


def was_received(session: Session, who: str, uuid: str) -> bool:
    """Check that a person has sent an event before."""
    lock_person(session, who)
    return session.scalar(_KNOWN, {"who": who, "uuid": uuid}) is not None


def add_event(
    session: Session,
    item: AnyItem,
    who: str,
    *,
    name: Literal["submit", "skip", "flag", "adjudicate", "ask"],
    uuid: str,
    body: Record,
    now: float,
) -> int:
    """Keep a person's message unchanged; return the event's id."""
    values = {"uuid": uuid, "item_id": item.id, "person_id": who, "name": name}
    return int(session.execute(_ADD_EVENT, {**values, "body": body, "at": now}).scalar_one())


def save_draft(
    session: Session, item: AnyItem, who: str, *, revision: int, body: Record, now: float
) -> bool:
    """Keep a draft unless there is an answer or a later revision; return True if it is kept now."""
    lock_person(session, who)
    values = {
        "item": item.id,
        "who": who,
        "of_task": item.task,
        "of_subject": item.subject,
        "sent_revision": revision,
        "sent_body": body,
        "at_present": now,
    }
    if session.scalar(_keep_draft(dialect_of(session)), values) is not None:
        return True
    # A page that was left before the reply came sends the same again when it is back.
    there = session.execute(_DRAFT, {"item": item.id, "who": who}).first()
    return there is not None and tuple(there) == (revision, body)


ANSWER, DRAFT, EVENT, HANDOUT, SLOT = map(core, (Answer, Draft, Event, Handout, Slot))
_ITEM: BindParameter[str] = bindparam("item", type_=String)
_WHO: BindParameter[str] = bindparam("who", type_=String)
_NOW: BindParameter[float] = bindparam("at_present", type_=Float)
_KNOWN = select(EVENT.c.id).where(EVENT.c.person_id == _WHO, EVENT.c.uuid == bindparam("uuid"))
_SURPLUS = (
    select(ANSWER.c.surplus)
    .join(EVENT, EVENT.c.id == ANSWER.c.event_id)
    .where(EVENT.c.person_id == _WHO, EVENT.c.uuid == bindparam("uuid"))
)
_ANSWERED = select(ANSWER.c.id).where(
    ANSWER.c.person_id == _WHO,
    ANSWER.c.task == bindparam("of_task"),
    ANSWER.c.subject == bindparam("of_subject"),
)
_DRAFT = select(DRAFT.c.revision, DRAFT.c.body).where(
    DRAFT.c.item_id == _ITEM, DRAFT.c.person_id == _WHO
)
_FORGET_DRAFT = delete(DRAFT).where(DRAFT.c.item_id == _ITEM, DRAFT.c.person_id == _WHO)
_ADD_EVENT = insert(EVENT).returning(EVENT.c.id)
_FILL_OWN = (
    update(SLOT)
    .where(SLOT.c.item_id == _ITEM, SLOT.c.person_id == _WHO, SLOT.c.answered.is_(False))
    .values(answered=True)
    .returning(SLOT.c.id)
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
    .returning(SLOT.c.id)
)
_MAKE_SURPLUS = (
    update(ANSWER).where(ANSWER.c.id == bindparam("answer")).values(surplus=True, adopted=False)
)


_OWN_DEFAULT = ("id", "excluded")


@functools.cache
def _submitting(dialect: str) -> tuple[UpdateBase, UpdateBase]:
    """Return statements that insert an event and an answer, unless they are there already."""
    event, answer = (
        {
            c.name: bindparam(c.name, type_=c.type)
            for c in table.columns
            if c.name not in _OWN_DEFAULT
        }
        for table in (EVENT, ANSWER)
    )
    since_handout = select(_seconds(answer["at"])).where(
        HANDOUT.c.item_id == answer["item_id"], HANDOUT.c.person_id == answer["person_id"]
    )
    known = {
        **answer,
        "surplus": False,
        "excluded": False,
        "seconds": since_handout.scalar_subquery(),
    }
    return (
        inserting(dialect, Event).values(event).on_conflict_do_nothing().returning(EVENT.c.id),
        inserting(dialect, Answer).values(known).on_conflict_do_nothing().returning(ANSWER.c.id),
    )


def _seconds(now: BindParameter[float]) -> ColumnElement[float]:
    """Return the seconds since an item was handed out, if the clocks show them."""
    boot = bindparam("boot", type_=String)
    since_boot_s = bindparam("since_boot_s", type_=Float)
    by_clock = now - HANDOUT.c.at
    return case(
        (HANDOUT.c.boot == boot, since_boot_s - HANDOUT.c.since_boot_s),
        (and_(by_clock >= 0, by_clock <= LONGEST_S), by_clock),
    )


_HELD = select(_seconds(_NOW)).where(HANDOUT.c.item_id == _ITEM, HANDOUT.c.person_id == _WHO)


@functools.cache
def _keep_draft(dialect: str) -> UpdateBase:
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
    statement: UpdateBase = draft.on_conflict_do_update(
        index_elements=["item_id", "person_id"],
        set_=changed,
        where=DRAFT.c.revision < draft.excluded.revision,
    ).returning(DRAFT.c.revision)
    return statement


def _receipt(session: Session, who: str, uuid: str) -> Receipt:
    surplus = session.scalar(_SURPLUS, {"who": who, "uuid": uuid})
    if surplus is None:
        return Receipt("repeated")
    return Receipt("surplus" if surplus else "accepted")
