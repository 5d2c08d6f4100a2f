"""Bonuses, each paid once: noted before, looked up after, and never repeated blindly."""

from __future__ import annotations

from dataclasses import replace
from decimal import Decimal

from annotation_app.crowds.ledger import OPEN, PAYMENTS, Call, Entry, Ledger
from annotation_app.crowds.platform import (
    Bonus,
    LostReplyError,
    Platform,
    PlatformError,
    Submission,
)
from annotation_app.store.installation import now


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
    Platforms list amounts, and nobody could see which of the two arrived.

    Parameters
    ----------
    instead_of
        The same payment in doubt, of which somebody has decided that it is made again.

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
    says nothing: platforms pay later than they answer.

    Raises
    ------
    PlatformError
        If the platform can't be asked.
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
