"""What workers of Mechanical Turk do in the tests."""

from __future__ import annotations

from flask import Flask
from sqlalchemy import select, update

from annotation_app.store.models import Answer, LedgerEntry, Participation
from tests.annotation_app.browser import described, execute, rows_in
from tests.annotation_app.crowds.crowd_worker import CrowdWorker
from tests.annotation_app.crowds.stand_ins import MechanicalTurk

DAY_S = 86_400


def worker(app: Flask, address: str, mturk: MechanicalTurk, name: str = "W1") -> CrowdWorker:
    return CrowdWorker(app, address, mturk.accept(name))


def work(one: CrowdWorker, count: int = 2) -> None:
    for _ in range(count):
        one.do("describe", described())


def participations(app: Flask) -> list[Participation]:
    return rows_in(app, select(Participation).order_by(Participation.id))


def ledger(app: Flask) -> list[tuple[str, str, str]]:
    """What was done, its key, and its state."""
    rows = rows_in(app, select(LedgerEntry).order_by(LedgerEntry.id))
    return [(row.what, row.key, row.state) for row in rows]


def grow_old(app: Flask) -> None:
    """The platform's time for all assignments is over."""
    execute(app, update(Participation).values(begun_at=Participation.begun_at - 2 * DAY_S))
    execute(app, update(Answer).values(at=Answer.at - 2 * DAY_S + 60))
