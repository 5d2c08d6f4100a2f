"""Comparison of the work received here with the platform's record.

The two are separate: a worker may have done the work and never reported it to the platform, or
reported work that wasn't done. Each assignment is compared by itself.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from decimal import Decimal
from typing import Literal, TypeAlias

from sqlalchemy import Engine, select
from sqlalchemy.orm import Session

from annotation_app.crowds.comparison import Terms
from annotation_app.crowds.participation import done, receive
from annotation_app.crowds.platform import Standing, Submission
from annotation_app.people.participants import hashed
from annotation_app.privacy.erasure import ERASED
from annotation_app.store.database import reading, transaction
from annotation_app.store.models import LedgerEntry, Participation, Person, Study
from annotation_app.studies.study_file import restored

State: TypeAlias = Literal[
    "settled",
    "ready",
    "not confirmed",
    "working",
    "incomplete",
    "given back",
    "nothing received",
    "unknown here",
    "unknown there",
    "another worker",
    "another offer",
]

EXPLANATIONS: dict[State, str] = {
    "settled": "approved or rejected at the platform",
    "ready": "received here and sent in there; it can be approved",
    "not confirmed": "received here, but the worker has not sent it in there",
    "working": "not done yet",
    "incomplete": "sent in there, though not all of it was received here",
    "given back": "the worker gave it back, or ran out of time",
    "nothing received": "sent in there, and nothing was received here",
    "unknown here": "sent in there by somebody who never came here",
    "unknown there": "came here, and the platform knows no such assignment",
    "another worker": "the platform's worker isn't the one who came here",
    "another offer": "sent in for other work than the address offers by which the worker came",
}
CENT = Decimal("0.01")
LONGEST_S = 86_400.0
"""Time after which an assignment that isn't listed is taken as given up, in seconds."""
LISTED_IN_S = 600.0
"""Time in which a platform that lists all assignments should list a new one, in seconds."""


@dataclass(frozen=True, slots=True)
class Finding:
    """State of an assignment on both sides."""

    assignment: str
    state: State
    submission: Submission | None
    """Platform's record; None if it doesn't list the assignment."""
    participation_id: int | None
    """The assignment here, if somebody came with it."""
    person_id: str | None
    done: int = 0
    items: int = 0
    """Number of items of the assignment, of which `done` were received."""
    due: Decimal = Decimal(0)
    """Value of the items that no reward is paid for."""
    is_over: bool = False
    """True if the worker can't send the assignment in any more."""
    part: Literal["unpaid", "in doubt", "paid"] = "unpaid"
    """State of the payment of `due` as a bonus."""
    standing: str | None = None
    """Platform's last status of it, ``unknown`` if it doesn't know it."""


def reconcile(
    engine: Engine,
    study: Study,
    provider: str,
    there: Iterable[Submission],
    *,
    terms: Mapping[str, Terms],
    lists_all: bool,
    salt: bytes,
    now: float,
) -> list[Finding]:
    """Bring both sides together, and note what the platform has confirmed.

    Parameters
    ----------
    there
        Platform's record of the study's assignments. It is read before the database is locked.
    terms
        Terms offered from here, by the platform's ids of the work.
    lists_all
        True if `there` has also assignments on which somebody is at work.
    """
    offered = {(one.task, one.items) for one in terms.values()}
    known = {submission.assignment: submission for submission in there}
    with transaction(engine) as session:
        counts = done(session, study, provider)
        parts = _parts(session, study)
        rows = session.execute(
            select(Participation, Person)
            .join(Person, Person.id == Participation.person_id)
            .where(Participation.study_id == study.id, Participation.provider == provider)
            .order_by(Participation.begun_at, Participation.id)
        ).all()
        payment = restored(study.config).payment
        price = Decimal(str(payment.amount)) if payment is not None else Decimal(0)
        findings = []
        for participation, person in rows:
            submission = known.pop(participation.assignment, None)
            count = counts[participation.id]
            receive(participation, done=count, nothing_left=False, now=now)
            is_same = (
                submission is None
                or person.provider == ERASED  # nothing shows any more who it was
                or hashed(salt, provider, submission.person) == person.external_hash
            )
            is_over = participation.begun_at < now - (LISTED_IN_S if lists_all else LONGEST_S)
            if lists_all and participation.received_at is not None:
                is_over = True
            is_asked = (participation.task, participation.items) in offered
            if submission is not None and is_same:
                participation.standing = submission.standing
            elif submission is not None or (is_over and is_asked):
                participation.standing = "unknown"
            state = _state(participation, count, submission)
            if not is_same:
                state = "another worker"
            elif state in ("ready", "incomplete", "nothing received") and not _is_bound(
                participation, submission, terms
            ):
                state = "another offer"
            elif lists_all and participation.standing == "unknown":
                state = "unknown there"
            is_there = submission is not None and submission.standing not in ("working", "returned")
            if is_there and is_same and participation.confirmed_at is None:
                participation.confirmed_at = now
            findings.append(
                Finding(
                    participation.assignment,
                    state,
                    submission,
                    participation.id,
                    person.id,
                    count,
                    participation.items,
                    _due(state, count, price),
                    state == "given back" or participation.begun_at < now - LONGEST_S,
                    parts.get(participation.id, "unpaid"),
                    participation.standing,
                )
            )
    states: dict[Standing, State] = {
        "submitted": "unknown here",
        "approved": "settled",
        "rejected": "settled",
    }
    unknown = (one for one in known.values() if one.standing in states)
    findings += (
        Finding(s.assignment, states[s.standing], s, None, None, standing=s.standing)
        for s in unknown
    )
    return findings


def _is_bound(
    participation: Participation, submission: Submission | None, terms: Mapping[str, Terms]
) -> bool:
    """Check that an assignment belongs to the work offered to its worker, for its reward."""
    one = None if submission is None else terms.get(submission.group)
    if one is None or submission is None:
        return False
    is_same = (one.task, one.items) == (participation.task, participation.items)
    return is_same and (None in (one.reward, submission.reward) or one.reward == submission.reward)


def unpaid_part(finding: Finding) -> Decimal:
    """Return the payment for a part of an assignment that was given up."""
    return finding.due if finding.is_over and finding.part == "unpaid" else Decimal(0)


def known_platform_ids(engine: Engine, findings: Iterable[Finding]) -> dict[str, Submission]:
    """Return a submitted assignment by person: by it a platform can pay them."""
    sent = {
        f.person_id: f.submission
        for f in findings
        if f.person_id is not None
        and f.submission is not None
        and f.state in ("settled", "ready", "incomplete", "given back")
    }
    with reading(engine) as session:
        blocked = set(
            session.scalars(
                select(Person.id).where(Person.id.in_(sent), Person.blocked_at.is_not(None))
            )
        )
    return {person: submission for person, submission in sent.items() if person not in blocked}


def _parts(session: Session, study: Study) -> dict[int | None, Literal["in doubt", "paid"]]:
    """Return the state of the payment for a part of an assignment, by participation."""
    rows = session.execute(
        select(LedgerEntry.participation_id, LedgerEntry.state).where(
            LedgerEntry.study_id == study.id,
            LedgerEntry.what == "partial payment",
            LedgerEntry.state != "refused",
        )
    )
    paid = ("ordered", "done", "confirmed")
    return {id_: "paid" if state in paid else "in doubt" for id_, state in rows}


def _state(participation: Participation, count: int, submission: Submission | None) -> State:
    is_received = participation.received_at is not None
    if submission is None or submission.standing == "working":
        return "not confirmed" if is_received else "working"
    if submission.standing in ("approved", "rejected"):
        return "settled"
    if submission.standing == "returned":
        return "given back"
    if is_received:
        return "ready"
    return "incomplete" if count else "nothing received"


def _due(state: State, count: int, price: Decimal) -> Decimal:
    if state in ("not confirmed", "working", "given back"):
        return (count * price).quantize(CENT)
    return Decimal(0)
