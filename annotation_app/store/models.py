"""The database: studies, items, who works on them, and everything that people sent.

:class:`Event` is the truth, as it came; :class:`Answer` is derived from it. An item
has as many :class:`Slot` rows as it wants answers, so that a quota can't be exceeded. A
slot is leased to somebody, and then filled by an answer or taken by somebody else.
Times are seconds since 1970 in UTC.
"""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any, ClassVar, Literal, TypeAlias

from sqlalchemy import (
    JSON,
    CheckConstraint,
    ForeignKey,
    Index,
    LargeBinary,
    String,
    Text,
    UniqueConstraint,
    cast,
    text,
)
from sqlalchemy.engine.default import DefaultExecutionContext
from sqlalchemy.orm import DeclarativeBase, Mapped, mapped_column, relationship

TaskName: TypeAlias = str
"""The name of a task: :mod:`annotation_app.tasks.task_registry` has the tasks."""

Role: TypeAlias = Literal["worker", "annotator", "adjudicator", "admin"]

Record: TypeAlias = dict[str, Any]
"""A JSON object."""


def _of_some_rows(name: str, *columns: str, where: str, on_sqlite: str = "") -> Index:
    """Return an index of few rows; it is used where a statement has its very condition."""
    sqlite = text(on_sqlite or where)
    return Index(name, *columns, sqlite_where=sqlite, postgresql_where=text(where))


class Base(DeclarativeBase):
    """Base class of all tables."""

    type_annotation_map: ClassVar[dict[Any, Any]] = {Record: JSON, str: String(200)}


class Study(Base):
    """A study: its tasks and people; ``config`` is the study file."""

    __tablename__ = "study"

    id: Mapped[str] = mapped_column(primary_key=True)
    name: Mapped[str] = mapped_column(unique=True)
    config: Mapped[Record]
    created_at: Mapped[float]
    closed_at: Mapped[float | None]
    file: Mapped[str | None] = mapped_column(String(4000))
    """Path of the study file; None if the study was made of something else."""


class Media(Base):
    """A file that people may see, under a name that says nothing about what it shows."""

    __tablename__ = "media"
    __table_args__ = (UniqueConstraint("study_id", "video", "role"),)

    id: Mapped[str] = mapped_column(primary_key=True)
    study_id: Mapped[str] = mapped_column(ForeignKey("study.id"))
    video: Mapped[str]
    role: Mapped[str]
    path: Mapped[str] = mapped_column(String(4000))
    sha256: Mapped[str]


def _of_payload(key: str, length: int) -> Callable[[DefaultExecutionContext], str]:
    """Return a default from a new item's payload at a key, for a column that can be searched."""

    def found(context: DefaultExecutionContext) -> str:
        parameters: Record = context.get_current_parameters()  # type: ignore[no-untyped-call]
        return str(parameters["payload"].get(key, ""))[:length]

    return found


class Item(Base):
    """Work for some people: a video to describe, a command to segment.

    ``subject`` is what it is about: nobody answers a task about a subject twice.
    """

    __tablename__ = "item"
    __table_args__ = (
        UniqueConstraint("study_id", "task", "subject"),
        Index("ix_item_video", "study_id", "video"),
        Index("ix_item_progress", "study_id", "attention", "task", "video", "id"),
        Index("ix_item_author", "author_id"),
        _of_some_rows(
            "ix_item_attention",
            "study_id",
            where="attention IS true",
            on_sqlite="attention IS 1",
        ),
    )

    id: Mapped[str] = mapped_column(primary_key=True)
    study_id: Mapped[str] = mapped_column(ForeignKey("study.id"))
    task: Mapped[TaskName] = mapped_column(String(20))
    subject: Mapped[str] = mapped_column(String(500))
    payload: Mapped[Record]
    """Server's data of the item; its task shows people their part."""
    rank: Mapped[float]
    """Items with a lower rank are given out first; its slots know it too."""
    video: Mapped[str] = mapped_column(default=_of_payload("video", 200), server_default="")
    """Name of the video as in the payload, for searches: they read no JSON."""
    command: Mapped[str] = mapped_column(
        String(2000), default=_of_payload("text", 2000), server_default=""
    )
    """The payload's ``"text"``, for searches."""
    author_id: Mapped[str | None] = mapped_column(ForeignKey("person.id"))
    """Person who must not get it: nobody rates their own command."""
    attention: Mapped[bool] = mapped_column(default=False, server_default=text("false"))
    """True if the right answer is known. Such items are given to everybody, without quota."""

    slots: Mapped[list[Slot]] = relationship(back_populates="item")


class Person(Base):
    """A person who works on items. Ids at a crowd platform are stored as salted hashes."""

    __tablename__ = "person"
    __table_args__ = (UniqueConstraint("provider", "external_hash"),)

    id: Mapped[str] = mapped_column(primary_key=True)
    role: Mapped[Role] = mapped_column(String(20))
    provider: Mapped[str]
    external_hash: Mapped[str]
    login: Mapped[str | None] = mapped_column(unique=True)
    password_hash: Mapped[str | None]
    profile: Mapped[Record]
    """Consent, demographics, which practice examples are done."""
    created_at: Mapped[float]
    blocked_at: Mapped[float | None]
    session_number: Mapped[int] = mapped_column(default=1, server_default=text("1"))
    """Cookies with another number sign nobody in: raising it ends all sessions of a person."""
    code: Mapped[str | None] = mapped_column(unique=True)
    """Code that lets the person have their data erased without revealing their name."""


def queue_of(study_id: str, task: TaskName) -> str:
    """Return the common name of the slots of a study's task."""
    return f"{study_id} {task}"


def _of_open_slots(name: str, *columns: str) -> Index:
    """Return an index of the slots that wait for an answer, which are fewer and fewer."""
    return _of_some_rows(name, *columns, where="answered IS false", on_sqlite="answered IS 0")


class Slot(Base):
    """Room for one answer to an item."""

    __tablename__ = "slot"
    __table_args__ = (
        UniqueConstraint("item_id", "person_id"),
        Index("ix_slot_free", "item_id", "answered", "expires_at"),
        Index("ix_slot_person", "person_id", "queue"),
        _of_open_slots("ix_slot_rank", "queue", "rank", "item_id"),
        _of_open_slots("ix_slot_lot", "queue", "lot"),
        CheckConstraint("(person_id IS NULL) = (expires_at IS NULL)", name="leased_until"),
    )

    id: Mapped[int] = mapped_column(primary_key=True, autoincrement=True)
    item_id: Mapped[str] = mapped_column(ForeignKey("item.id"))
    person_id: Mapped[str | None] = mapped_column(ForeignKey("person.id"))
    expires_at: Mapped[float | None]
    answered: Mapped[bool] = mapped_column(default=False, server_default=text("false"))
    queue: Mapped[str] = mapped_column(server_default="")
    """The item's study and task, here so that one index leads to the next free slot."""
    rank: Mapped[float] = mapped_column(server_default=text("0"))
    """The item's rank."""
    lot: Mapped[float] = mapped_column(default=random.random, server_default=text("0"))
    """Drawn at random: who is given any item begins to look at a random number."""

    item: Mapped[Item] = relationship(back_populates="slots")


class Handout(Base):
    """An item handed to a person, who may answer it ever after."""

    __tablename__ = "handout"
    __table_args__ = (
        _of_some_rows(
            "ix_handout_skipped",
            "person_id",
            where="skipped_at IS NOT NULL",
        ),
    )

    item_id: Mapped[str] = mapped_column(ForeignKey("item.id"), primary_key=True)
    person_id: Mapped[str] = mapped_column(ForeignKey("person.id"), primary_key=True)
    at: Mapped[float]
    skipped_at: Mapped[float | None]
    boot: Mapped[str | None]
    """Run of the machine on which the time since its boot was read."""
    since_boot_s: Mapped[float | None]
    """Monotonic, so that a change of the machine's clock doesn't change how long an answer took."""
    offer: Mapped[Record | None]
    """Suggestion of a program, and whether the person saw it (`annotation_app.work.page_data`)."""


class Assignment(Base):
    """An item that only some people get: those with such a row."""

    __tablename__ = "assignment"

    item_id: Mapped[str] = mapped_column(ForeignKey("item.id"), primary_key=True)
    person_id: Mapped[str] = mapped_column(ForeignKey("person.id"), primary_key=True, index=True)


class Event(Base):
    """A sent event, as it came.

    Rows are never changed, and deleted only when a person's data are erased.

    ``uuid`` is made by the sender's browser: the same event sent twice is kept once.
    """

    __tablename__ = "event"
    __table_args__ = (UniqueConstraint("person_id", "uuid"),)

    id: Mapped[int] = mapped_column(primary_key=True, autoincrement=True)
    uuid: Mapped[str]
    item_id: Mapped[str] = mapped_column(ForeignKey("item.id"), index=True)
    person_id: Mapped[str] = mapped_column(ForeignKey("person.id"))
    name: Mapped[Literal["submit", "skip", "flag", "adjudicate", "ask"]] = mapped_column(String(20))
    """``ask`` is an adjudicator's wish for one more answer."""
    body: Mapped[Record]
    at: Mapped[float]


LONGEST_GIST = 1000


class Answer(Base):
    """A person's answer to an item.

    Surplus answers came after the lease had run out and its slot had gone to somebody
    else. They are kept and don't count for the quota.
    """

    __tablename__ = "answer"
    __table_args__ = (
        UniqueConstraint("item_id", "person_id"),
        UniqueConstraint("person_id", "task", "subject"),
        # The dashboard counts in these alone, mostly in their order.
        Index("ix_answer_people", "study_id", "person_id", "task", "gist", "kind", "seconds"),
        Index("ix_answer_times", "study_id", "task", "kind", "excluded", "at"),
        Index("ix_answer_seconds", "study_id", "task", "excluded", "seconds"),
        Index("ix_answer_items", "study_id", "task", "kind", "excluded", "item_id", "gist"),
        Index(
            "ix_answer_gists",
            "study_id",
            "task",
            "gist",
            "adopted",
            "kind",
            "excluded",
            "surplus",
        ),
        _of_some_rows(
            "ix_answer_whole",
            "study_id",
            "task",
            where="gist IS NULL",
        ),
        _of_some_rows(
            "ix_answer_odd",
            "study_id",
            where="odd_below_s IS NULL OR seconds < odd_below_s",
        ),
    )

    id: Mapped[int] = mapped_column(primary_key=True, autoincrement=True)
    item_id: Mapped[str] = mapped_column(ForeignKey("item.id"))
    study_id: Mapped[str] = mapped_column(server_default="")
    """The item's."""
    kind: Mapped[Literal["usual", "attention", "adjudicated"]] = mapped_column(
        String(20), server_default="usual"
    )
    """``attention`` is to an attention check, ``adjudicated`` that of somebody who decides."""
    person_id: Mapped[str] = mapped_column(ForeignKey("person.id"))
    task: Mapped[TaskName] = mapped_column(String(20))
    subject: Mapped[str] = mapped_column(String(500))
    event_id: Mapped[int] = mapped_column(ForeignKey("event.id"), unique=True)
    body: Mapped[Record]
    gist: Mapped[str | None] = mapped_column(String(LONGEST_GIST))
    """The part of the body that is counted and compared, as JSON; None if that is all of it."""
    surplus: Mapped[bool]
    adopted: Mapped[bool] = mapped_column(default=False, server_default=text("false"))
    """True if the next task's items, and exports, are made of it."""
    excluded: Mapped[bool] = mapped_column(default=False, server_default=text("false"))
    """True if somebody has excluded it; the last :class:`Remark` gives the reason."""
    seconds: Mapped[float | None]
    """Time for which the item was with the person; None where the clocks don't show it."""
    odd_below_s: Mapped[float | None]
    """An answer that took as long isn't odd (`annotation_app.work.answer_flags`)."""
    provenance: Mapped[Record | None]
    """Use of a suggestion: whether it was shown, and kept (`annotation_app.work.page_data`)."""
    at: Mapped[float]


BODY_TEXT = cast(Answer.body, Text)
"""Bodies as they are kept: equal texts need decoding once."""


class Remark(Base):
    """A reviewer's action on an answer, and remark about it."""

    __tablename__ = "remark"

    id: Mapped[int] = mapped_column(primary_key=True, autoincrement=True)
    answer_id: Mapped[int] = mapped_column(ForeignKey("answer.id"), index=True)
    person_id: Mapped[str] = mapped_column(ForeignKey("person.id"))
    kind: Mapped[Literal["excluded", "had redone", "restored", "commented", "adopted"]] = (
        mapped_column(String(20))
    )
    text: Mapped[str] = mapped_column(String(2000))
    before: Mapped[Record]
    """State before an exclusion, so that it can be restored."""
    at: Mapped[float]


class Draft(Base):
    """An unfinished answer; it is deleted when its author's answer comes."""

    __tablename__ = "draft"

    item_id: Mapped[str] = mapped_column(ForeignKey("item.id"), primary_key=True)
    person_id: Mapped[str] = mapped_column(ForeignKey("person.id"), primary_key=True)
    revision: Mapped[int]
    body: Mapped[Record]
    at: Mapped[float]


class AccountLink(Base):
    """A link that can be used once: makes the first admin, makes a login, sets a new password.

    Only its digest is kept, so that a copy of the database opens nothing.
    """

    __tablename__ = "account_link"

    digest: Mapped[str] = mapped_column(primary_key=True)
    purpose: Mapped[Literal["first admin", "invite", "reset"]] = mapped_column(String(20))
    role: Mapped[Role | None] = mapped_column(String(20))
    person_id: Mapped[str | None] = mapped_column(ForeignKey("person.id"))
    """Person whose password is set."""
    made_by: Mapped[str]
    made_at: Mapped[float]
    expires_at: Mapped[float]


class FailedSignIn(Base):
    """Number of wrong passwords in a row: for a login, or from an address."""

    __tablename__ = "failed_sign_in"

    whose: Mapped[str] = mapped_column(primary_key=True)
    """A hash of the login or of the address."""
    count: Mapped[int]
    last_at: Mapped[float]


class AuditEntry(Base):
    """An action that others may have to account for, and its actor.

    Rows are never deleted, and changed only when a person's data are erased: it names them by
    their random id then.
    """

    __tablename__ = "audit"

    id: Mapped[int] = mapped_column(primary_key=True, autoincrement=True)
    at: Mapped[float] = mapped_column(index=True)
    actor: Mapped[str]
    """A login; "command line" where it was done on the machine."""
    action: Mapped[str] = mapped_column(String(40))
    about: Mapped[str]
    """A study, a login, a subject."""
    details: Mapped[Record]


class Erasure(Base):
    """An erasure of a person's data, so that it can be repeated in a restored backup."""

    __tablename__ = "erasure"

    person_id: Mapped[str] = mapped_column(primary_key=True)
    at: Mapped[float]


class Secret(Base):
    """A secret of this installation by name. The salt of people's ids is in the key file."""

    __tablename__ = "secret"

    name: Mapped[str] = mapped_column(primary_key=True)
    value: Mapped[bytes] = mapped_column(LargeBinary)


class Participation(Base):
    """A person's assignment at a crowd platform: received here, and confirmed there."""

    __tablename__ = "participation"
    __table_args__ = (UniqueConstraint("provider", "assignment"),)

    id: Mapped[int] = mapped_column(primary_key=True, autoincrement=True)
    study_id: Mapped[str] = mapped_column(ForeignKey("study.id"))
    person_id: Mapped[str] = mapped_column(ForeignKey("person.id"))
    provider: Mapped[str]
    assignment: Mapped[str]
    """The platform's id of the assignment, which says nothing about the person."""
    task: Mapped[TaskName] = mapped_column(String(20))
    items: Mapped[int]
    """Number of items of the task in the assignment."""
    code: Mapped[str | None]
    begun_at: Mapped[float]
    received_at: Mapped[float | None]
    confirmed_at: Mapped[float | None]
    standing: Mapped[
        Literal["working", "submitted", "approved", "rejected", "returned", "unknown"] | None
    ] = mapped_column(String(20))
    """Platform's last status: ``unknown`` if it has no such one, None without a comparison."""
    outcome: Mapped[Record]
    """Further details: the address to send the worker back to, or that no items were left."""


class LedgerEntry(Base):
    """A call to a platform that offers work, approves, rejects or pays, noted before it is made.

    A platform's offer or payment that wasn't made from here is noted when it is discovered.

    Rows are never deleted, also not when a person's data are erased: books must be kept.
    """

    __tablename__ = "ledger"
    __table_args__ = (UniqueConstraint("provider", "what", "key"),)

    id: Mapped[int] = mapped_column(primary_key=True, autoincrement=True)
    study_id: Mapped[str] = mapped_column(ForeignKey("study.id"), index=True)
    participation_id: Mapped[int | None] = mapped_column(ForeignKey("participation.id"))
    provider: Mapped[str]
    what: Mapped[Literal["publish", "approve", "reject", "bonus", "partial payment"]] = (
        mapped_column(String(20))
    )
    key: Mapped[str] = mapped_column(String(500))
    """Key that distinguishes calls of a kind: the same call is made once."""
    assignment: Mapped[str]
    """The platform's id of what is approved or paid by; empty for offers of work."""
    amount: Mapped[str]
    """A decimal number in the platform's currency: what is paid, or offered for an assignment.

    Empty where the call pays nothing, or an unknown amount.
    """
    reason: Mapped[str] = mapped_column(String(2000))
    reference: Mapped[str | None]
    """Platform's reference of the call: its id of the payment, or an idempotency key."""
    state: Mapped[
        Literal["attempted", "ordered", "in doubt", "done", "confirmed", "found there", "refused"]
    ] = mapped_column(String(20))
    attempted_at: Mapped[float]
    ended_at: Mapped[float | None]
    problem: Mapped[str] = mapped_column(String(2000))
    """Error of the platform or the network; empty if nothing went wrong."""


class ApiToken(Base):
    """A program's token to read what people with a login may read. It changes nothing.

    Only its digest is kept. It belongs to the installation, not to its maker.
    """

    __tablename__ = "api_token"

    id: Mapped[str] = mapped_column(primary_key=True)
    name: Mapped[str] = mapped_column(unique=True)
    """Name of the program in the audit trail."""
    digest: Mapped[str] = mapped_column(unique=True)
    made_by: Mapped[str]
    made_at: Mapped[float]
    expires_at: Mapped[float]
    used_at: Mapped[float | None]
    """Time of the last use, to the hour."""
