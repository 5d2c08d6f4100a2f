"""Opening a page holds its item for a short while; the first action leases it."""

from __future__ import annotations

import pytest
from flask import Flask
from sqlalchemy import select, update

from annotation_app.store.database import reading
from annotation_app.store.installation import now
from annotation_app.store.models import Draft, Slot
from annotation_app.studies.study_file import StudyConfig, TaskConfig
from annotation_app.work.handing_out import HOLD_S
from tests.annotation_app.browser import Browser, described, engine_of, execute, row_in
from tests.annotation_app.conftest import study_of
from tests.annotation_app.rendered import VIDEOS

LEASE_S = 3600.0

pytestmark = pytest.mark.parametrize("kind", ["sqlite", "postgresql"])


@pytest.fixture
def study() -> StudyConfig:
    """As many items as videos, and one answer each."""
    return study_of(describe=TaskConfig(lease_minutes=LEASE_S / 60, practice=False))


def visit(person: Browser) -> bool:
    """Open the task's page; whether there is an item on it."""
    page = person.client.get("/s/tests/describe")
    assert page.status_code == 200
    return b'id="item"' in page.data


def held(app: Flask, person: Browser) -> tuple[str, float] | None:
    """The item that somebody has, and for how long."""
    with reading(engine_of(app)) as session:
        slot = session.scalars(select(Slot).where(Slot.person_id == person.person.id)).first()
        return None if slot is None else (slot.item_id, slot.expires_at - now())


def let_pass(app: Flask, seconds: float) -> None:
    execute(
        app,
        update(Slot)
        .where(Slot.expires_at.is_not(None))
        .values(expires_at=Slot.expires_at - seconds),
    )


def begin(person: Browser, item: str) -> bool:
    reply = person.send("POST", f"/api/items/{item}/begin", {})
    assert reply.status_code == 200, reply.text
    return bool(reply.json["leased"])


def test_curious_visitors_block_nobody(app: Flask) -> None:
    assert all(visit(Browser(app)) for _ in VIDEOS)
    worker = Browser(app)
    assert not visit(worker)
    let_pass(app, HOLD_S + 1)
    assert visit(worker)


def test_the_first_action_leases_the_item(app: Flask) -> None:
    person = Browser(app)
    visit(person)
    item, left = held(app, person)
    assert HOLD_S - 30 < left <= HOLD_S
    assert begin(person, item)
    assert held(app, person)[1] > LEASE_S - 30
    visit(person)
    assert held(app, person) == (item, pytest.approx(LEASE_S, abs=30)), "reloading takes nothing"


def test_an_action_after_the_hold_still_counts(app: Flask) -> None:
    person = Browser(app)
    visit(person)
    item, _ = held(app, person)
    let_pass(app, HOLD_S + 1)
    assert begin(person, item), "nobody else has taken it"
    assert person.answer(item, described()).json["state"] == "accepted"


def test_whose_item_has_gone_is_told_and_loses_nothing(app: Flask) -> None:
    slow = Browser(app)
    visit(slow)
    item, _ = held(app, slow)
    let_pass(app, HOLD_S + 1)
    for _ in VIDEOS:
        other = Browser(app)
        assert visit(other)
        taken, _ = held(app, other)
        assert begin(other, taken)
        if taken == item:
            break
    assert not begin(slow, item)
    assert slow.draft(item, 1, {"text": "Go"}).json == {"kept": True, "leased": False}
    assert row_in(app, select(Draft)).body == {"text": "Go"}
    assert slow.answer(item, described("Go.")).json["state"] == "surplus"
    assert other.answer(item, described("Go there.")).json["state"] == "accepted"


def test_strangers_hold_nothing(app: Flask) -> None:
    person = Browser(app)
    visit(person)
    item, left = held(app, person)
    reply = Browser(app).send("POST", f"/api/items/{item}/begin", {})
    assert reply.status_code == 404
    assert held(app, person)[1] == pytest.approx(left, abs=5)
