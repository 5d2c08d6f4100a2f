"""What earlier programs noted of approvals and payments comes into the ledger."""

from __future__ import annotations

from typing import Any

import pytest
from sqlalchemy import select

from annotation_app.core.config import Config
from annotation_app.store.crowd_models import LedgerEntry, Participation
from annotation_app.store.database import opened
from annotation_app.store.schema import migrate
from tests.annotation_app.browser import rows_in
from tests.annotation_app.old_installations import put_rows

OUTCOMES: dict[str, dict[str, Any]] = {
    "A1": {
        "submit_to": "https://www.mturk.com",
        "approved_at": 200.0,
        "bonuses": {
            "quality": {
                "amount": "0.25",
                "reference": "A1-quality-1",
                "reason": "For careful work",
                "paid_at": 201.0,
            },
            "partial": {"amount": "0.10", "reference": "A9-partial-1", "reason": "For the part"},
        },
    },
    "A2": {"rejected_at": 300.0, "reason": "There was no work.", "nothing_left": True},
    "A3": {},
}


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_past_payments_come_into_the_ledger(config: Config) -> None:
    with opened(config.database) as engine:
        migrate(engine, "0001")
        outcomes = [("participation", {"assignment": a, "outcome": o}) for a, o in OUTCOMES.items()]
        put_rows(engine, ("study", {}), ("person", {}), *outcomes)
        migrate(engine)
        entries = [
            (e.what, e.key, e.assignment, e.amount, e.state, e.reference, e.reason, e.ended_at)
            for e in rows_in(engine, select(LedgerEntry).order_by(LedgerEntry.id))
        ]
        left = {p.assignment: p.outcome for p in rows_in(engine, select(Participation))}
    assert entries == [
        ("approve", "A1", "A1", "", "done", None, "", 200.0),
        (
            *("bonus", "A1 quality", "A1", "0.25", "done", "A1-quality-1"),
            *("For careful work", 201.0),
        ),
        # An earlier program noted nothing before it had an answer, so this may have been paid.
        (
            *("partial payment", "A1", "A9", "0.10", "in doubt", "A9-partial-1"),
            *("For the part", None),
        ),
        ("reject", "A2", "A2", "", "done", None, "There was no work.", 300.0),
    ]
    assert left == {
        "A1": {"submit_to": "https://www.mturk.com"},
        "A2": {"nothing_left": True},
        "A3": {},
    }
