"""What workers of Mechanical Turk do in the tests."""

from __future__ import annotations

from flask import Flask
from sqlalchemy import select, update

from annotation_app.store.crowd_models import LedgerEntry, Participation
from annotation_app.store.database import reading, transaction
from annotation_app.store.models import Answer
from tests.annotation_app.browser import described, engine_of
from tests.annotation_app.crowds.crowd_worker import CrowdWorker
from tests.annotation_app.crowds.stand_ins import MechanicalTurk

DAY_S = 86_400


def worker(app: Flask, address: str, mturk: MechanicalTurk, name: str = "W1") -> CrowdWorker:
    return CrowdWorker(app, address, mturk.accept(name))


def work(one: CrowdWorker, count: int = 2) -> None:
    for _ in range(count):
        one.do("describe", described())


def participations(app: Flask) -> list[Participation]:
    with reading(engine_of(app)) as session:
        return list(session.scalars(select(Participation).order_by(Participation.id)))


def ledger(app: Flask) -> list[tuple[str, str, str]]:
    """What was done, its key, and its state."""
    with reading(engine_of(app)) as session:
        rows = session.scalars(select(LedgerEntry).order_by(LedgerEntry.id))
        return [(row.what, row.key, row.state) for row in rows]


def grow_old(app: Flask) -> None:
    """The platform's time for all assignments is over."""
    with transaction(engine_of(app)) as session:
        session.execute(update(Participation).values(begun_at=Participation.begun_at - 2 * DAY_S))
        session.execute(update(Answer).values(at=Answer.at - 2 * DAY_S + 60))
