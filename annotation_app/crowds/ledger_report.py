"""The ledger as people and programs are shown it. People are named as exports name them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from datetime import datetime, timezone
from decimal import Decimal

from annotation_app.crowds.ledger import OPEN, PAYMENTS, Entry
from annotation_app.store.models import Record


def entry_records(entries: Sequence[Entry]) -> list[Record]:
    """Calls as records, for programs."""
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
            "attempted_at": _moment(entry.attempted_at),
            "ended_at": None if entry.ended_at is None else _moment(entry.ended_at),
            "problem": entry.problem,
        }
        for entry in entries
    ]


def doubt_lines(entries: Sequence[Entry]) -> Iterator[str]:
    """Each call of which nobody knows whether it was carried out, for people."""
    for entry in entries:
        if entry.state not in OPEN:
            continue
        call = entry.call
        what = call.what if call.amount is None else f"{call.what} {call.amount}"
        if call.what == "publish":
            whom = call.reason
        else:
            whom = f"assignment {_meant(entry)}, person {entry.subject or 'unknown'}"
        why = entry.problem or "under way, or its program has stopped"
        yield f"in doubt: {entry.id}: {what}, {whom}, {_moment(entry.attempted_at)}: {why}"


def total_lines(entries: Sequence[Entry]) -> Iterator[str]:
    """How many calls of each kind there are in each state, and what they pay."""
    kinds = sorted({(entry.call.what, entry.state) for entry in entries})
    for what, state in kinds:
        amounts = [e.call.amount for e in entries if (e.call.what, e.state) == (what, state)]
        known = [amount for amount in amounts if amount is not None]
        total = f", {sum(known, Decimal(0))} in all" if known else ""
        yield f"{len(amounts):6} {what} {state}{total}"


def _meant(entry: Entry) -> str:
    """The assignment that a call is for: people may be paid by another of theirs."""
    return "" if entry.call.what == "publish" else entry.call.key.partition(" ")[0]


def _moment(at: float) -> str:
    return datetime.fromtimestamp(at, timezone.utc).isoformat(" ", "seconds")
