"""Approving, rejecting and paying: each assignment by itself, and each thing once.

Each call is in the ledger before it is made. What is in doubt is left alone; see
:mod:`annotation_app.crowds.doubts`. The database is never locked while the platform is asked.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from decimal import Decimal
from functools import partial
from typing import Literal

from annotation_app.crowds.ledger import OPEN, PAYMENTS, Call, Entry, Ledger, What
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
    """What is to be done with what has been sent in."""

    approve: bool = True
    """Approve what is ready."""
    approve_also: frozenset[str] = frozenset()
    """Assignments to approve though not all of them was received."""
    flagged: frozenset[str] = frozenset()
    """Ids of people whose work somebody is to look at first."""
    hold_flagged: bool = False
    """Leave their assignments for somebody to decide."""
    quality_bonus: Bonus | None = None
    """For everybody else's approved assignments."""
    reject: Mapping[str, str] = field(default_factory=dict)
    """Reasons by assignment."""
    bonuses: Sequence[tuple[str, Bonus]] = ()
    """By assignment."""
    pay_partial: bool = False
    """Pay for the part that was received of what was never confirmed."""


@dataclass(frozen=True, slots=True)
class Deed:
    """Something that was done, or found out, or could not be done.

    `problem` says why it wasn't, and `note` what else there is to say. Nobody knows whether it was
    done if it is `in_doubt`.
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
            reason = wishes.reject[assignment]
            yield from _judge(ledger, platform, finding, submission, reason)
        elif assignment in wishes.approve_also or (wishes.approve and finding.state == "ready"):
            why = _held(finding, wishes, was_to_be_rejected=assignment in refused_rejections)
            if why is not None:
                yield Deed(assignment, "held", note=why)
                continue
            for deed in _judge(ledger, platform, finding, submission):
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
    by_assignment = {finding.assignment: finding for finding in findings}
    bonuses = list(wishes.bonuses)
    if wishes.quality_bonus is not None:
        careful = [
            (finding.assignment, wishes.quality_bonus)
            for finding in findings
            if finding.person_id not in (None, *wishes.flagged) and finding.assignment in approved
        ]
        bonuses = [*careful, *bonuses]
    for assignment, bonus in bonuses:
        sent = by_assignment.get(assignment)
        if sent is None or sent.submission is None or sent.participation_id is None:
            yield Deed(assignment, "bonus", "nobody has sent this assignment in", bonus.amount)
        else:
            named = replace(bonus, key=f"{assignment} {bonus.key}")
            yield from _pay(ledger, platform, sent, sent.submission, named)


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


def _judge(
    ledger: Ledger,
    platform: Platform,
    finding: Finding,
    submission: Submission,
    reason: str | None = None,
) -> Iterator[Deed]:
    """Approve an assignment, or reject it for a reason, unless that was done just now."""
    about = finding.assignment, finding.assignment, finding.participation_id
    if reason is None:
        call = Call("approve", *about, submission.reward)
        do = partial(platform.approve, submission)
    else:
        call = Call("reject", *about, reason=reason)
        do = partial(platform.reject, submission, reason)
    before = ledger.find(call.what, call.key)
    if before is not None:
        is_young = before.ended_at is not None and now() - before.ended_at < HOUR_S
        if before.state in OPEN or (before.state == "done" and is_young):
            return
    yield _told(call, lambda: ledger.carry_out(call, lambda _: do()))


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
        reason = f"{PART} (assignment {finding.assignment})"
        bonus = Bonus(finding.assignment, amount, reason)
        yield from _pay(ledger, platform, finding, submission, bonus, what="partial payment")


def _pay(
    ledger: Ledger,
    platform: Platform,
    finding: Finding,
    submission: Submission,
    bonus: Bonus,
    *,
    what: What = "bonus",
) -> Iterator[Deed]:
    before = ledger.find(what, bonus.key)
    if before is None or before.state == "refused":
        call = Call(what, bonus.key, "", finding.participation_id, bonus.amount, bonus.reason)
        deed = _told(call, lambda: pay(ledger, platform, submission, call))
        yield replace(deed, assignment=finding.assignment)


def deed_of(call: Call, problem: str = "", *, note: str = "", in_doubt: bool = False) -> Deed:
    """What came of a call."""
    amount = call.amount or Decimal(0)
    return Deed(call.assignment, call.what, problem, amount, note, in_doubt)


def _told(call: Call, do: Callable[[], None]) -> Deed:
    try:
        do()
    except LostReplyError as error:
        return deed_of(call, f"in doubt: {error}", in_doubt=True)
    except PlatformError as error:
        return deed_of(call, str(error))
    return deed_of(call)


def pay(
    ledger: Ledger,
    platform: Platform,
    submission: Submission,
    call: Call,
    *,
    instead_of: Entry | None = None,
) -> None:
    """Pay a bonus by a submission.

    Two payments of the same amount by the same submission are never under way together.
    Platforms list amounts, and nobody could see which of the two arrived. `instead_of` is the same
    payment in doubt, of which somebody has decided that it is made again.

    Raises
    ------
    LostReplyError
        If nobody knows whether it was paid.
    PlatformError
        If it was not.
    """
    call = replace(call, assignment=submission.assignment)
    alike = [entry for entry in ledger.entries() if _is_alike(entry.call, call)]
    for entry in alike:
        if entry.state in OPEN:
            raise PlatformError(
                f"payment {entry.id} of the same amount by the same assignment is in doubt",
                fix="decide about that one first",
            )
    # What the platform has accepted may not be listed yet.
    accepted = sum(entry.state == "done" for entry in alike)
    listed = platform.listed(submission, amount_of(call))
    call = replace(call, listed_before=max(listed, accepted))

    def do(entry: Entry) -> None:
        reference = _prepared(platform, submission, call)
        ledger.refer(entry, reference)
        platform.pay(submission, bonus_of(call), reference)

    try:
        ledger.carry_out(call, do, instead_of=instead_of)
    except LostReplyError:
        if not platform.token_lasts_s or not _is_found_out(ledger, platform, submission, call):
            raise


def was_paid(ledger: Ledger, platform: Platform, submission: Submission, entry: Entry) -> bool:
    """Whether a payment in doubt was made, as the ledger notes then.

    Where the platform knows the payment by its token, it is made again to find out. False
    says nothing: platforms pay later than they answer. A PlatformError says that it can't be asked.
    """
    if entry.reference is None:
        ledger.end(entry, "refused", f"{entry.problem}; nothing had been ordered yet")
        return False
    if _is_listed(ledger, platform, submission, entry):
        ledger.end(entry, "done")
        return True
    if now() - entry.attempted_at >= platform.token_lasts_s:
        return False
    reference, bonus = entry.reference, bonus_of(entry.call)
    try:
        ledger.carry_out(
            entry.call, lambda _: platform.pay(submission, bonus, reference), repeats=entry
        )
    except PlatformError:  # also if it knows the token: the list will show the payment
        return False
    return True


def amount_of(call: Call) -> Decimal:
    """What a payment pays."""
    assert call.amount is not None  # noqa: S101 - it is a payment
    return call.amount


def bonus_of(call: Call) -> Bonus:
    """A payment as it is sent to a platform."""
    return Bonus(f"{call.what} {call.key}", amount_of(call), call.reason)


def _is_found_out(ledger: Ledger, platform: Platform, submission: Submission, call: Call) -> bool:
    entry = ledger.find(call.what, call.key)
    try:
        return entry is not None and was_paid(ledger, platform, submission, entry)
    except PlatformError:
        return False


def _is_alike(one: Call, other: Call) -> bool:
    return (
        one.what in PAYMENTS
        and (one.what, one.key) != (other.what, other.key)
        and (one.assignment, one.amount) == (other.assignment, other.amount)
    )


def _is_listed(ledger: Ledger, platform: Platform, submission: Submission, entry: Entry) -> bool:
    before = entry.call.listed_before
    if before is None:  # an earlier program has paid
        others = [e for e in ledger.entries("done") if _is_alike(e.call, entry.call)]
        before = len(others)
    return platform.listed(submission, amount_of(entry.call)) > before


def _prepared(platform: Platform, submission: Submission, call: Call) -> str:
    try:
        return platform.prepare(submission, bonus_of(call))
    except LostReplyError as error:
        raise PlatformError(
            f"{error.what}; nothing had been ordered yet", where=error.where, fix="do it again"
        ) from error
