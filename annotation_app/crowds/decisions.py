"""Decisions about calls in doubt, and about payments discovered at the platform."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from annotation_app.crowds.comparison import Deed, deed_of
from annotation_app.crowds.ledger import DOUBTED, PAYMENTS, Entry, Ledger
from annotation_app.crowds.platform import LostReplyError, Platform, PlatformError, Submission
from annotation_app.crowds.settlement import pay
from g3.errors import FormatError

CONFIRM, AGAIN = "--confirm-paid", "--pay-again"


@dataclass(frozen=True, slots=True)
class Decisions:
    """Somebody's decisions, by the ledger's ids of calls.

    Parameters
    ----------
    confirmed
        Calls that were carried out; payments discovered there that are among the planned ones.
    again
        Calls to make again; payments discovered there that are none of the planned ones.
    all_found
        True if all payments discovered there are confirmed.
    current
        True if the ledger is complete again after a restore.
    """

    confirmed: tuple[int, ...] = ()
    again: tuple[int, ...] = ()
    all_found: bool = False
    current: bool = False


def check_decisions(ledger: Ledger, decisions: Decisions) -> None:
    """Check that all decisions are possible; a FormatError names those that aren't."""
    both = set(decisions.confirmed) & set(decisions.again)
    if both:
        raise FormatError(
            f"payment {min(both)} can't be confirmed and paid again",
            where=CONFIRM,
            fix="decide for one of them",
        )
    known = {entry.id: entry for entry in ledger.entries()}
    for option, numbers in ((CONFIRM, decisions.confirmed), (AGAIN, decisions.again)):
        for number in numbers:
            _check(known.get(number), number, option)


def decide(
    ledger: Ledger,
    platform: Platform,
    submissions: Mapping[str, Submission],
    decisions: Decisions,
) -> Iterator[Deed]:
    """Carry somebody's decisions out, as far as the platform hasn't settled them meanwhile."""
    still = {entry.id: entry for entry in ledger.entries(*DOUBTED)}
    for entry in still.values():
        is_found = entry.state == "found there"
        if entry.id in decisions.confirmed or (decisions.all_found and is_found):
            is_doubt = entry.call.what in PAYMENTS and not is_found
            ledger.decide(entry, "confirmed" if is_doubt else "done", "confirmed as paid")
            yield deed_of(entry.call, note=f"{entry.id} is confirmed")
    for number in dict.fromkeys(decisions.again):
        if number in still:
            yield from _again(ledger, platform, submissions, still[number])
            continue
        entry = next(entry for entry in ledger.entries() if entry.id == number)
        if entry.state == "done":
            yield deed_of(entry.call, f"{entry.id} was carried out before, so it isn't done again")


def _check(entry: Entry | None, number: int, option: str) -> None:
    if entry is None or entry.state not in DOUBTED:
        raise FormatError(
            f"the ledger has no entry {number}"
            if entry is None
            else f"entry {number} is not in doubt but {entry.state}",
            where=option,
            fix="`ct crowd reconcile` shows what is in doubt",
        )
    if entry.state == "found there":
        if option == AGAIN and entry.call.what not in PAYMENTS:
            raise FormatError(
                f"entry {number} pays no bonus", where=option, fix=f"{CONFIRM} it if you know of it"
            )
    elif entry.call.what == "publish":
        raise FormatError(
            f"entry {number} offers work and pays nobody",
            where=option,
            fix="`ct crowd publish` looks whether the work is offered, and takes --publish-again",
        )


def _again(
    ledger: Ledger, platform: Platform, submissions: Mapping[str, Submission], entry: Entry
) -> Iterator[Deed]:
    if entry.state == "found there":
        ledger.set_apart(entry)
        yield deed_of(entry.call, note=f"{entry.id} is apart from what is to be paid")
    elif entry.call.what in PAYMENTS:
        yield _paid_again(ledger, platform, submissions, entry)
    else:
        ledger.decide(entry, "refused", "to be done again")


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
