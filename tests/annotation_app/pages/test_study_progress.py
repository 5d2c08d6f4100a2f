"""How far people are: of what they have done and may still do."""

from __future__ import annotations

import re

import pytest
from flask import Flask
from sqlalchemy import and_, func, or_, select, update

from annotation_app.items import assignment
from annotation_app.items.assignment import ITEM, SLOT
from annotation_app.pages.study_progress import progress
from annotation_app.store.database import reading
from annotation_app.store.models import Person, Slot
from annotation_app.studies.study_file import StudyConfig
from annotation_app.work.handing_out import find_study
from tests.annotation_app.browser import Browser, described, engine_of, execute
from tests.annotation_app.conftest import NO_PRACTICE, study_of
from tests.annotation_app.rendered import VIDEOS

pytestmark = pytest.mark.parametrize("kind", ["sqlite", "postgresql"])

_OPEN_FOR_THEM = or_(
    assignment._OPEN.where(SLOT.c.person_id == assignment._WHO),
    and_(assignment._OPEN, *assignment._is_new()),
)
EACH_ASKED = (
    select(ITEM.c.task, func.count())
    .where(ITEM.c.study_id == assignment._STUDY, ITEM.c.attention.is_(False), _OPEN_FOR_THEM)
    .group_by(ITEM.c.task)
)
"""The simpler way, without an index: each item is asked."""


@pytest.fixture
def study() -> StudyConfig:
    return study_of(describe=NO_PRACTICE, rate=NO_PRACTICE)


def rating(app: Flask, person: Browser) -> tuple[int, int]:
    """How many ratings of how many; each task as if one asked of each item who may get it."""
    with reading(engine_of(app)) as session:
        mine = session.get_one(Person, person.person.id)
        found = progress(session, find_study(session, "tests"), mine)
        asked = {"of_study": find_study(session, "tests").id, "who": mine.id}
        expected = dict(session.execute(EACH_ASKED, asked).all())
        assert {one.task: one.items - one.done for one in found} == {
            task: expected.get(task, 0) for task in ("describe", "rate")
        }
    return next((one.done, one.items) for one in found if one.task == "rate")


def test_progress_counts_what_somebody_may_do(app: Flask) -> None:
    author, rater, other = (Browser(app) for _ in range(3))
    author.do("describe", described())
    assert rating(app, author) == (0, 0)  # nobody rates their own command
    assert rating(app, rater) == (0, 2)
    rater.do("rate", {"rating": 5, "watched_s": 1.0})
    assert rating(app, rater) == (1, 2)
    assert rating(app, other) == (0, 1)
    held = rater.take("rate")["item"]
    assert (rating(app, rater), rating(app, other)) == ((1, 2), (0, 1))
    rater.note(held, "skip", "too dark")
    assert rating(app, rater) == (1, 1)
    other.do("rate", {"rating": 1, "watched_s": 1.0})
    assert rating(app, other) == (1, 1)
    assert rating(app, Browser(app)) == (0, 0)


def test_one_button_is_the_next_step(app: Flask) -> None:
    person = Browser(app)
    page = person.client.get("/s/tests").text
    (button,) = re.findall(r'class="button primary" href="([^"]+)"', page)
    assert button == "/s/tests/describe"
    for _ in VIDEOS[1:]:
        person.do("describe", described())
    Browser(app).do("describe", described())
    page = person.client.get("/s/tests").text
    assert re.findall(r'class="button primary" href="([^"]+)"', page) == ["/s/tests/rate"]
    everything = update(Slot).values(answered=True)
    execute(engine_of(app), everything)
    page = person.client.get("/s/tests").text
    assert 'class="button primary"' not in page
    assert "You have done all that there is for you here." in page
