"""Deciding between differing answers: one of them, another one, or a request for one more person.

A comment on an answer that was adopted is a remark about it. That one more person was asked,
and why, is an event of the item.
"""

from __future__ import annotations

from sqlalchemy import delete, func, select
from sqlalchemy.orm import Session

from annotation_app.core.problems import Refusal
from annotation_app.items.new_items import REPLACED, new_slots
from annotation_app.items.submissions import add_event, was_received
from annotation_app.store.audit import name_of, note
from annotation_app.store.models import Answer, Event, Item, Person, Record, Slot, Study
from annotation_app.work import adoption
from annotation_app.work.reviewing import read_comment, remark


def choose(
    session: Session,
    study: Study,
    item: Item,
    person: Person,
    answer_id: int,
    *,
    comment: str = "",
    uuid: str,
    now: float,
) -> None:
    """Adopt one of an item's answers. The same decision sent again does nothing.

    It is refused if it isn't one of them, or the comment is too long.
    """
    words = read_comment(comment)
    answer = session.get(Answer, answer_id) if answer_id < 2**31 else None
    if answer is None or answer.item_id != item.id or answer.excluded:
        raise Refusal(422, "Choose one of the answers.")
    if was_received(session, person.id, uuid):
        return
    sent: Record = {"answer": answer_id}
    add_event(session, item, person.id, name="adjudicate", uuid=uuid, body=sent, now=now)
    adoption.adopt(session, study, item, answer)
    _decided(session, study, answer, person, words, now=now)


def answer_instead(
    session: Session,
    study: Study,
    item: Item,
    person: Person,
    *,
    sent: Record,
    body: Record,
    comment: str = "",
    uuid: str,
    now: float,
) -> None:
    """Adopt an answer of the adjudicator's own, as it came and is kept. Sent again it does nothing.

    It is refused if the comment is too long.
    """
    words = read_comment(comment)
    if was_received(session, person.id, uuid):
        return
    answer = adoption.adjudicate(
        session, study, item, person, uuid=uuid, sent=sent, body=body, now=now
    )
    _decided(session, study, answer, person, words, now=now)


def ask_one_more(
    session: Session,
    study: Study,
    item: Item,
    person: Person,
    *,
    comment: str = "",
    uuid: str,
    now: float,
) -> None:
    """Make room for one more answer; the item waits for it. Sent again it does nothing.

    It is refused if nobody can be asked, or somebody is being asked already.
    """
    words = read_comment(comment)
    if was_received(session, person.id, uuid):
        return
    session.execute(select(Item.id).where(Item.id == item.id).with_for_update(key_share=True))
    if study.closed_at is not None:
        raise Refusal(409, "The study is closed: nobody can be asked.")
    if (
        item.attention
        or item.subject.startswith(REPLACED)
        or item.task not in study.config["tasks"]
    ):
        raise Refusal(409, "Nobody is asked this any more.")
    adopted = select(Answer.id).where(Answer.item_id == item.id, Answer.adopted.is_(True)).limit(1)
    if session.scalar(adopted) is not None:
        raise Refusal(409, "This is decided already. Exclude the adopted answer first.")
    open_ = select(Slot.id).where(Slot.item_id == item.id, Slot.answered.is_(False)).limit(1)
    if session.scalar(open_) is not None:
        raise Refusal(409, "Somebody is being asked already.")
    body: Record = {"comment": words}
    add_event(session, item, person.id, name="ask", uuid=uuid, body=body, now=now)
    session.add_all(new_slots(item, 1))
    session.flush()
    note(session, name_of(person), "asked for one more answer", study.name, item=item.id)


def asked(session: Session, item: Item) -> list[tuple[str, str, float]]:
    """Return the requests for one more answer to an item: person, comment and time."""
    rows = session.execute(
        select(Event, Person)
        .join(Person, Person.id == Event.person_id)
        .where(Event.item_id == item.id, Event.name == "ask")
        .order_by(Event.id)
    )
    return [
        (name_of(person), str(event.body.get("comment", "")), event.at) for event, person in rows
    ]


def _decided(
    session: Session, study: Study, answer: Answer, person: Person, words: str, *, now: float
) -> None:
    remark(session, study, answer, person, kind="adopted", text=words, now=now)
    # Nobody need be asked any more of those that adjudicators have asked for.
    wanted = select(func.count()).where(Event.item_id == answer.item_id, Event.name == "ask")
    free = (
        select(Slot.id)
        .where(Slot.item_id == answer.item_id, Slot.answered.is_(False), Slot.person_id.is_(None))
        .limit(session.scalar(wanted) or 0)
    )
    session.execute(delete(Slot).where(Slot.id.in_(session.scalars(free).all())))
