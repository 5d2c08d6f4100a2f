"""Approving, rejecting and paying: each assignment by itself, and each thing once.

Each call is in the ledger before it is made, and the platform's record is compared with it before
that. Calls in doubt, and payments discovered there, are left alone until somebody has decided; see
:mod:`annotation_app.crowds.decisions`. The database is never locked during a platform's request.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from decimal import Decimal
from functools import partial

from annotation_app.crowds.comparison import Comparison, Deed, bonus_of, deed_of
from annotation_app.crowds.ledger import OPEN, PAYMENTS, Call, Entry, Ledger, What, is_found
from annotation_app.crowds.platform import (
    Bonus,
    LostReplyError,
    Platform,
    PlatformError,
    Standing,
    Submission,
)
from annotation_app.crowds.reconciliation import Finding, known_platform_ids, unpaid_part
from annotation_app.store.installation import now

PART = "For the part of the work that we have received"
HOUR_S = 3600
"""Time for which a platform may still list an approved assignment as sent in, in seconds."""


@dataclass(frozen=True, slots=True)
class Wishes:
    """Options for settling the submitted assignments."""

    approve: bool = True
    """Approve what is ready."""
    approve_also: frozenset[str] = frozenset()
    """Assignments to approve though not all of them was received."""
    flagged: frozenset[str] = frozenset()
    """Ids of people whose work somebody is to look at first."""
    hold_flagged: bool = False
    """Leave their assignments for somebody to decide."""
    quality_bonus: Bonus | None = None
    """Bonus for the approved assignments of people who are not flagged."""
    reject: Mapping[str, str] = field(default_factory=dict)
    """Reasons by assignment."""
    bonuses: Sequence[tuple[str, Bonus]] = ()
    """Bonuses by assignment."""
    pay_partial: bool = False
    """Pay for the part that was received of what was never confirmed."""
    leave_out_unknown: bool = False
    """Leave out the answers of people whom the platform doesn't know."""


def settle(comparison: Comparison, findings: Sequence[Finding], wishes: Wishes) -> Iterator[Deed]:
    """Approve, reject and pay as far as possible. One assignment's failure stops no other."""
    ledger = comparison.ledger
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
            yield from _judge(comparison, finding, submission, reason)
        elif assignment in wishes.approve_also or (wishes.approve and finding.state == "ready"):
            why = _held(finding, wishes, was_to_be_rejected=assignment in refused_rejections)
            if why is not None:
                yield Deed(assignment, "held", note=why)
                continue
            for deed in _judge(comparison, finding, submission):
                yield deed
                if deed.what == "approve" and not deed.problem:
                    approved.add(assignment)
        elif wishes.hold_flagged and finding.person_id in wishes.flagged:
            yield Deed(assignment, "held")
    yield from _rewards(comparison, findings, wishes, approved)
    if wishes.pay_partial:
        yield from _partial(comparison, findings)


def _rewards(
    comparison: Comparison,
    findings: Sequence[Finding],
    wishes: Wishes,
    approved: Iterable[str],
) -> Iterator[Deed]:
    """Yield bonuses: for approved work of people who aren't flagged, and those specified."""
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
            yield from _pay(comparison, sent, sent.submission, named)


def _held(finding: Finding, wishes: Wishes, *, was_to_be_rejected: bool) -> str | None:
    """Return the reason for checking an assignment before its approval; None if there is none."""
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
    comparison: Comparison, finding: Finding, submission: Submission, reason: str | None = None
) -> Iterator[Deed]:
    """Approve an assignment, or reject it for a reason, unless that was done just now."""
    ledger, platform = comparison.ledger, comparison.platform
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
        if before.state in OPEN or (before.state in ("done", "found there") and is_young):
            return
    held: list[Deed] = []
    compared = _compared(comparison, submission, call, held)
    yield from compared
    if held:
        yield from held
        return
    wanted: Standing = "approved" if reason is None else "rejected"

    def judge(_: Entry) -> None:
        try:
            do()
        except LostReplyError:
            raise
        except PlatformError:
            # A refusal may mean that it was done before: the assignment itself shows it.
            if not _is_now(platform, submission, wanted):
                raise

    yield _told(call, lambda: ledger.carry_out(call, judge))


def _partial(comparison: Comparison, findings: Sequence[Finding]) -> Iterator[Deed]:
    payable = known_platform_ids(comparison.ledger.engine, findings)
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
        yield from _pay(comparison, finding, submission, bonus, what="partial payment")


def _pay(
    comparison: Comparison,
    finding: Finding,
    submission: Submission,
    bonus: Bonus,
    *,
    what: What = "bonus",
) -> Iterator[Deed]:
    ledger = comparison.ledger
    before = ledger.find(what, bonus.key)
    if before is not None and before.state != "refused":
        return
    ids = (bonus.key, submission.assignment, finding.participation_id)
    call = Call(what, *ids, bonus.amount, bonus.reason)
    held: list[Deed] = []
    for deed in _compared(comparison, submission, call, held):
        yield replace(deed, assignment=finding.assignment)
    before = ledger.find(what, bonus.key)
    if held or (before is not None and before.state != "refused"):
        yield from (replace(deed, assignment=finding.assignment) for deed in held)
        return
    entries = ledger.entries("done", assignment=submission.assignment)
    same = [e for e in entries if is_found(e) and e.call.what in PAYMENTS]
    for entry in same:
        if entry.call.amount == bonus.amount:
            ledger.adopt(entry, call)
            yield Deed(
                finding.assignment, what, amount=bonus.amount, note=f"{entry.id} was paid before"
            )
            return
    deed = _told(call, lambda: pay(ledger, comparison.platform, submission, call))
    yield replace(deed, assignment=finding.assignment)


def _compared(
    comparison: Comparison, submission: Submission, call: Call, held: list[Deed]
) -> Iterator[Deed]:
    """Compare what was paid by an assignment; `held` is filled if somebody has to decide first."""
    try:
        yield from comparison.payments(submission, call.participation_id)
    except PlatformError as error:
        held.append(deed_of(call, f"what was paid before could not be looked up: {error}"))
        return
    found = comparison.ledger.entries("found there", assignment=submission.assignment)
    if found and call.what != "reject":
        one = found[0]
        amount = "" if one.call.amount is None else f" {one.call.amount}"
        note = f"{one.call.what}{amount} was found there (entry {one.id}): decide about it first"
        held.append(
            Deed(submission.assignment, "held", amount=call.amount or Decimal(0), note=note)
        )


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
    """Order a bonus by a submission; the platform's list shows later whether it was paid.

    Nothing is ordered while a payment of the same amount by the same submission is in doubt:
    platforms list amounts, which don't show which of the two arrived. `instead_of` is the same
    payment in doubt, which somebody has decided to repeat.

    Raises
    ------
    LostReplyError
        If it is unknown whether it was ordered.
    PlatformError
        If it was not.
    """
    call = replace(call, assignment=submission.assignment)
    for entry in ledger.entries(*OPEN, assignment=submission.assignment):
        if _is_alike(entry.call, call):
            raise PlatformError(
                f"payment {entry.id} of the same amount by the same assignment is in doubt",
                fix="decide about that one first",
            )

    def do(entry: Entry) -> None:
        reference = _prepared(platform, submission, call)
        ledger.refer(entry, reference)
        platform.pay(submission, bonus_of(call), reference)

    ledger.carry_out(call, do, instead_of=instead_of)


def _is_alike(one: Call, other: Call) -> bool:
    return (
        one.what in PAYMENTS
        and (one.what, one.key) != (other.what, other.key)
        and (one.assignment, one.amount) == (other.assignment, other.amount)
    )


def _is_now(platform: Platform, submission: Submission, standing: Standing) -> bool:
    try:
        return platform.standing(submission) == standing
    except PlatformError:
        return False


def _prepared(platform: Platform, submission: Submission, call: Call) -> str:
    try:
        return platform.prepare(submission, bonus_of(call))
    except LostReplyError as error:
        raise PlatformError(
            f"{error.what}; nothing had been ordered yet", where=error.where, fix="do it again"
        ) from error
