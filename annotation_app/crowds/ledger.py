"""The ledger: each call that offers, approves, rejects or pays, noted before it is made.

Nothing else writes this table. A call is ``attempted`` while it is under way. After an answer it
is ``done`` or ``refused``; a payment is ``ordered`` until the platform lists it. Without an answer
a call is ``in doubt``. It is not made again until a person or the platform's record has given its
outcome (``confirmed`` is a person's word). A call that the platform shows and this ledger didn't
make is ``found there``. A refused call may be made again. So may one that is done where the
platform reports otherwise, unless it is a payment.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import datetime, timezone
from decimal import Decimal
from hashlib import sha256
from typing import Any, Literal, TypeAlias, TypeVar

from sqlalchemy import Engine, func, select
from sqlalchemy.exc import IntegrityError
from sqlalchemy.orm import Session

from annotation_app.crowds.platform import LostReplyError, PlatformError
from annotation_app.people.participants import subject_of
from annotation_app.store.audit import COMMAND_LINE, RESTORED, note
from annotation_app.store.database import reading, transaction
from annotation_app.store.installation import now
from annotation_app.store.models import (
    AuditEntry,
    LedgerEntry,
    Participation,
    Person,
    Record,
    Study,
)
from g3.errors import CorpusError

try:
    import fcntl
except ImportError:  # there is none on Windows
    fcntl = None  # type: ignore[assignment]

What: TypeAlias = Literal["publish", "approve", "reject", "bonus", "partial payment"]
State: TypeAlias = Literal[
    "attempted", "ordered", "in doubt", "done", "confirmed", "found there", "refused"
]
T = TypeVar("T")

OPEN: tuple[State, ...] = ("attempted", "in doubt")
"""States in which it is unknown whether the call was carried out."""
PAYMENTS: tuple[What, ...] = ("bonus", "partial payment")
DOUBTED: tuple[State, ...] = ("in doubt", "found there")
"""States that await somebody's decision."""
CURRENT = "confirmed as complete"
"""The action in the audit trail after which a restored ledger is taken as complete."""
STOPPED = "the program stopped before there was an answer"
SANDBOX = "sandbox"
UNDER_WAY = "under way, or its program has stopped"
FOUND = " found "
LONGEST = 2000
"""Characters of what a platform says that are kept."""


@dataclass(frozen=True, slots=True)
class Call:
    """A call to make at a platform."""

    what: What
    key: str
    """Key that distinguishes calls of a kind: the same call is made once."""
    assignment: str = ""
    """The platform's id of the assignment that is approved or paid by."""
    participation_id: int | None = None
    """The assignment here that it is for."""
    amount: Decimal | None = None
    """Amount that the call pays; None if nothing, or if unknown."""
    reason: str = ""


@dataclass(frozen=True, slots=True)
class Entry:
    """A call as the ledger has it. `subject` is what exports call the person it is for."""

    id: int
    call: Call
    subject: str | None
    reference: str | None
    state: State
    attempted_at: float
    ended_at: float | None
    problem: str


class InDoubtError(PlatformError):
    """A call that isn't made, because it may have been carried out before."""


@dataclass(frozen=True, slots=True)
class Ledger:
    """A study's calls to one platform, whose sandbox has another name as `provider`."""

    engine: Engine
    study_id: str
    provider: str

    def entries(
        self, *states: State, assignment: str | None = None, everywhere: bool = False
    ) -> list[Entry]:
        """Return all calls, the oldest first.

        Only those in some states, if any are given; only those by an assignment; also those of the
        platform's sandbox, or of the platform itself.
        """
        wanted = (
            select(LedgerEntry, Person)
            .outerjoin(Participation, Participation.id == LedgerEntry.participation_id)
            .outerjoin(Person, Person.id == Participation.person_id)
            .where(LedgerEntry.study_id == self.study_id)
            .order_by(LedgerEntry.id)
        )
        platform = self.provider.partition(" ")[0]
        names = (platform, f"{platform} {SANDBOX}") if everywhere else (self.provider,)
        wanted = wanted.where(LedgerEntry.provider.in_(names))
        if states:
            wanted = wanted.where(LedgerEntry.state.in_(states))
        if assignment is not None:
            wanted = wanted.where(LedgerEntry.assignment == assignment)
        with reading(self.engine) as session:
            return [_entry(row, person) for row, person in session.execute(wanted)]

    def find(self, what: What, key: str) -> Entry | None:
        """Return the outcome of a call, if it was ever attempted."""
        with reading(self.engine) as session:
            row = session.scalars(self._row(what, key)).first()
            return None if row is None else _entry(row, None)

    def carry_out(
        self,
        call: Call,
        do: Callable[[Entry], T],
        *,
        repeats: Entry | None = None,
        instead_of: Entry | None = None,
    ) -> T:
        """Note a call, make it, and note its outcome.

        A payment that the platform has accepted is ordered, anything else done.

        Parameters
        ----------
        do
            Makes the call.
        repeats
            The same call in doubt, which the platform recognises and doesn't carry out twice.
            A refusal doesn't show then whether it was carried out before.
        instead_of
            The same call in doubt, which somebody has decided to repeat.

        Raises
        ------
        InDoubtError
            If an earlier attempt's outcome is unknown, or it is a payment that was made.
        LostReplyError
            If the outcome of this attempt is unknown.
        PlatformError
            If it was refused.
        """
        entry = self._claim(call, repeats, instead_of)
        try:
            result = do(entry)
        except LostReplyError as error:
            self.end(entry, "in doubt", str(error))
            raise
        except PlatformError as error:
            self.end(entry, "refused" if repeats is None else "in doubt", str(error))
            raise
        self.end(entry, "ordered" if call.what in PAYMENTS else "done")
        return result

    def take_in(self, call: Call, reference: str | None = None) -> None:
        """Note a call that the platform shows and that wasn't made from here."""
        with transaction(self.engine) as session:
            row = LedgerEntry(study_id=self.study_id, provider=self.provider)
            row.what, row.key, row.attempted_at = call.what, call.key, now()
            row.reference = reference
            _fill(row, call)
            row.state, row.ended_at = "found there", now()
            session.add(row)

    def adopt(self, entry: Entry, call: Call) -> None:
        """Let a payment that was found there be that of a call, which isn't made any more."""
        with transaction(self.engine) as session:
            refused = session.scalars(self._row(call.what, call.key)).first()
            if refused is not None:
                refused.key = f"{refused.key} refused {refused.id}"
                session.flush()
            row = session.get_one(LedgerEntry, entry.id, with_for_update=True)
            row.what, row.key, row.reason = call.what, call.key, call.reason[:LONGEST]
            row.participation_id = call.participation_id

    def set_apart(self, entry: Entry) -> None:
        """Note that a payment that was found there is none of those that are wished for."""
        with transaction(self.engine) as session:
            row = session.get_one(LedgerEntry, entry.id, with_for_update=True)
            row.key, row.state, row.ended_at = apart(row.key), "done", now()
            _note_decision(session, row, "paid apart from that")

    def restored_at(self) -> float | None:
        """Return the time when the database was restored from a backup.

        None if it never was, or somebody has confirmed since that this ledger is complete.
        """
        wanted = select(AuditEntry).order_by(AuditEntry.id.desc())
        with reading(self.engine) as session:
            restored = session.scalars(wanted.where(AuditEntry.action == RESTORED)).first()
            if restored is None:
                return None
            name = session.get_one(Study, self.study_id).name
            later = wanted.where(AuditEntry.action == CURRENT, AuditEntry.id > restored.id)
            confirmed = session.scalars(later.where(AuditEntry.about == name))
            is_confirmed = self.provider in {one.details.get("platform") for one in confirmed}
            return None if is_confirmed else restored.at

    def confirm_current(self) -> None:
        """Note that somebody says that this ledger is complete again after a restore."""
        with transaction(self.engine) as session:
            name = session.get_one(Study, self.study_id).name
            note(session, COMMAND_LINE, CURRENT, name, platform=self.provider)

    def refer(self, entry: Entry, reference: str) -> None:
        """Note what the platform knows a call by."""
        with transaction(self.engine) as session:
            session.get_one(LedgerEntry, entry.id).reference = reference

    def end(self, entry: Entry, state: State, problem: str = "") -> None:
        """Note the outcome of a call, unless it was attempted again meanwhile."""
        with transaction(self.engine) as session:
            row = session.get_one(LedgerEntry, entry.id, with_for_update=True)
            if row.attempted_at == entry.attempted_at:
                row.state, row.problem, row.ended_at = state, problem[:LONGEST], now()

    def decide(self, entry: Entry, state: State, decision: str) -> None:
        """Note what somebody says of a call in doubt or found there, also in the audit trail."""
        with transaction(self.engine) as session:
            row = session.get_one(LedgerEntry, entry.id, with_for_update=True)
            if row.state in DOUBTED:
                row.state, row.ended_at = state, now()
                _note_decision(session, row, decision)

    def doubt_what_stopped(self) -> None:
        """Put calls in doubt that were under way when their program stopped.

        Only for callers that know of no other program at work; see :func:`one_at_a_time`.
        """
        for entry in self.entries("attempted"):
            self.end(entry, "in doubt", entry.problem or STOPPED)

    def _row(self, what: What, key: str) -> Any:
        return select(LedgerEntry).where(
            LedgerEntry.provider == self.provider, LedgerEntry.what == what, LedgerEntry.key == key
        )

    def _claim(self, call: Call, repeats: Entry | None, instead_of: Entry | None) -> Entry:
        """Note that a call is about to be made. One program alone can."""
        try:
            with transaction(self.engine) as session:
                row = session.scalars(self._row(call.what, call.key).with_for_update()).first()
                if row is None:
                    row = LedgerEntry(study_id=self.study_id, provider=self.provider)
                    session.add(row)
                    row.what, row.key, row.attempted_at = call.what, call.key, now()
                elif row.state == "refused" or (row.what not in PAYMENTS and row.state not in OPEN):
                    row.attempted_at, row.reference = now(), None
                else:
                    doubted = repeats or instead_of
                    still = (row.id, row.state, row.attempted_at)
                    if doubted is None or still != (doubted.id, "in doubt", doubted.attempted_at):
                        what = f"entry {row.id} is {row.state} already"
                        raise InDoubtError(what, fix="look at it first")
                    if doubted is instead_of:
                        row.attempted_at = now()
                        _note_decision(session, row, "paid again")
                _fill(row, call)
                session.flush()
                return _entry(row, None)
        except IntegrityError:
            raise InDoubtError("another program is just doing this", fix="wait for it") from None


def _fill(row: LedgerEntry, call: Call) -> None:
    row.participation_id = call.participation_id
    row.assignment = call.assignment
    row.amount = "" if call.amount is None else str(call.amount)
    row.reason = call.reason[:LONGEST]
    row.state, row.ended_at, row.problem = "attempted", None, ""


def _note_decision(session: Session, row: LedgerEntry, decision: str) -> None:
    study = session.get_one(Study, row.study_id)
    about = {"entry": row.id, "what": row.what, "assignment": row.assignment, "amount": row.amount}
    note(session, COMMAND_LINE, decision, study.name, platform=row.provider, **about)


def _entry(row: LedgerEntry, person: Person | None) -> Entry:
    call = Call(
        row.what,
        row.key,
        row.assignment,
        row.participation_id,
        Decimal(row.amount) if row.amount else None,
        row.reason,
    )
    return Entry(
        id=row.id,
        call=call,
        subject=None if person is None else subject_of(person),
        reference=row.reference,
        state=row.state,
        attempted_at=row.attempted_at,
        ended_at=row.ended_at,
        problem=row.problem,
    )


@contextmanager
def one_at_a_time(engine: Engine, study_id: str) -> Iterator[None]:
    """Keep other programs from a study's platforms; a CorpusError if another one is at work.

    The lock ends with the process, however that ends. So its holder knows that calls which
    the ledger has as attempted have been abandoned. On Windows an SQLite database has
    no such lock; there the ledger's own rows keep two programs from paying the same bonus.
    """
    locked = _server_lock if engine.dialect.name == "postgresql" else _file_lock
    with locked(engine, study_id) as is_mine:
        if not is_mine:
            raise CorpusError(
                "another `ct crowd publish` or `ct crowd collect` is at work on this study",
                fix="wait until it is done",
            )
        yield


@contextmanager
def _file_lock(engine: Engine, _study_id: str) -> Iterator[bool]:
    if fcntl is None:
        yield True
        return
    file = f"{engine.url.database}-platforms"
    descriptor = os.open(file, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
    try:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            yield False
        else:
            yield True
    finally:
        os.close(descriptor)


@contextmanager
def _server_lock(engine: Engine, study_id: str) -> Iterator[bool]:
    name = int.from_bytes(sha256(f"platforms {study_id}".encode()).digest()[:8], "big", signed=True)
    with engine.connect() as connection:
        connection.execution_options(to="read")
        is_mine = bool(connection.scalar(select(func.pg_try_advisory_lock(name))))
        try:
            yield is_mine
        finally:
            if is_mine:
                connection.scalar(select(func.pg_advisory_unlock(name)))


def entry_records(entries: Sequence[Entry]) -> list[Record]:
    """Return calls as records, for programs."""
    return [
        {
            "id": entry.id,
            "what": entry.call.what,
            "state": entry.state,
            "assignment": _meant(entry),
            "paid_by": entry.call.assignment if entry.call.what in PAYMENTS else None,
            "subject": entry.subject,
            "amount": None if entry.call.amount is None else str(entry.call.amount),
            "reason": entry.call.reason,
            "reference": entry.reference,
            "attempted_at": moment(entry.attempted_at),
            "ended_at": None if entry.ended_at is None else moment(entry.ended_at),
            "problem": entry.problem,
        }
        for entry in entries
    ]


def doubt_lines(entries: Sequence[Entry]) -> Iterator[str]:
    """Yield a line for each call of unknown outcome or origin, for people."""
    for entry in entries:
        if entry.state not in (*OPEN, *DOUBTED):
            continue
        call = entry.call
        what = call.what if call.amount is None else f"{call.what} {call.amount}"
        if call.what == "publish":
            whom = call.reason
        else:
            whom = f"assignment {_meant(entry)}, person {entry.subject or 'unknown'}"
        state = "in doubt" if entry.state in OPEN else entry.state
        why = entry.problem or call.reason if state == "found there" else entry.problem or UNDER_WAY
        yield f"{state}: {entry.id}: {what}, {whom}, {moment(entry.attempted_at)}: {why}"


def total_lines(entries: Sequence[Entry]) -> Iterator[str]:
    """Count the calls of each kind in each state, and sum their payments."""
    kinds = sorted({(entry.call.what, entry.state) for entry in entries})
    for what, state in kinds:
        amounts = [e.call.amount for e in entries if (e.call.what, e.state) == (what, state)]
        known = [amount for amount in amounts if amount is not None and what != "publish"]
        total = f", {sum(known, Decimal(0))} in all" if known else ""
        yield f"{len(amounts):6} {what} {state}{total}"


def found_key(assignment: str, amount: Decimal, number: int) -> str:
    """Return the key of a payment discovered there: that of a number with its amount."""
    return f"{assignment}{FOUND}{amount} {number}"


def is_found(entry: Entry) -> bool:
    """Check that a payment was discovered there, and isn't that of any call here."""
    return FOUND in entry.call.key


def apart(key: str) -> str:
    """Return the key of a payment discovered there that is none of the planned ones."""
    return key.replace(FOUND, " apart ")


def _meant(entry: Entry) -> str:
    """Return the assignment that a call is for: people may be paid by another of theirs."""
    return "" if entry.call.what == "publish" else entry.call.key.partition(" ")[0]


def moment(at: float) -> str:
    """Return a time, for people."""
    return datetime.fromtimestamp(at, timezone.utc).isoformat(" ", "seconds")
