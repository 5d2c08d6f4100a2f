"""Erasing a person's data, with everything that was made of their words."""

from __future__ import annotations

import re
import secrets
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, field
from itertools import chain, islice
from pathlib import Path
from typing import TypeVar

from sqlalchemy import ColumnElement, Engine, delete, func, or_, select, update
from sqlalchemy.orm import Session

from annotation_app.core.config import Config
from annotation_app.core.random_ids import read_code
from annotation_app.items.assignment import lock_person
from annotation_app.items.new_items import REPLACED, about_answer
from annotation_app.people.participants import hashed
from annotation_app.store import tombstones
from annotation_app.store.audit import COMMAND_LINE, SUBJECT_CHARACTERS, forget, note
from annotation_app.store.compaction import ask, compact_if_asked
from annotation_app.store.database import transaction
from annotation_app.store.models import (
    AccountLink,
    Answer,
    Assignment,
    Draft,
    Erasure,
    Event,
    Handout,
    Item,
    LedgerEntry,
    Participation,
    Person,
    Record,
    Remark,
    Slot,
)
from annotation_app.store.salt import installation_salt
from annotation_app.store.schema import check_current
from annotation_app.store.tombstones import ERASED_FILE, Tombstone, joined
from annotation_app.tasks.task_registry import find_task, makers
from g3.errors import FormatError

ERASED = "erased"
"""The provider of people whose data were erased."""
_BATCH = 500
_SUBJECT = re.compile(rf"[0-9a-f]{{{SUBJECT_CHARACTERS},64}}")
T = TypeVar("T")


@dataclass(slots=True)
class Traces:
    """Data of a person, and the data made of them."""

    person_id: str
    answers: list[int] = field(default_factory=list)
    """Ids of their own answers."""
    items: list[str] = field(default_factory=list)
    """Ids of items that show their words or what they marked, in the order they were found."""
    others: list[int] = field(default_factory=list)
    """Ids of other people's answers to those items."""
    drafts: int = 0
    events: int = 0
    """Number of the person's drafts and events."""
    participations: list[int] = field(default_factory=list)
    """Ids of their assignments at platforms that no payment refers to."""
    paid: list[int] = field(default_factory=list)
    """Ids of those that the books refer to: they stay."""
    unpaid: int = 0
    """Number of submitted assignments without a payment in the books."""
    has_profile: bool = False
    """True if they have filled in their profile."""

    def counts(self) -> Record:
        """Return the numbers of erased records, for the preview and for the audit trail."""
        return {
            "answers": len(self.answers),
            "drafts": self.drafts,
            "events": self.events,
            "items_made_of_them": len(self.items),
            "answers_of_others_to_these": len(self.others),
            "assignments": len(self.participations),
            "payments_kept": len(self.paid),
        }


@dataclass(frozen=True, slots=True)
class Done:
    """An erasure's result, and the file in which it was noted.

    If it `is_compacted`, the database's files hold nothing of it any more.
    """

    traces: Traces
    tombstones: Path
    is_compacted: bool


def preview(engine: Engine, config: Config, who: str, platform: str | None) -> Traces:
    """Return the data of a person; a FormatError unless exactly one person matches.

    `who` is their code, their name in exports, or their login; with a platform, their id there.
    """
    check_current(engine)
    wanted = _wanted(who)
    if platform is not None:
        digest = hashed(installation_salt(engine, config), platform, who)
        wanted = (Person.provider == platform) & (Person.external_hash == digest)
    with transaction(engine) as session:
        people = session.scalars(
            select(Person).where(wanted, Person.id.not_in(select(Erasure.person_id))).limit(2)
        ).all()
        if len(people) != 1:
            raise FormatError(
                "several people are meant" if people else "there is no such person",
                where=who[:100],
                fix="give the code that their pages show, what exports call them, or a login; "
                "for a worker's id at a platform give --platform too",
            )
        return traces_of(session, people[0])


def traces_of(session: Session, person: Person) -> Traces:
    """Return the data of a person. Nobody else changes them until the transaction ends.

    An item that shows their command, clauses or groundings is found by its payload and its subject
    (see `annotation_app.items.new_items`). So is what was made of other people's answers to it.
    """
    lock_person(session, person.id)
    traces = Traces(person.id)
    own = session.scalars(select(Answer).where(Answer.person_id == person.id).order_by(Answer.id))
    found = list(own)
    traces.answers = [answer.id for answer in found]
    known: set[str] = set()
    while found:
        new = [item for item in dict.fromkeys(_made_of(session, found)) if item not in known]
        known.update(new)
        traces.items += new
        answers = select(Answer).order_by(Answer.id)
        some = (session.scalars(answers.where(Answer.item_id.in_(ids))) for ids in _batches(new))
        found = list(chain.from_iterable(some))
        traces.others += [answer.id for answer in found if answer.person_id != person.id]
    traces.drafts = _count(session, Draft, person)
    traces.events = _count(session, Event, person)
    rows = session.scalars(select(Participation).where(Participation.person_id == person.id))
    for one in rows:
        (traces.paid if is_booked(session, one) else traces.participations).append(one.id)
        traces.unpaid += one.received_at is not None and one.id not in traces.paid
    traces.has_profile = bool(person.profile)
    return traces


def erase(session: Session, person: Person, *, now: float) -> Traces:
    """Erase a person's data, and everything that was made of their words.

    Their places become free for others. What was paid stays in the books. Nothing says who they
    were any more, and they are signed out.
    """
    traces = traces_of(session, person)
    _delete_items(session, traces.items)
    own = person.id
    _delete_remarks(session, Answer.person_id == own)
    session.execute(update(Remark).where(Remark.person_id == own).values(text=""))
    session.execute(delete(Answer).where(Answer.person_id == own))
    for table in (Event, Draft, Handout, Assignment):
        session.execute(delete(table).where(table.person_id == own))
    of_attention = select(Item.id).where(Item.attention)
    session.execute(delete(Slot).where(Slot.person_id == own, Slot.item_id.in_(of_attention)))
    session.execute(
        update(Slot)
        .where(Slot.person_id == own)
        .values(person_id=None, expires_at=None, answered=False)
    )
    session.execute(update(Item).where(Item.author_id == own).values(author_id=None))
    session.execute(delete(AccountLink).where(AccountLink.person_id == own))
    for ids in _batches(traces.participations):
        session.execute(delete(Participation).where(Participation.id.in_(ids)))
    forget(session, person)
    unlink(person)
    person.profile, person.role, person.blocked_at = {}, "worker", None
    session.merge(Erasure(person_id=own, at=now))
    ask(session)
    session.flush()
    return traces


def erase_person(engine: Engine, config: Config, person_id: str, *, now: float) -> Done:
    """Erase a person's data from the database and its files, and note that it was done.

    The audit trail names the random id by which the database knew them, which nothing leads to
    any more, and how much was erased.
    """
    with transaction(engine) as session:
        person = session.get_one(Person, person_id, with_for_update=True)
        traces = erase(session, person, now=now)
        note(session, COMMAND_LINE, "erased a person's data", person_id, **traces.counts())
    tombstones.keep(engine, config.instance)
    return Done(traces, config.instance / ERASED_FILE, compact_if_asked(engine))


def unlink(person: Person) -> None:
    """Let nothing show who a person is: no id of a platform, no login, no code, no session."""
    person.provider, person.external_hash = ERASED, secrets.token_hex(32)
    person.login = person.password_hash = person.code = None
    person.session_number += 1


def erase_again(session: Session, gone: Collection[Tombstone]) -> int:
    """Erase those whose data were erased after a backup was made, which has just been restored.

    The number of them that it had data of is returned.
    """
    before = {row.person_id for row in session.scalars(select(Erasure))}
    wanted = joined(gone)
    count = 0
    for tombstone in wanted.values():
        if tombstone.person in before:
            continue
        person = session.get(Person, tombstone.person)
        if person is None:
            session.merge(Erasure(person_id=tombstone.person, at=tombstone.at))
            continue
        counts = erase(session, person, now=tombstone.at).counts()
        note(session, COMMAND_LINE, "erased a person's data again", person.id, **counts)
        count += 1
    session.flush()
    return count


def _wanted(who: str) -> ColumnElement[bool]:
    given = who.strip()
    meant = [Person.login == given.casefold()]
    code = read_code(given)
    if code is not None:
        meant.append(Person.code == code)
    if _SUBJECT.fullmatch(given.lower()):
        meant.append(Person.external_hash.startswith(given.lower(), autoescape=True))
    return or_(*meant)


def _made_of(session: Session, answers: Iterable[Answer]) -> Iterator[str]:
    """Return the ids of items that were made of answers, locked."""
    answers = list(answers)
    command = Item.payload["command"].as_integer()
    for some in _batches(answers):
        yield from _locked(session, command.in_([answer.id for answer in some]))
        yield from _locked(session, Item.subject.in_(map(about_answer, some)))
    for answer in answers:
        yield from _withdrawn(session, answer)


def _withdrawn(session: Session, answer: Answer) -> Iterator[str]:
    """Yield items made of an answer before its replacement, which their subject no longer shows.

    They show its command, and clauses or groundings that nobody else's answer accounts for.
    """
    task = find_task(answer.task)
    makes = () if task is None or task.adjudication is None else makers(task.gives)
    item = session.get_one(Item, answer.item_id)
    number = item.payload.get("command")
    if not makes or number is None:
        return
    others = session.scalars(
        select(Answer).where(Answer.item_id == item.id, Answer.person_id != answer.person_id)
    ).all()
    rows = session.scalars(
        select(Item).where(
            Item.payload["command"].as_integer() == number,
            Item.task.in_([maker.name for maker in makes]),
            Item.subject.startswith(REPLACED),
        )
    ).all()
    shows = {
        maker.name: source.shows
        for maker in makes
        for source in maker.sources
        if task is not None and source.made_of == task.gives
    }
    for row in rows:
        if not any(shows[row.task](row.payload, other) for other in others):
            yield from _locked(session, Item.id == row.id)


def _locked(session: Session, *where: ColumnElement[bool]) -> list[str]:
    # Nobody answers them meanwhile.
    return list(session.scalars(select(Item.id).where(*where).order_by(Item.id).with_for_update()))


def _delete_items(session: Session, items: Iterable[str]) -> None:
    for ids in _batches(items):
        _delete_remarks(session, Answer.item_id.in_(ids))
        for table in (Answer, Event, Draft, Handout, Slot, Assignment):
            session.execute(delete(table).where(table.item_id.in_(ids)))
        session.execute(delete(Item).where(Item.id.in_(ids)))


def _delete_remarks(session: Session, about: ColumnElement[bool]) -> None:
    """Delete remarks about answers, as they may quote them."""
    answers = select(Answer.id).where(about)
    session.execute(delete(Remark).where(Remark.answer_id.in_(answers)))


def is_booked(session: Session, one: Participation) -> bool:
    """Check that the books refer to an assignment: then it stays."""
    refers = or_(
        LedgerEntry.participation_id == one.id,
        (LedgerEntry.provider == one.provider) & (LedgerEntry.assignment == one.assignment),
    )
    return session.scalar(select(LedgerEntry.id).where(refers).limit(1)) is not None


def _count(session: Session, table: type[Draft | Event], person: Person) -> int:
    counted = select(func.count()).select_from(table).where(table.person_id == person.id)
    return session.scalar(counted) or 0


def _batches(values: Iterable[T]) -> Iterator[list[T]]:
    left = iter(values)
    while batch := list(islice(left, _BATCH)):
        yield batch
