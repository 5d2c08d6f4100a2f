"""The platform's own record, held against the ledger before anything is approved or paid.

The platform's word settles what is open in the ledger. What it shows and the ledger doesn't have is
noted as *found there*, and holds payments until somebody has decided. A payment that the ledger has
as done and that the platform doesn't list, or not any more, is in doubt.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from itertools import count, islice
from typing import Literal, NamedTuple

from annotation_app.crowds.ledger import (
    OPEN,
    PAYMENTS,
    Call,
    Entry,
    Ledger,
    State,
    What,
    apart,
    found_key,
)
from annotation_app.crowds.platform import (
    Bonus,
    Offered,
    Platform,
    PlatformError,
    Standing,
    Submission,
    label_prefix,
)
from annotation_app.store.installation import now

FOUND = "the platform has it, and this ledger did not make it"
GONE = "the platform doesn't list it any more"
LATE_S = 3600.0
"""Time after which an ordered payment should be listed, in seconds. Prolific says "minutes"."""
_TERMS = re.compile(r"(\S+) (\d+)(?: \d+)?(?: found \S+)?")
"""Suffix of the ledger's keys of offers, after the study's prefix."""
_MAY_EXPLAIN: tuple[State, ...] = ("confirmed", "ordered", "in doubt", "refused")
"""States of payments that may be one that the platform lists; the likeliest come first."""


@dataclass(frozen=True, slots=True)
class Deed:
    """An action or discovery of a settlement, or an action that failed.

    `problem` is the reason of a failure, and `note` a further remark. It is unknown whether an
    action that is `in_doubt` was carried out.
    """

    assignment: str
    what: What | Literal["held", "answers"]
    problem: str = ""
    amount: Decimal = Decimal(0)
    note: str = ""
    in_doubt: bool = False


class Terms(NamedTuple):
    """Terms of an offer: the number of items of a task, and the reward; None if not noted."""

    task: str
    items: int
    reward: Decimal | None


def deed_of(call: Call, problem: str = "", *, note: str = "", in_doubt: bool = False) -> Deed:
    """Return the outcome of a call."""
    amount = call.amount or Decimal(0)
    return Deed(call.assignment, call.what, problem, amount, note, in_doubt)


def bonus_of(call: Call) -> Bonus:
    """Return a payment as it is sent to a platform."""
    return Bonus(f"{call.what} {call.key}", amount_of(call), call.reason)


def amount_of(call: Call) -> Decimal:
    """Return the amount of a payment."""
    assert call.amount is not None  # noqa: S101 - it is a payment
    return call.amount


def terms_offered(ledger: Ledger) -> Mapping[str, Terms]:
    """Return the terms offered here, by the platform's ids of the work."""
    offers = ledger.entries("done", everywhere=True)
    terms = ((entry.reference, _terms(ledger, entry)) for entry in offers)
    return {reference: one for reference, one in terms if reference and one}


def compare_offers(ledger: Ledger, offered: Iterable[Offered]) -> None:
    """Note which work the platform shows: what was in doubt, and what wasn't offered from here."""
    offers = {entry.call.key: entry for entry in ledger.entries() if _terms(ledger, entry)}
    known = {entry.reference for entry in ledger.entries(everywhere=True)}
    for work in offered:
        entry = offers.get(work.label)
        if work.id in known:
            continue
        # A platform that has refused the same offer again has not said which one it was.
        if entry is not None and entry.reference in (None, entry.call.key):
            ledger.refer(entry, work.id)
            ledger.end(entry, "done")
        elif _TERMS.fullmatch(work.label.removeprefix(label_prefix(ledger.study_id))):
            key = f"{work.label} found {work.id}"
            ledger.take_in(Call("publish", key, amount=work.reward, reason=FOUND), work.id)


def _terms(ledger: Ledger, entry: Entry) -> Terms | None:
    prefix = label_prefix(ledger.study_id)
    if entry.call.what != "publish" or not entry.call.key.startswith(prefix):
        return None
    found = _TERMS.fullmatch(entry.call.key.removeprefix(prefix))
    return None if found is None else Terms(found[1], int(found[2]), entry.call.amount)


@dataclass(frozen=True, slots=True)
class Comparison:
    """A ledger and a platform. The payments by an assignment are compared once."""

    ledger: Ledger
    platform: Platform
    compared: set[str] = field(default_factory=set)

    def standings(
        self, submissions: Iterable[Submission], participations: Mapping[str, int | None]
    ) -> Iterator[Deed]:
        """Compare what was approved and rejected.

        `participations` are the ids of assignments here, by those at the platform.
        """
        judged = ("approve", "reject")
        entries = [entry for entry in self.ledger.entries() if entry.call.what in judged]
        noted = {(entry.call.what, entry.call.assignment): entry for entry in entries}
        for one in submissions:
            for what, wanted in _STANDINGS.items():
                entry = noted.get((what, one.assignment))
                if entry is not None:
                    yield from self._standing(one, entry, wanted)
                elif one.standing == wanted:
                    reward = one.reward if what == "approve" else None
                    here = participations.get(one.assignment)
                    ids = (one.assignment, one.assignment, here)
                    self.ledger.take_in(Call(what, *ids, reward, FOUND))

    def _standing(self, submission: Submission, entry: Entry, wanted: Standing) -> Iterator[Deed]:
        if entry.state not in ("in doubt", "refused"):
            return
        standing = submission.standing
        try:
            if entry.state == "in doubt" and standing != wanted:
                standing = self.platform.standing(submission)
        except PlatformError as error:
            yield deed_of(entry.call, f"entry {entry.id} could not be looked up: {error}")
            return
        if standing == wanted:
            self.ledger.end(entry, "done")
            yield deed_of(entry.call, note=f"the platform says that it is {wanted}")
        elif entry.state == "in doubt":
            problem = f"{entry.problem}; the platform says {standing}"
            self.ledger.end(entry, "refused", problem)

    def payments(self, submission: Submission, participation_id: int | None) -> Iterator[Deed]:
        """Compare the payments by an assignment; a PlatformError if they can't be read."""
        if submission.assignment in self.compared:
            return
        listed = list(self.platform.paid(submission))
        self.compared.add(submission.assignment)
        entries = self.ledger.entries(assignment=submission.assignment)
        mine = [entry for entry in entries if entry.call.what in PAYMENTS]
        for amount in sorted({*listed, *(amount_of(entry.call) for entry in mine)}):
            alike = [entry for entry in mine if entry.call.amount == amount]
            yield from self._payments(submission, alike, listed.count(amount))
            more = listed.count(amount) - sum(entry.state != "attempted" for entry in alike)
            for key in islice(_free_keys(submission.assignment, amount, alike), max(0, more)):
                ids = (key, submission.assignment, participation_id)
                self.ledger.take_in(Call("bonus", *ids, amount, FOUND))

    def _payments(
        self, submission: Submission, alike: Sequence[Entry], listed: int
    ) -> Iterator[Deed]:
        """Settle payments of one amount, of which the platform lists so many."""
        settled = [entry for entry in alike if entry.state in ("done", "found there")]
        open_ = [entry for state in _MAY_EXPLAIN for entry in alike if entry.state == state]
        arrived = open_[: max(0, listed - len(settled))]
        for entry in arrived:
            self.ledger.end(entry, "done")
            if entry.state != "ordered":
                yield deed_of(entry.call, note=f"payment {entry.id} was paid")
        for entry in reversed(settled[listed:]):
            self.ledger.end(entry, "in doubt", GONE)
        for entry in open_[len(arrived) :]:
            if entry.state == "in doubt":
                yield from self._look_again(submission, entry)
            elif entry.state == "ordered" and _is_late(entry):
                self.ledger.end(entry, "in doubt", "accepted an hour ago, and it isn't listed")

    def _look_again(self, submission: Submission, entry: Entry) -> Iterator[Deed]:
        """Find out more about a payment in doubt that isn't listed.

        A payment without a reference was never ordered, unless it was listed before. Where the
        platform recognises the payment by its token, it is sent again.
        """
        if entry.problem == GONE:
            return
        if entry.reference is None:
            problem = f"{entry.problem}; nothing had been ordered yet"
            self.ledger.end(entry, "refused", problem)
            note = f"payment {entry.id} was not paid: it had not been ordered yet"
            yield deed_of(entry.call, note=note)
        elif now() - entry.attempted_at < self.platform.token_lasts_s:
            reference, bonus = entry.reference, bonus_of(entry.call)
            try:
                self.ledger.carry_out(
                    entry.call,
                    lambda _: self.platform.pay(submission, bonus, reference),
                    repeats=entry,
                )
            except PlatformError:  # also if it knows the token: the list will show the payment
                return
            yield deed_of(entry.call, note=f"payment {entry.id} was sent again by its token")


_STANDINGS: Mapping[What, Standing] = {"approve": "approved", "reject": "rejected"}


def _free_keys(assignment: str, amount: Decimal, alike: Iterable[Entry]) -> Iterator[str]:
    """Return keys for payments of an amount that are discovered there, of which none is taken."""
    taken = {entry.call.key for entry in alike}
    keys = (found_key(assignment, amount, number) for number in count(1))
    return (key for key in keys if not {key, apart(key)} & taken)


def _is_late(entry: Entry) -> bool:
    return now() - (entry.ended_at or entry.attempted_at) > LATE_S


def is_open(entry: Entry) -> bool:
    """Check that a payment waits for the platform's list or for a decision."""
    return entry.call.what in PAYMENTS and entry.state in ("ordered", *OPEN)
