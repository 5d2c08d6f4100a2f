"""Answers about videos: the server believes only watching for which there was time."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import msgspec
import pytest
from flask import Flask
from sqlalchemy import select, update

from annotation_app.dashboard.workers import workers
from annotation_app.items.new_items import NewItem, add_item
from annotation_app.store.database import reading, transaction
from annotation_app.store.models import Answer, Handout, Media
from annotation_app.studies.study_file import StudyConfig
from annotation_app.work.answer_flags import UNWATCHED
from annotation_app.work.handing_out import find_study
from g3.sdc.sdc_notation import parse_brackets, to_json
from tests.annotation_app.browser import (
    COMMAND,
    Browser,
    described,
    engine_of,
    execute,
    exported,
    row_in,
    rows_in,
)
from tests.annotation_app.conftest import NO_PRACTICE, study_of
from tests.annotation_app.rendered import VIDEOS

DURATION_S = 10.0
"""Longer than the films of other tests."""
SDCS = to_json(
    parse_brackets("EVENT(r = Pick up, l = OBJ(f = the tires))", command=COMMAND),
)


@pytest.fixture(autouse=True)
def long_films(app: Flask, tmp_path: Path) -> None:
    """Give the study longer films."""
    for media in rows_in(app, select(Media).where(Media.role == "manifest")):
        folder = shutil.copytree(Path(media.path).parent, tmp_path / media.video)
        file = folder / "manifest.json"
        file.write_text(json.dumps({**json.loads(file.read_text()), "duration_s": DURATION_S}))
        execute(app, update(Media).where(Media.id == media.id).values(path=str(file)))


@pytest.fixture
def study() -> StudyConfig:
    names = ("describe", "subtasks", "moments", "mark", "correct", "check", "rate")
    tasks = dict.fromkeys(names, NO_PRACTICE)
    return msgspec.structs.replace(study_of(**tasks), watching="required")


def add(app: Flask, study: StudyConfig, task: str, **about: object) -> None:
    with transaction(engine_of(app)) as session:
        payload = {"text": COMMAND, "command": 1, "video": VIDEOS[0], "sdcs": SDCS, **about}
        add_item(session, find_study(session, "tests"), study, NewItem(task, "test", payload))


def hand_out_earlier(app: Flask, by_s: float) -> None:
    since = Handout.since_boot_s - by_s
    execute(app, update(Handout).values(at=Handout.at - by_s, since_boot_s=since))


def told(person: Browser, item: str, body: object) -> str:
    reply = person.answer(item, body)
    assert reply.status_code == 422, reply.text
    (problem,) = reply.json["problems"]
    return str(problem["message"])


BODIES = {
    "describe": described(),
    "subtasks": {"subtasks": [{"start_s": 0, "text": "Wait"}], "played_to_end": True},
    "moments": {"moments": [{"style": "interjection", "time_s": 0.2, "text": "Go on"}]},
    "rate": {"rating": 3},
    "mark": {"success": "success", "quality": 5},
    "correct": {"verdict": "right"},
}


@pytest.mark.parametrize("task", BODIES)
def test_watching_must_be_credible(app: Flask, study: StudyConfig, task: str) -> None:
    if task in ("rate", "correct"):
        add(app, study, task, own_video=VIDEOS[0], right=None)
    person, body = Browser(app), BODIES[task]
    item = person.take(task)["item"]
    assert told(person, item, body) == "Watch the video to its end first."
    half = {"watched_s": DURATION_S / 2}
    assert told(person, item, {**body, **half}) == "Watch the video to its end first."
    whole = {"watched_s": DURATION_S}
    assert told(person, item, {**body, **whole}).startswith("This is sooner than")
    assert told(person, item, {**body, **whole, "speed": 4}).startswith("This is sooner than")
    hand_out_earlier(app, DURATION_S / 4)
    assert told(person, item, {**body, **whole}).startswith("This is sooner than")
    assert person.answer(item, {**body, **whole, "speed": 4}).json["state"] == "accepted"
    assert row_in(app, select(Answer)).body["watched_s"] == DURATION_S


def test_things_in_pictures_need_no_watching(app: Flask, study: StudyConfig) -> None:
    thing = {"video": VIDEOS[1], "objects": ["truck"], "places": []}
    add(app, study, "check", shown={"2": thing})
    person = Browser(app)
    page = person.take("check")
    assert person.answer(page["item"], {"verdicts": {"2": False}}).json["state"] == "accepted"


def test_what_happens_is_watched_in_each_video(app: Flask, study: StudyConfig) -> None:
    films = {str(n): {"video": VIDEOS[n + 1], "objects": [], "places": []} for n in (0, 1)}
    add(app, study, "check", shown=films)
    person = Browser(app)
    page = person.take("check")
    hand_out_earlier(app, 60.0)
    verdicts = {"verdicts": {"0": True, "1": False}}
    assert told(person, page["item"], {**verdicts, "watched_s": DURATION_S}).startswith("Watch")
    whole = {**verdicts, "watched_s": 2 * DURATION_S}
    assert person.answer(page["item"], whole).json["state"] == "accepted"


def test_a_study_may_keep_unwatched_answers_with_a_flag(app: Flask, study: StudyConfig) -> None:
    lenient = msgspec.structs.replace(study, watching="flagged")
    with transaction(engine_of(app)) as session:
        find_study(session, "tests").config = msgspec.to_builtins(lenient)
    person = Browser(app)
    for _ in range(2):
        person.do("describe", described())
    assert all(answer.body["unwatched"] for answer in rows_in(app, select(Answer)))
    assert exported(app, "csv").decode().count(UNWATCHED) == 2
    with reading(engine_of(app)) as session:
        (worker,) = workers(session, find_study(session, "tests").id)
    assert worker.reasons == (f"{UNWATCHED}: 2 times",)
