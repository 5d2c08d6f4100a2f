"""Keeping what people send: answers once each, drafts until there is an answer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from sqlalchemy import bindparam, select, update
from sqlalchemy.orm import Session

from annotation_app.assignment import is_free, lock_person
from annotation_app.database import changed_rows
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
        The answer, if this event has made it now.
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
    known = session.scalars(_KNOWN, {"who": person.id, "uuid": uuid}).first()
    if known is not None:
        return _receipt(session, known)
    event = add_event(session, item, person, name="submit", uuid=uuid, body=sent, now=now)
    if _is_answered(session, item, person):
        return Receipt("repeated", event.id)
    surplus = not _fill_slot(session, item, person, now)
    handout = session.get(Handout, (item.id, person.id))
    answer = Answer(
        item_id=item.id,
        person_id=person.id,
        task=item.task,
        subject=item.subject,
        event_id=event.id,
        body=body,
        surplus=surplus,
        seconds=0.0 if handout is None else now - handout.at,
        at=now,
    )
    session.add(answer)
    session.flush()
    return Receipt("surplus" if surplus else "accepted", event.id, answer)


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
) -> Event:
    """Keep what somebody sent, as it came."""
    event = Event(uuid=uuid, item_id=item.id, person_id=person.id, name=name, body=body, at=now)
    session.add(event)
    session.flush()
    return event


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
    if _is_answered(session, item, person):
        return False
    draft = session.get(Draft, (item.id, person.id))
    if draft is None:
        session.add(
            Draft(item_id=item.id, person_id=person.id, revision=revision, body=body, at=now)
        )
        return True
    if draft.revision >= revision:
        return False
    draft.revision, draft.body, draft.at = revision, body, now
    return True


_KNOWN = select(Event).where(Event.person_id == bindparam("who"), Event.uuid == bindparam("uuid"))
_ANSWERED = select(Answer.id).where(
    Answer.person_id == bindparam("who"),
    Answer.task == bindparam("of_task"),
    Answer.subject == bindparam("of_subject"),
)


def _is_answered(session: Session, item: Item, person: Person) -> bool:
    about = {"who": person.id, "of_task": item.task, "of_subject": item.subject}
    return session.scalar(_ANSWERED, about) is not None


def _fill_slot(session: Session, item: Item, person: Person, now: float) -> bool:
    """Give the answer the person's slot of the item, else a free one; whether there is one."""
    own = changed_rows(
        session,
        update(Slot)
        .where(Slot.item_id == item.id, Slot.person_id == person.id, Slot.answered.is_(False))
        .values(answered=True),
    )
    if own or item.attention:
        return own == 1
    free = session.scalar(
        select(Slot.id)
        .where(Slot.item_id == item.id, *is_free(now))
        .limit(1)
        .with_for_update(skip_locked=True)
    )
    return (
        free is not None
        and changed_rows(
            session,
            update(Slot)
            .where(Slot.id == free, *is_free(now))
            .values(answered=True, person_id=person.id, expires_at=now),
        )
        == 1
    )


def _receipt(session: Session, event: Event) -> Receipt:
    answer = session.scalars(select(Answer).where(Answer.event_id == event.id)).one_or_none()
    if answer is None:
        return Receipt("repeated", event.id)
    return Receipt("surplus" if answer.surplus else "accepted", event.id)
