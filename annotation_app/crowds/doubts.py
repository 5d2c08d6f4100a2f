"""Calls of which nobody knows whether they were carried out: what the platform says of them.

What the platform doesn't settle, somebody has to decide.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from annotation_app.crowds.ledger import PAYMENTS, Entry, Ledger
from annotation_app.crowds.platform import LostReplyError, Platform, PlatformError, Submission
from annotation_app.crowds.settlement import Deed, deed_of, pay, was_paid
from g3.errors import FormatError

CONFIRM, AGAIN = "--confirm-paid", "--pay-again"


class Decisions(NamedTuple):
    """What somebody says of calls in doubt: that they were carried out, or are to be made again."""

    confirmed: tuple[Entry, ...]
    again: tuple[Entry, ...]


def read_decisions(
    ledger: Ledger, confirm_paid: tuple[int, ...], pay_again: tuple[int, ...]
) -> Decisions:
    """Find the calls that somebody has decided about; an error if one isn't there or in doubt."""
    both = set(confirm_paid) & set(pay_again)
    if both:
        raise FormatError(
            f"payment {min(both)} can't be confirmed and paid again",
            where=CONFIRM,
            fix="decide for one of them",
        )
    known = {entry.id: entry for entry in ledger.entries()}
    return Decisions(
        tuple(_find(known, number, CONFIRM) for number in dict.fromkeys(confirm_paid)),
        tuple(_find(known, number, AGAIN) for number in dict.fromkeys(pay_again)),
    )


def resolve(
    ledger: Ledger, platform: Platform, submissions: Mapping[str, Submission]
) -> Iterator[Deed]:
    """Ask the platform about each call in doubt; what it was found to be."""
    for entry in ledger.entries("in doubt"):
        submission = submissions.get(entry.call.assignment)
        if submission is None:
            continue
        if entry.call.what in PAYMENTS:
            yield from _look_at_payment(ledger, platform, submission, entry)
        else:
            yield from _look_at_standing(ledger, submission, entry)


def decide(
    ledger: Ledger,
    platform: Platform,
    submissions: Mapping[str, Submission],
    decisions: Decisions,
) -> Iterator[Deed]:
    """Do what somebody has decided, as far as the platform hasn't settled it meanwhile."""
    still = {entry.id: entry for entry in ledger.entries("in doubt")}
    for entry in decisions.confirmed:
        if entry.id in still:
            ledger.decide(entry, "done", "confirmed as paid")
            yield deed_of(entry.call, note=f"{entry.id} is confirmed")
    for entry in decisions.again:
        if entry.id not in still:
            found = ledger.find(entry.call.what, entry.call.key)
            if found is not None and found.state == "done":
                yield deed_of(
                    entry.call, f"{entry.id} was carried out before, so it isn't done again"
                )
        elif entry.call.what in PAYMENTS:
            yield _paid_again(ledger, platform, submissions, still[entry.id])
        else:
            ledger.decide(entry, "refused", "to be done again")


def _find(known: Mapping[int, Entry], number: int, option: str) -> Entry:
    entry = known.get(number)
    if entry is None or entry.state != "in doubt":
        raise FormatError(
            f"the ledger has no entry {number}"
            if entry is None
            else f"entry {number} is not in doubt but {entry.state}",
            where=option,
            fix="`ct crowd reconcile` shows what is in doubt",
        )
    if entry.call.what == "publish":
        raise FormatError(
            f"entry {number} offers work and pays nobody",
            where=option,
            fix="`ct crowd publish` looks whether the work is offered, and takes --publish-again",
        )
    return entry


def _look_at_payment(
    ledger: Ledger, platform: Platform, submission: Submission, entry: Entry
) -> Iterator[Deed]:
    try:
        if was_paid(ledger, platform, submission, entry):
            yield deed_of(entry.call, note=f"payment {entry.id} was paid")
        elif entry.reference is None:
            yield deed_of(
                entry.call, note=f"payment {entry.id} was not paid: it had not been ordered yet"
            )
    except PlatformError as error:
        yield deed_of(entry.call, f"payment {entry.id} could not be looked up: {error}")


def _look_at_standing(ledger: Ledger, submission: Submission, entry: Entry) -> Iterator[Deed]:
    wanted = "approved" if entry.call.what == "approve" else "rejected"
    if submission.standing == wanted:
        ledger.end(entry, "done")
        yield deed_of(entry.call, note=f"the platform says that it is {wanted}")
    else:
        ledger.end(entry, "refused", f"{entry.problem}; the platform says {submission.standing}")


def _paid_again(
    ledger: Ledger, platform: Platform, submissions: Mapping[str, Submission], entry: Entry
) -> Deed:
    submission = submissions.get(entry.call.assignment)
    if submission is None:
        return deed_of(entry.call, "the platform doesn't list this assignment any more")
    try:
        pay(ledger, platform, submission, entry.call, instead_of=entry)
    except LostReplyError as error:
        return deed_of(entry.call, str(error), in_doubt=True)
    except PlatformError as error:
        return deed_of(entry.call, str(error))
    return deed_of(entry.call, note="paid again")
