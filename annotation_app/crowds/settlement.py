"""Approving, rejecting and paying: each assignment by itself, and each thing once.

The platform's word counts: what it has approved isn't approved again. A bonus is noted
before it is paid, with a reference that the platform pays once only. The database is never
locked while the platform is asked.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from decimal import Decimal
from typing import Literal

from sqlalchemy import Engine

from annotation_app.crowds.platform import Bonus, Platform, PlatformError, Submission
from annotation_app.crowds.reconciliation import Finding, known_platform_ids, unpaid_part
from annotation_app.database import transaction
from annotation_app.models import Participation, Record

PARTIAL = Bonus("partial", Decimal(0), "For the part of the work that we have received")


@dataclass(frozen=True, slots=True)
class Wishes:
    """What is to be done with what has been sent in.

    Parameters
    ----------
    approve
        Approve what is ready.
    approve_also
        Assignments to approve though not all of them was received.
    flagged
        Ids of people whose work somebody is to look at first.
    hold_flagged
        Leave their assignments for somebody to decide.
    quality_bonus
        For everybody else's approved assignments.
    reject
        Reasons by assignment.
    bonuses
        By assignment.
    pay_partial
        Pay for the part that was received of what was never confirmed.
    """

    approve: bool = True
    approve_also: frozenset[str] = frozenset()
    flagged: frozenset[str] = frozenset()
    hold_flagged: bool = False
    quality_bonus: Bonus | None = None
    reject: Mapping[str, str] = field(default_factory=dict)
    bonuses: Sequence[tuple[str, Bonus]] = ()
    pay_partial: bool = False


@dataclass(frozen=True, slots=True)
class Deed:
    """Something that was done, or could not be."""

    assignment: str
    what: Literal["approve", "reject", "bonus", "partial payment", "held"]
    problem: str = ""
    amount: Decimal = Decimal(0)


def settle(
    engine: Engine, platform: Platform, findings: Sequence[Finding], wishes: Wishes, *, now: float
) -> list[Deed]:
    """Do what can be done. One assignment's failure stops no other."""
    deeds = []
    for finding in findings:
        submission = finding.submission
        if submission is None or submission.standing != "submitted":
            continue
        if finding.assignment in wishes.reject:
            reason = wishes.reject[finding.assignment]
            deeds.append(_reject(engine, platform, finding, submission, reason, now=now))
        elif _is_held(finding, wishes):
            deeds.append(Deed(finding.assignment, "held"))
        elif finding.assignment in wishes.approve_also or (
            wishes.approve and finding.state == "ready"
        ):
            deeds.append(_approve(engine, platform, finding, submission, now=now))
    if wishes.quality_bonus is not None:
        for finding in _to_be_rewarded(findings, wishes, deeds):
            bonus = wishes.quality_bonus
            deeds += _bonus(engine, platform, finding, finding.assignment, bonus, now=now)
    by_assignment = {finding.assignment: finding for finding in findings}
    for assignment, bonus in wishes.bonuses:
        deeds += _bonus(engine, platform, by_assignment.get(assignment), assignment, bonus, now=now)
    if wishes.pay_partial:
        deeds += _partial(engine, platform, findings, now=now)
    return deeds


def _to_be_rewarded(
    findings: Sequence[Finding], wishes: Wishes, deeds: Sequence[Deed]
) -> list[Finding]:
    """What is approved, of people about whom nothing is odd."""
    now_approved = {
        deed.assignment for deed in deeds if deed.what == "approve" and not deed.problem
    }
    return [
        finding
        for finding in findings
        if finding.submission is not None
        and (finding.assignment in now_approved or finding.submission.standing == "approved")
        and finding.person_id is not None
        and finding.person_id not in wishes.flagged
    ]


def _is_held(finding: Finding, wishes: Wishes) -> bool:
    is_flagged = wishes.hold_flagged and finding.person_id in wishes.flagged
    return is_flagged and finding.assignment not in wishes.approve_also


def _approve(
    engine: Engine, platform: Platform, finding: Finding, submission: Submission, now: float
) -> Deed:
    try:
        platform.approve(submission)
    except PlatformError as error:
        return Deed(finding.assignment, "approve", str(error))
    _note(engine, finding, {"approved_at": now})
    return Deed(finding.assignment, "approve")


def _reject(
    engine: Engine,
    platform: Platform,
    finding: Finding,
    submission: Submission,
    reason: str,
    *,
    now: float,
) -> Deed:
    try:
        platform.reject(submission, reason)
    except PlatformError as error:
        return Deed(finding.assignment, "reject", str(error))
    _note(engine, finding, {"rejected_at": now, "reason": reason})
    return Deed(finding.assignment, "reject")


def _bonus(
    engine: Engine,
    platform: Platform,
    finding: Finding | None,
    assignment: str,
    bonus: Bonus,
    *,
    now: float,
) -> Iterable[Deed]:
    if finding is None or finding.submission is None or finding.participation_id is None:
        yield Deed(assignment, "bonus", "nobody has sent this assignment in", bonus.amount)
        return
    problem = _pay(engine, platform, finding, finding.submission, bonus, now=now)
    if problem is not None:
        yield Deed(assignment, "bonus", problem, bonus.amount)


def _partial(
    engine: Engine, platform: Platform, findings: Sequence[Finding], *, now: float
) -> Iterable[Deed]:
    payable = known_platform_ids(engine, findings)
    for finding in findings:
        amount = unpaid_part(finding)
        if not amount:
            continue
        submission = payable.get(finding.person_id or "")
        if submission is None:
            problem = "the platform has nothing of this worker to pay by"
        else:
            # Platforms tell payments apart by their reasons.
            reason = f"{PARTIAL.reason} (assignment {finding.assignment})"
            bonus = replace(PARTIAL, amount=amount, reason=reason)
            paid = _pay(engine, platform, finding, submission, bonus, now=now)
            if paid is None:
                continue
            problem = paid
        yield Deed(finding.assignment, "partial payment", problem, amount)


def _pay(
    engine: Engine,
    platform: Platform,
    finding: Finding,
    submission: Submission,
    bonus: Bonus,
    *,
    now: float,
) -> str | None:
    """Pay a bonus. What went wrong, empty if nothing; None if it had been paid before."""
    key = bonus.key
    noted = _bonuses(engine, finding).get(key, {})
    if "paid_at" in noted:
        return None
    try:
        reference = noted.get("reference")
        if reference is None:
            # The key names the assignment that is paid for, which may not be the one paid by.
            named = replace(bonus, key=f"{key}-{finding.participation_id}")
            reference = platform.prepare(submission, named)
            noted = {"amount": str(bonus.amount), "reference": reference, "reason": bonus.reason}
            _note_bonus(engine, finding, key, noted)
        platform.pay(submission, replace(bonus, amount=Decimal(noted["amount"])), reference)
    except PlatformError as error:
        return str(error)
    _note_bonus(engine, finding, key, {**noted, "paid_at": now})
    return ""


def _bonuses(engine: Engine, finding: Finding) -> Record:
    with transaction(engine) as session:
        found: Record = session.get_one(Participation, finding.participation_id).outcome
        return dict(found.get("bonuses", {}))


def _note_bonus(engine: Engine, finding: Finding, key: str, noted: Record) -> None:
    _note(engine, finding, {"bonuses": {**_bonuses(engine, finding), key: noted}})


def _note(engine: Engine, finding: Finding, outcome: Record) -> None:
    if finding.participation_id is None:
        return
    with transaction(engine) as session:
        participation = session.get_one(Participation, finding.participation_id)
        participation.outcome = {**participation.outcome, **outcome}
