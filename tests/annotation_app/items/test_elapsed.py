"""Clocks that are set forward or back cost no answer, and no wrong durations are kept."""

from __future__ import annotations

import csv
import io
import time
from collections.abc import Callable

import pytest
from flask import Flask
from limits import parse
from limits.strategies import MovingWindowRateLimiter
from sqlalchemy import select

from annotation_app.dashboard.study_statistics import durations
from annotation_app.dashboard.workers import workers
from annotation_app.items import elapsed
from annotation_app.store.database import reading, transaction
from annotation_app.store.models import Answer, Handout, Slot, Study
from annotation_app.studies.study_file import TaskConfig
from annotation_app.web.limits import ProcessStorage
from tests.annotation_app.browser import Browser, described, engine_of, exported, row_in, rows_in
from tests.annotation_app.conftest import study_of

DAY_S = 24 * 3600.0
KINDS = pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
JUMPS = pytest.mark.parametrize("jump_s", [-DAY_S, DAY_S])


@KINDS
@JUMPS
def test_the_clock_jumps_between_handout_and_answer(
    app: Flask, jump_s: float, set_clock: Callable[[float], None]
) -> None:
    browser = Browser(app)
    item = browser.take("describe")["item"]
    set_clock(jump_s)
    # A signed cookie has a time as well; whose it is isn't what is tested here.
    browser.sign_in()
    assert browser.draft(item, 1, {"text": "Go"}).json == {"kept": True, "leased": True}
    response = browser.answer(item, described())
    assert response.status_code == 200, response.text
    assert response.json["state"] == "accepted"
    seconds = row_in(app, select(Answer)).seconds
    assert seconds is not None
    assert 0 <= seconds < 60


@KINDS
@pytest.mark.parametrize(
    ("jump_s", "least_s", "most_s"),
    [(-DAY_S, None, None), (DAY_S, DAY_S, DAY_S + 60), (8 * DAY_S, None, None), (0, 0, 60)],
)
def test_after_another_boot_the_clock_tells_if_it_can(
    app: Flask,
    jump_s: float,
    least_s: float | None,
    most_s: float | None,
    monkeypatch: pytest.MonkeyPatch,
    set_clock: Callable[[float], None],
) -> None:
    browser = Browser(app)
    item = browser.take("describe")["item"]
    set_clock(jump_s)
    monkeypatch.setattr(elapsed, "boot", lambda: "the next one")
    monkeypatch.setattr(elapsed, "_since_boot_s", lambda: 5.0)
    browser.sign_in()
    assert browser.answer(item, described()).status_code == 200
    seconds = row_in(app, select(Answer)).seconds
    if least_s is None or most_s is None:
        assert seconds is None
    else:
        assert seconds is not None
        assert least_s <= seconds <= most_s


@KINDS
def test_handouts_of_the_previous_program_have_no_boot(app: Flask) -> None:
    browser = Browser(app)
    item = browser.take("describe")["item"]
    with transaction(engine_of(app)) as session:
        handout = session.scalars(select(Handout)).one()
        handout.boot = handout.since_boot_s = None
        handout.at -= 100
    browser.answer(item, described())
    seconds = row_in(app, select(Answer)).seconds
    assert seconds is not None
    assert 100 <= seconds < 160


@pytest.mark.parametrize("study", [study_of(describe=TaskConfig(lease_minutes=10, practice=False))])
def test_leases_made_while_the_clock_was_ahead_dont_block(
    app: Flask, set_clock: Callable[[float], None]
) -> None:
    set_clock(DAY_S)
    slots = len(rows_in(app, select(Slot)))
    for _ in range(slots):
        Browser(app).take("describe")
    assert Browser(app).lease("describe").status_code == 409
    set_clock(0)
    Browser(app).take("describe")


@JUMPS
def test_limits_go_on_counting_by_what_has_passed(
    jump_s: float, set_clock: Callable[[float], None]
) -> None:
    counter, limit = MovingWindowRateLimiter(ProcessStorage()), parse("2/second")
    assert [counter.hit(limit, "ann") for _ in range(3)] == [True, True, False]
    set_clock(jump_s)
    assert not counter.hit(limit, "ann")
    assert 0 < counter.get_window_stats(limit, "ann").reset_time - time.time() <= 1
    time.sleep(1.05)
    assert counter.hit(limit, "ann")


def test_durations_that_are_unknown_are_told_as_such(app: Flask) -> None:
    browser = Browser(app)
    for _ in range(2):
        browser.do("describe", described())
    with transaction(engine_of(app)) as session:
        first, second = session.scalars(select(Answer).order_by(Answer.id))
        first.seconds, second.seconds = None, 12.5
    study_id = row_in(app, select(Study.id))
    with reading(engine_of(app)) as session:
        (duration,) = durations(session, study_id)
        assert (duration.answers, duration.median_s) == (1, 12.5)
        (worker,) = workers(session, study_id)
        assert (worker.answers, worker.median_s) == (2, {"describe": 12.5})
    table = list(csv.DictReader(io.StringIO(exported(app, "csv").decode())))
    assert [row["seconds"] for row in table] == ["", "12.5"]
    assert b'"seconds":null' in exported(app, "jsonl")
    parquet = pytest.importorskip("pyarrow.parquet")
    read = parquet.read_table(io.BytesIO(exported(app, "parquet")))
    assert read["seconds"].to_pylist() == [None, 12.5]
