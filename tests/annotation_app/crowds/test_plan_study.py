"""Studies of plans from ``ct eval --end-to-end``: offered at platforms, and read while they run."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import pytest

from annotation_app.core.config import open_instance
from annotation_app.serving.factory import create_app
from annotation_app.study_setup.study_reading import read_study
from annotation_app.tasks.rate import RATE
from eval.plan_study.study_plans import INSTANCE, Pair, write_study
from eval.plan_study.whole_study import offer, received
from g3.errors import FormatError
from tests.annotation_app.browser import Browser, engine_of
from tests.annotation_app.crowds.crowd_worker import LAB
from tests.annotation_app.crowds.stand_ins import MechanicalTurk
from tests.annotation_app.rendered import VIDEOS, render

PAIRS = [Pair("Go there.", video, VIDEOS[2], "gold", video) for video in VIDEOS]


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """A study whose file somebody has changed."""
    render(tmp_path / "videos")
    file = write_study(tmp_path, PAIRS[:1], seed=0)
    file.write_text(file.read_text().replace("practice: true", "practice: false"))
    return write_study(tmp_path, PAIRS, seed=0)


def test_what_somebody_has_changed_stays(file: Path) -> None:
    study = read_study(write_study(file.parent, PAIRS, seed=0, pay=0.05))
    assert study.tasks["rate"].practice is False
    assert study.payment is not None
    assert study.payment.amount == 0.05
    assert [pair.video for pair in study.pairs] == list(VIDEOS)


def test_work_is_offered_once(file: Path, mturk: MechanicalTurk) -> None:
    address: str = mturk.address  # type: ignore[attr-defined]
    offered = partial(offer, file, "mturk", LAB, 20, sandbox=True, endpoint=address)
    with pytest.raises(FormatError, match="what is paid"):
        offered()
    assert not mturk.hits
    write_study(file.parent, PAIRS, seed=0, pay=0.05)
    # Three pairs with five judgments each, and nobody rates one twice.
    assert offered()[0] == "5 assignments added, 5 in all"
    assert offered()[0] == "0 assignments added, 5 in all"
    (hit,) = mturk.hits.values()
    assert (hit["Reward"], hit["Description"]) == ("0.15", RATE.words.offer)
    with pytest.raises(FormatError, match="no platform"):
        offer(file, "elsewhere", LAB, 20)


def test_ratings_are_read_while_they_come_in(file: Path) -> None:
    assert received(file.parent) == ()
    (link,) = offer(file, "links", LAB, 20)
    assert link.startswith(f"{LAB}/crowd/links/")
    assert list(received(file.parent)) == []
    app = create_app(open_instance(file.parent / INSTANCE))
    rater = Browser(app, study="plans")
    for number in (1, 2):
        item = rater.lease("rate", "plans").json["item"]
        assert rater.answer(item, {"rating": 5, "watched_s": 1.0}).status_code == 200
        assert [j.rating for j in received(file.parent)] == ["SA"] * number
    engine_of(app).dispose()
