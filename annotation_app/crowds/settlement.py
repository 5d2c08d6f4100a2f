"""Approving, rejecting and paying: each assignment by itself, and each thing once.

Each call is in the ledger before it is made. What is in doubt is left alone; see
:mod:`annotation_app.crowds.doubts`. The database is never locked while the platform is asked.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from decimal import Decimal
from typing import Literal

from annotation_app.crowds.ledger import OPEN, Call, Ledger, What
from annotation_app.crowds.paying import pay
from annotation_app.crowds.platform import (
    Bonus,
    LostReplyError,
    Platform,
    PlatformError,
    Submission,
)
from annotation_app.crowds.reconciliation import Finding, known_platform_ids, unpaid_part
from annotation_app.store.installation import now

PART = "For the part of the work that we have received"
HOUR_S = 3600
"""So long a platform may still list an assignment as sent in that it has approved."""


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
    """Something that was done, or found out, or could not be done.

    Parameters
    ----------
    problem
        Why it wasn't done; empty if it was.
    note
        What else there is to say.
    in_doubt
        Whether nobody knows if it was done.
    """

    assignment: str
    what: What | Literal["held"]
    problem: str = ""
    amount: Decimal = Decimal(0)
    note: str = ""
    in_doubt: bool = False


def settle(
    ledger: Ledger, platform: Platform, findings: Sequence[Finding], wishes: Wishes
) -> Iterator[Deed]:
    """Do what can be done. One assignment's failure stops no other."""
    approved = {
        finding.assignment
        for finding in findings
        if finding.submission is not None and finding.submission.standing == "approved"
    }
    refused_rejections = {
        entry.call.assignment
        for entry in ledger.entries("refused", *OPEN)
        if entry.call.what == "reject"
    }
    for finding in findings:
        submission = finding.submission
        if submission is None or submission.standing != "submitted":
            continue
        assignment = finding.assignment
        if assignment in wishes.reject:
            yield from _reject(ledger, platform, finding, submission, wishes.reject[assignment])
        elif assignment in wishes.approve_also or (wishes.approve and finding.state == "ready"):
            why = _held(finding, wishes, was_to_be_rejected=assignment in refused_rejections)
            if why is not None:
                yield Deed(assignment, "held", note=why)
                continue
            for deed in _approve(ledger, platform, finding, submission):
                yield deed
                if not deed.problem:
                    approved.add(assignment)
        elif wishes.hold_flagged and finding.person_id in wishes.flagged:
            yield Deed(assignment, "held")
    yield from _rewards(ledger, platform, findings, wishes, approved)
    if wishes.pay_partial:
        yield from _partial(ledger, platform, findings)


def _rewards(
    ledger: Ledger,
    platform: Platform,
    findings: Sequence[Finding],
    wishes: Wishes,
    approved: Iterable[str],
) -> Iterator[Deed]:
    """Bonuses: for what is approved of people about whom nothing is odd, and those named."""
    if wishes.quality_bonus is not None:
        for finding in findings:
            is_odd = finding.person_id is None or finding.person_id in wishes.flagged
            if finding.assignment in approved and not is_odd:
                yield from _bonus(ledger, platform, finding, wishes.quality_bonus)
    by_assignment = {finding.assignment: finding for finding in findings}
    for assignment, bonus in wishes.bonuses:
        sent = by_assignment.get(assignment)
        if sent is None or sent.submission is None or sent.participation_id is None:
            yield Deed(assignment, "bonus", "nobody has sent this assignment in", bonus.amount)
        else:
            yield from _bonus(ledger, platform, sent, bonus)


def _held(finding: Finding, wishes: Wishes, *, was_to_be_rejected: bool) -> str | None:
    """Why somebody is to look at an assignment before it is approved; None if it can be."""
    if finding.assignment in wishes.approve_also:
        return None
    if wishes.hold_flagged and finding.person_id in wishes.flagged:
        return ""
    if was_to_be_rejected:
        return "it was to be rejected, which failed: --reject or --approve it"
    if finding.part != "unpaid":
        return "a part of it was paid before: --approve it if it is to be paid wholly"
    return None


def _approve(
    ledger: Ledger, platform: Platform, finding: Finding, submission: Submission
) -> Iterator[Deed]:
    call = Call(
        "approve",
        finding.assignment,
        finding.assignment,
        finding.participation_id,
        submission.reward,
    )
    yield from _judge(ledger, call, lambda: platform.approve(submission))


def _reject(
    ledger: Ledger, platform: Platform, finding: Finding, submission: Submission, reason: str
) -> Iterator[Deed]:
    assignment = finding.assignment
    call = Call("reject", assignment, assignment, finding.participation_id, reason=reason)
    yield from _judge(ledger, call, lambda: platform.reject(submission, reason))


def _judge(ledger: Ledger, call: Call, do: Callable[[], None]) -> Iterator[Deed]:
    before = ledger.find(call.what, call.key)
    if before is not None:
        is_young = before.ended_at is not None and now() - before.ended_at < HOUR_S
        if before.state in OPEN or (before.state == "done" and is_young):
            return
    yield _told(call, lambda: ledger.carry_out(call, lambda _: do()))


def _bonus(ledger: Ledger, platform: Platform, finding: Finding, bonus: Bonus) -> Iterator[Deed]:
    assert finding.submission is not None  # noqa: S101 - it is checked before
    key = f"{finding.assignment} {bonus.key}"
    yield from _pay(
        ledger,
        platform,
        finding.submission,
        Call(
            "bonus",
            key,
            participation_id=finding.participation_id,
            amount=bonus.amount,
            reason=bonus.reason,
        ),
        finding.assignment,
    )


def _partial(ledger: Ledger, platform: Platform, findings: Sequence[Finding]) -> Iterator[Deed]:
    payable = known_platform_ids(ledger.engine, findings)
    for finding in findings:
        amount = unpaid_part(finding)
        if not amount:
            continue
        submission = payable.get(finding.person_id or "")
        if submission is None:
            problem = "the platform has nothing of this worker to pay by"
            yield Deed(finding.assignment, "partial payment", problem, amount)
            continue
        call = Call(
            "partial payment",
            finding.assignment,
            participation_id=finding.participation_id,
            amount=amount,
            reason=f"{PART} (assignment {finding.assignment})",
        )
        yield from _pay(ledger, platform, submission, call, finding.assignment)


def _pay(
    ledger: Ledger, platform: Platform, submission: Submission, call: Call, assignment: str
) -> Iterator[Deed]:
    before = ledger.find(call.what, call.key)
    if before is None or before.state == "refused":
        deed = _told(call, lambda: pay(ledger, platform, submission, call))
        yield replace(deed, assignment=assignment)


def _told(call: Call, do: Callable[[], None]) -> Deed:
    deed = Deed(call.assignment, call.what, amount=call.amount or Decimal(0))
    try:
        do()
    except LostReplyError as error:
        return replace(deed, problem=f"in doubt: {error}", in_doubt=True)
    except PlatformError as error:
        return replace(deed, problem=str(error))
    return deed
