"""Excluding answers, having them redone, restoring them, and remarks about them.

An answer that is excluded stays as it was sent. What was made of it is withdrawn: nobody gets it
any more and no corpus has it. All of this can be restored.
"""

from __future__ import annotations

from collections.abc import Iterator

from sqlalchemy import delete, func, or_, select
from sqlalchemy.orm import Session

from annotation_app.core.problems import Refusal
from annotation_app.core.sent_text import clean_text
from annotation_app.items.new_items import REPLACED, about_answer, new_slots
from annotation_app.store.audit import name_of, note
from annotation_app.store.models import Answer, Item, Person, Record, Remark, Slot, Study
from annotation_app.tasks.task_registry import task_of
from annotation_app.work import adoption

LONGEST_REMARK = 2000
REDONE = "had redone"
"""Kind of the remark about an answer that somebody else is asked for."""


def exclude(
    session: Session,
    study: Study,
    answer: Answer,
    person: Person,
    reason: str,
    *,
    again: bool = False,
    now: float,
) -> None:
    """Exclude an answer from corpora and numbers.

    `again` has it redone: the item goes back to the queue, for somebody else to answer. It is
    refused without a reason, if the answer is excluded already, and if nobody else can be asked.
    """
    words = read_comment(reason, "Say why.")
    item = _locked(session, answer)
    if answer.excluded:
        raise Refusal(409, "This answer is excluded already.")
    if again and (item.attention or item.subject.startswith(REPLACED)):
        raise Refusal(409, "This can't be redone: nobody is asked it any more.")
    before: Record = {"adopted": answer.adopted, "withdrawn": list(_withdraw(session, answer))}
    answer.excluded, answer.adopted = True, False
    if again:
        _free_slot(session, answer)
    session.flush()
    kind = REDONE if again else "excluded"
    remark(session, study, answer, person, kind=kind, text=words, before=before, now=now)
    if not again:
        adoption.settle(session, study, item)


def restore(session: Session, study: Study, answer: Answer, person: Person, *, now: float) -> None:
    """Let an answer count again, and what was made of it; refused if it isn't excluded.

    If somebody else has taken its place meanwhile, it counts as one that came late.
    """
    item = _locked(session, answer)
    if not answer.excluded:
        raise Refusal(409, "This answer isn't excluded.")
    last = session.scalars(
        select(Remark)
        .where(Remark.answer_id == answer.id, Remark.kind.in_(("excluded", REDONE)))
        .order_by(Remark.id.desc())
    ).first()
    before: Record = {"adopted": False, "withdrawn": []} if last is None else last.before
    answer.excluded = False
    if last is not None and last.kind == REDONE and not _take_slot(session, answer):
        answer.surplus = True
    session.flush()
    remark(session, study, answer, person, kind="restored", now=now)
    rival = select(Answer.id).where(Answer.item_id == item.id, Answer.adopted.is_(True))
    decides = task_of(item.task).adjudication is not None
    if before["adopted"] and not (decides and session.scalar(rival.limit(1)) is not None):
        answer.adopted = True
        _restore(session, before["withdrawn"])
    session.flush()


def comment(
    session: Session, study: Study, answer: Answer, person: Person, text: str, *, now: float
) -> None:
    """Keep a reviewer's comment on an answer; refuse it if it is empty or too long."""
    words = read_comment(text, "Type a comment.")
    remark(session, study, answer, person, kind="commented", text=words, now=now)


def read_comment(text: str, if_empty: str = "") -> str:
    """Return a comment in its kept form.

    It is refused if it is too long. An empty one is refused with the text `if_empty`, if that is
    given.
    """
    words = clean_text(text)
    if if_empty and not words:
        raise Refusal(422, if_empty)
    if len(words) > LONGEST_REMARK:
        raise Refusal(422, f"Use at most {LONGEST_REMARK} characters.")
    return words


def _locked(session: Session, answer: Answer) -> Item:
    """Lock and return the answer's item; of two simultaneous reviewers one waits."""
    found = session.scalars(
        select(Item).where(Item.id == answer.item_id).with_for_update(key_share=True)
    ).one()
    session.refresh(answer)
    return found


def _withdraw(session: Session, answer: Answer) -> Iterator[Record]:
    """Let nobody get what was made of an answer; what to remember of each item."""
    # What shows a command names it; what was made of another answer has it as its subject.
    made = or_(
        Item.subject == about_answer(answer), Item.payload["command"].as_integer() == answer.id
    )
    study_id = session.get_one(Item, answer.item_id).study_id
    for item in session.scalars(select(Item).where(Item.study_id == study_id, made)).all():
        if item.subject.startswith(REPLACED):
            continue
        for other in session.scalars(select(Answer).where(Answer.item_id == item.id)).all():
            yield from _withdraw(session, other)
        free = (Slot.item_id == item.id, Slot.answered.is_(False))
        slots = session.scalar(select(func.count()).where(*free))
        session.execute(delete(Slot).where(*free))
        subject, item.subject = item.subject, f"{REPLACED}{item.id}"
        session.flush()
        yield {"item": item.id, "subject": subject, "slots": slots}


def _restore(session: Session, withdrawn: list[Record]) -> None:
    """Give items out again that were withdrawn, unless others have their subjects."""
    for one in withdrawn:
        item = session.get(Item, one["item"])
        if item is None or not item.subject.startswith(REPLACED):
            continue
        taken = select(Item.id).where(
            Item.study_id == item.study_id, Item.task == item.task, Item.subject == one["subject"]
        )
        if session.scalar(taken) is None:
            item.subject = one["subject"]
            session.add_all(new_slots(item, one["slots"]))
            session.flush()


def _free_slot(session: Session, answer: Answer) -> None:
    mine = session.scalars(
        select(Slot).where(Slot.item_id == answer.item_id, Slot.person_id == answer.person_id)
    ).first()
    if mine is None:  # it came late: somebody else has its place
        session.add_all(new_slots(session.get_one(Item, answer.item_id), 1))
    else:
        mine.person_id, mine.expires_at, mine.answered = None, None, False


def _take_slot(session: Session, answer: Answer) -> bool:
    """Take a free place for an answer; return True if there was one."""
    free = session.scalars(
        select(Slot)
        .where(Slot.item_id == answer.item_id, Slot.answered.is_(False), Slot.person_id.is_(None))
        .limit(1)
        .with_for_update(skip_locked=True)
    ).first()
    if free is None:
        return False
    if answer.surplus:
        session.delete(free)
    else:
        free.person_id, free.expires_at, free.answered = answer.person_id, answer.at, True
    return True


def remark(
    session: Session,
    study: Study,
    answer: Answer,
    person: Person,
    *,
    kind: str,
    text: str = "",
    before: Record | None = None,
    now: float,
) -> None:
    """Keep a review step and its comment on an answer, here and in the audit trail."""
    session.add(
        Remark(
            answer_id=answer.id,
            person_id=person.id,
            kind=kind,
            text=text,
            before=before or {},
            at=now,
        )
    )
    note(session, name_of(person), f"{kind} an answer", study.name, answer=answer.id)
