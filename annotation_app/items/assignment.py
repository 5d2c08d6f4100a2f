"""Assignment of items to people: slots are leased for a time, on any database."""

from __future__ import annotations

import functools
import random
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, TypeAlias

from sqlalchemy import (
    BindParameter,
    ColumnElement,
    Float,
    UpdateBase,
    and_,
    bindparam,
    case,
    exists,
    func,
    or_,
    select,
    union,
    update,
)
from sqlalchemy.orm import Session
from sqlalchemy.sql.dml import ReturningUpdate

from annotation_app.items.elapsed import since_boot
from annotation_app.store.database import core, dialect_of, inserting
from annotation_app.store.models import (
    Answer,
    Assignment,
    Handout,
    Item,
    Person,
    Record,
    Slot,
    Study,
    TaskName,
    queue_of,
)

Reason: TypeAlias = Literal["done", "blocked", "all taken", "nothing to do"]
"""Reason for handing out no item: everything is done for this person, they may not take part,
others are at work on what is left, or there is nothing (left) in the study."""


_TABLES = (Answer, Assignment, Handout, Item, Person, Slot, Study)
ANSWER, ASSIGNED, HANDOUT, ITEM, PERSON, SLOT, STUDY = map(core, _TABLES)

# Statements are built once: that takes several times as long as to run them.
_STUDY: BindParameter[str] = bindparam("of_study")
_TASK: BindParameter[str] = bindparam("of_task")
_WHO: BindParameter[str] = bindparam("who")
_NUMBER: BindParameter[int] = bindparam("number")
_ITEM_ID: BindParameter[str] = bindparam("item")
_NOW: BindParameter[float] = bindparam("at_present")
_UNTIL: BindParameter[float] = bindparam("until", type_=Float)
_LATEST: BindParameter[float] = bindparam("latest", type_=Float)
_QUEUE: BindParameter[str] = bindparam("of_queue")
_PLACE: BindParameter[float] = bindparam("place", type_=Float)
_TASKS: BindParameter[Any] = bindparam("of_tasks", expanding=True)
_HAS_ANSWERED = exists().where(
    ANSWER.c.person_id == _WHO,
    ANSWER.c.task == ITEM.c.task,
    ANSWER.c.subject == ITEM.c.subject,
)
SLACK_S = 3600.0
"""Largest credible time by which an earlier lease may outlast a new one, in seconds."""


@dataclass(frozen=True, slots=True)
class Lease:
    """An item that is somebody's until a time."""

    item_id: str
    expires_at: float


class Work(NamedTuple):
    """An item that is or was somebody's, and its study.

    It has what :class:`~annotation_app.store.models.Item` has and people's requests need: objects
    of the database's own take several times as long to make.
    """

    who: str
    id: str
    task: TaskName
    subject: str
    study_id: str
    study_name: str
    payload: Record
    config: Record
    attention: bool


AnyItem: TypeAlias = Item | Work


def lock_person(session: Session, person_id: str) -> None:
    """Let no other transaction do anything for a person until this one ends."""
    if dialect_of(session) != "sqlite":  # there is one writer at a time
        session.execute(_LOCK, {"who": person_id})


def take(
    session: Session,
    study_id: str,
    task: TaskName,
    person: Person,
    *,
    now: float,
    lease_s: float,
    hold_s: float | None = None,
    attention_share: float = 0.0,
    in_random_order: bool = False,
) -> Lease | Reason:
    """Give a person an item to work on: the item that they already have, if any.

    A slot is free if it is neither answered nor leased. Nobody gets an item whose subject
    they have answered, which they have skipped, or of which they are the author. One
    statement finds a slot and takes it, passing by those that others are taking.

    Parameters
    ----------
    hold_s
        Seconds that they have it if they do nothing, where that is less than `lease_s`. A lease
        that lasts longer already isn't made shorter.
    attention_share
        Part of a person's items whose right answers are known.
    in_random_order
        True if any item may come first, rather than the item of the lowest rank.
    """
    lock_person(session, person.id)
    if person.blocked_at is not None:
        return "blocked"
    about = {"of_study": study_id, "of_task": task, "who": person.id}
    until = now + (lease_s if hold_s is None else min(hold_s, lease_s))
    times = {"at_present": now, "until": until, "latest": now + lease_s}
    queue = {**about, **times, "of_queue": queue_of(study_id, task), "place": 0.0}
    held = session.execute(_HELD, queue).all()
    if held:
        _, item_id = min(held)
        kept = session.scalar(_HOLD, {"item": item_id, "who": person.id, **times})
        if kept is not None:
            return Lease(item_id, kept)
    if _wants_attention(session, about, attention_share):
        item_id = session.scalar(_ATTENTION, about)
        if item_id is not None:  # with a slot of the person's own
            session.add(
                Slot(
                    item_id=item_id,
                    queue=queue["of_queue"],
                    person_id=person.id,
                    expires_at=until,
                )
            )
            return _handed_out(session, item_id, person, now=now, until=until)
    taken = _take_any(session, queue) if in_random_order else session.scalar(_TAKE, queue)
    if taken is None:
        return _reason(session, queue)
    return _handed_out(session, taken, person, now=now, until=until)


def _take_any(session: Session, queue: Mapping[str, Any]) -> str | None:
    """Take a slot at random.

    The slots' lots are drawn independently of everything, so the first one after a random
    place, or else the first one of all, is as likely any of them as another.
    """
    after = session.scalar(_TAKE_ANY, {**queue, "place": random.random()})  # noqa: S311 - no secret
    return after or session.scalar(_TAKE_ANY, queue)


def skip(session: Session, item_id: str, who: str, *, now: float) -> None:
    """Give an item back that somebody has and hasn't answered, and won't get again."""
    about = {"item": item_id, "who": who, "at_present": now}
    session.execute(_GIVE_BACK, about)
    session.execute(_SKIP, about)


def extend(session: Session, item_id: str, who: str, *, now: float, lease_s: float) -> bool:
    """Lease an item on to its holder; return True if they still had it."""
    about = {"item": item_id, "who": who, "until": now + lease_s}
    return session.scalar(_EXTEND, about) is not None


def handed_out(session: Session, item_id: str, who: str, number: int) -> Work | None:
    """Return a person's item, present or past, whose session of that number hasn't ended."""
    about = {"item": item_id, "who": who, "number": number}
    found = session.execute(_HANDED_OUT, about).first()
    return None if found is None else Work(who, *found)


def still_open(
    session: Session, study_id: str, who: str, among: Iterable[TaskName]
) -> Mapping[TaskName, int]:
    """Count the items per task that a person has or may yet get, without attention checks.

    The open ones are counted in an index, less those that aren't for the person. To ask of each
    item whether the person may get it takes longer the more items there are.
    """
    tasks = list(among)
    about = {"of_study": study_id, "who": who, "of_tasks": tasks}
    of_others = {(study, task): n for study, task, n in session.execute(_OF_OTHERS, about)}
    queues = {queue_of(study_id, task): task for task in tasks}
    found = session.execute(_OPEN_ITEMS, {"of_queues": list(queues)})
    return {queues[queue]: n - of_others.get((study_id, queues[queue]), 0) for queue, n in found}


def is_free(now: BindParameter[float]) -> tuple[ColumnElement[bool], ...]:
    """Return the conditions of slots that are neither answered nor leased."""
    return SLOT.c.answered.is_(False), or_(SLOT.c.person_id.is_(None), SLOT.c.expires_at < now)


def _can_be_taken() -> tuple[ColumnElement[bool], ...]:
    """Return the conditions of slots that are free, also after the clock was set back.

    A lease that ends long after a new one would was made while the clock was ahead.
    """
    unanswered, free = is_free(_NOW)
    return unanswered, or_(free, SLOT.c.expires_at > _LATEST + SLACK_S)


def _handed_out(
    session: Session, item_id: str, person: Person, *, now: float, until: float
) -> Lease:
    given = {"item": item_id, "who": person.id, "at_present": now, **since_boot()}
    session.execute(_hand_out(dialect_of(session)), given)
    return Lease(item_id, until)


def _wants_attention(session: Session, about: Mapping[str, str], share: float) -> bool:
    """Check that a person has had fewer attention checks than `share` of their answers."""
    if not share:
        return False
    done, checks = session.execute(_DONE, about).one()
    return bool(checks < int((done + 1) * share))


def _is_new() -> tuple[ColumnElement[bool], ...]:
    """Return the conditions of items that a person may get, if there is a free slot."""
    other = SLOT.alias()
    return (
        or_(ITEM.c.author_id.is_(None), ITEM.c.author_id != _WHO),
        ~exists().where(other.c.item_id == ITEM.c.id, other.c.person_id == _WHO),
        ~exists().where(
            HANDOUT.c.item_id == ITEM.c.id,
            HANDOUT.c.person_id == _WHO,
            HANDOUT.c.skipped_at.is_not(None),
        ),
        ~_HAS_ANSWERED,
        ~_IS_OF_OTHERS,
    )


_TO_ITEM = ASSIGNED.c.item_id == ITEM.c.id
_IS_OF_OTHERS = and_(
    exists().where(_TO_ITEM), ~exists().where(_TO_ITEM, ASSIGNED.c.person_id == _WHO)
)
_OF_TASK = (ITEM.c.study_id == _STUDY, ITEM.c.task == _TASK)
_OWN = (SLOT.c.item_id == _ITEM_ID, SLOT.c.person_id == _WHO, SLOT.c.answered.is_(False))


def _take(*order: ColumnElement[Any]) -> ReturningUpdate[str]:
    """Take the first free slot, of those that come at or after a place in an order.

    An index of the unanswered slots has the order, so that the number of them hardly matters.
    """
    free = (
        select(SLOT.c.id)
        .join(ITEM)
        .where(SLOT.c.queue == _QUEUE, order[0] >= _PLACE, ITEM.c.attention.is_(False))
        .where(*_can_be_taken(), *_is_new())
        .order_by(*order)
        .limit(1)
        .with_for_update(of=SLOT, skip_locked=True)
    )
    return (
        update(SLOT)
        .where(SLOT.c.id == free.scalar_subquery(), *_can_be_taken())
        .values(person_id=_WHO, expires_at=_UNTIL)
        .returning(SLOT.c.item_id)
    )


_TAKE = _take(SLOT.c.rank, SLOT.c.item_id)
_TAKE_ANY = _take(SLOT.c.lot)
_LOCK = select(PERSON.c.id).where(PERSON.c.id == _WHO).with_for_update()
_EXTEND = update(SLOT).where(*_OWN).values(expires_at=_UNTIL).returning(SLOT.c.id)
# What ends after the latest time that a new lease may end was made while the clock was ahead.
_HOLD = (
    update(SLOT)
    .where(*_OWN)
    .values(
        expires_at=case(
            (SLOT.c.expires_at.between(_UNTIL, _LATEST), SLOT.c.expires_at), else_=_UNTIL
        )
    )
    .returning(SLOT.c.expires_at)
)
_GIVE_BACK = update(SLOT).where(*_OWN).values(person_id=None, expires_at=None)
_SKIP = (
    update(HANDOUT)
    .where(HANDOUT.c.item_id == _ITEM_ID, HANDOUT.c.person_id == _WHO)
    .values(skipped_at=_NOW)
)
# An index has the answers of a study by person and task.
_OWN_ANSWERS = (ANSWER.c.study_id == _STUDY, ANSWER.c.person_id == _WHO, ANSWER.c.task == _TASK)
_DONE = select(func.count(), func.count().filter(ANSWER.c.kind == "attention")).where(*_OWN_ANSWERS)
_ATTENTION = (
    select(ITEM.c.id)
    .where(*_OF_TASK, ITEM.c.attention, *_is_new())
    .order_by(func.random())
    .limit(1)
)
_UNANSWERED = (
    select(SLOT.c.id)
    .join(ITEM)
    .where(SLOT.c.queue == _QUEUE, ITEM.c.attention.is_(False), SLOT.c.answered.is_(False))
    .limit(1)
)
_UNANSWERED_NEW = _UNANSWERED.where(*_is_new())
_ANSWERED = select(ANSWER.c.id).where(*_OWN_ANSWERS).limit(1)
_HELD = select(SLOT.c.rank, SLOT.c.item_id).where(
    SLOT.c.queue == _QUEUE, SLOT.c.person_id == _WHO, SLOT.c.answered.is_(False)
)
_OPEN = exists().where(SLOT.c.item_id == ITEM.c.id, SLOT.c.answered.is_(False))
_OPEN_SLOTS = (
    select(SLOT.c.queue, SLOT.c.rank, SLOT.c.item_id)
    .where(SLOT.c.queue.in_(bindparam("of_queues", expanding=True)), SLOT.c.answered.is_(False))
    .distinct()
    .subquery()
)
_OPEN_ITEMS = select(_OPEN_SLOTS.c.queue, func.count()).group_by(_OPEN_SLOTS.c.queue)
_NOT_FOR_THEM = union(
    select(ITEM.c.id).where(ITEM.c.study_id == _STUDY, ITEM.c.attention.is_(True)),
    select(ITEM.c.id).where(ITEM.c.author_id == _WHO),
    select(SLOT.c.item_id).where(SLOT.c.person_id == _WHO),
    select(HANDOUT.c.item_id).where(HANDOUT.c.person_id == _WHO, HANDOUT.c.skipped_at.is_not(None)),
    select(ASSIGNED.c.item_id).where(
        ASSIGNED.c.item_id.not_in(select(ASSIGNED.c.item_id).where(ASSIGNED.c.person_id == _WHO))
    ),
    # First by subjects that the person knows, which is an index's order.
    select(ITEM.c.id).where(
        ITEM.c.study_id == _STUDY,
        ITEM.c.task.in_(_TASKS),
        ITEM.c.subject.in_(select(ANSWER.c.subject).where(ANSWER.c.person_id == _WHO)),
        _HAS_ANSWERED,
    ),
)
_OF_OTHERS = (
    # Whoever asks for the study here makes SQLite look at all its items.
    select(ITEM.c.study_id, ITEM.c.task, func.count())
    .where(
        ITEM.c.id.in_(_NOT_FOR_THEM),
        _OPEN,
        or_(ITEM.c.attention.is_(True), ~_OPEN.where(SLOT.c.person_id == _WHO)),
    )
    .group_by(ITEM.c.study_id, ITEM.c.task)
)
_HANDED_OUT = (
    select(
        ITEM.c.id,
        ITEM.c.task,
        ITEM.c.subject,
        STUDY.c.id,
        STUDY.c.name,
        ITEM.c.payload,
        STUDY.c.config,
        ITEM.c.attention,
    )
    .select_from(HANDOUT)
    .join(ITEM, ITEM.c.id == HANDOUT.c.item_id)
    .join(STUDY, STUDY.c.id == ITEM.c.study_id)
    .join(PERSON, PERSON.c.id == HANDOUT.c.person_id)
    .where(
        HANDOUT.c.item_id == _ITEM_ID,
        HANDOUT.c.person_id == _WHO,
        PERSON.c.session_number == _NUMBER,
    )
)


@functools.cache
def _hand_out(dialect: str) -> UpdateBase:
    read: dict[str, BindParameter[Any]] = {n: bindparam(n) for n in ("boot", "since_boot_s")}
    given = {"item_id": _ITEM_ID, "person_id": _WHO, "at": _NOW, **read}
    statement: UpdateBase = inserting(dialect, Handout).values(given).on_conflict_do_nothing()
    return statement.returning(HANDOUT.c.at)


def _reason(session: Session, about: Mapping[str, Any]) -> Reason:
    if session.scalar(_UNANSWERED_NEW, about) is not None:
        return "all taken"
    if session.scalar(_ANSWERED, about) is not None:
        return "done"
    return "nothing to do" if session.scalar(_UNANSWERED, about) is None else "done"
