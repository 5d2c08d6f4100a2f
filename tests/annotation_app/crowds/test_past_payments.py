"""What earlier programs noted of approvals and payments comes into the ledger."""

from __future__ import annotations

import json
from typing import Any

import pytest
from sqlalchemy import Engine, select, text

from annotation_app.core.config import Config
from annotation_app.store.crowd_models import LedgerEntry, Participation
from annotation_app.store.database import opened, reading
from annotation_app.store.schema import migrate

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
        fill(engine)
        migrate(engine)
        with reading(engine) as session:
            entries = [
                (e.what, e.key, e.assignment, e.amount, e.state, e.reference, e.reason, e.ended_at)
                for e in session.scalars(select(LedgerEntry).order_by(LedgerEntry.id))
            ]
            left = {p.assignment: p.outcome for p in session.scalars(select(Participation))}
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


def fill(engine: Engine) -> None:
    with engine.begin() as connection:
        connection.execute(
            text("INSERT INTO study (id, name, config, created_at) VALUES ('s', 's', '{}', 1)")
        )
        connection.execute(
            text(
                "INSERT INTO person (id, role, provider, external_hash, profile, created_at) "
                "VALUES ('p', 'worker', 'mturk', 'h', '{}', 1)"
            )
        )
        for assignment, outcome in OUTCOMES.items():
            connection.execute(
                text(
                    "INSERT INTO participation (study_id, person_id, provider, assignment, task, "
                    "items, begun_at, outcome) "
                    "VALUES ('s', 'p', 'mturk', :assignment, 'describe', 2, 100, :outcome)"
                ),
                {"assignment": assignment, "outcome": json.dumps(outcome)},
            )
