"""Two people who agree and answer at the same moment."""

from __future__ import annotations

import uuid
from concurrent.futures import ThreadPoolExecutor
from threading import Barrier

import pytest
from flask import Flask
from sqlalchemy import select

from annotation_app.items.new_items import new_slots
from annotation_app.items.submissions import submit
from annotation_app.store.database import transaction
from annotation_app.store.installation import now
from annotation_app.store.models import Answer, Item, Slot
from annotation_app.work import adoption
from tests.annotation_app.browser import Browser, described, engine_of, row_in, rows_in
from tests.annotation_app.work.test_adoption import SDCS


@pytest.mark.parametrize("kind", ["postgresql"])  # SQLite has one writer at a time
def test_the_last_two_answers_are_adopted_though_neither_saw_the_other(app: Flask) -> None:
    people, engine = (Browser(app), Browser(app)), engine_of(app)
    people[0].do("describe", described())
    with transaction(engine) as session:
        segmenting = session.scalars(select(Item).where(Item.task == "segment")).one()
        slots = session.scalars(select(Slot).where(Slot.item_id == segmenting.id)).all()
        session.add_all(new_slots(segmenting, 2 - len(slots)))
    assert {person.take("segment")["item"] for person in people} == {segmenting.id}
    both_written = Barrier(2, timeout=30)

    def send(person: Browser) -> None:
        with transaction(engine) as session:
            receipt = submit(
                session,
                segmenting,
                person.person.id,
                uuid=str(uuid.uuid4()),
                sent={"sdcs": SDCS},
                body={"sdcs": SDCS},
                adopted=False,
                now=now(),
            )
            assert receipt.answer is not None
            both_written.wait()
            adoption.answered(session, segmenting.task, receipt.answer)

    with ThreadPoolExecutor(2) as pool:
        list(pool.map(send, people))
    adopted = rows_in(engine, select(Answer.adopted).where(Answer.item_id == segmenting.id))
    assert sorted(adopted) == [False, True]
    assert row_in(engine, select(Item).where(Item.task == "ground"))
