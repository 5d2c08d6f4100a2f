"""Rules by which an answer is adopted: by agreement of all, of a share, or by an adjudicator."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from flask import Flask
from sqlalchemy import func, select

from annotation_app.store.database import reading
from annotation_app.store.models import Answer, Item
from annotation_app.studies.study_file import StudyConfig
from annotation_app.work.handing_out import find_study
from g3.sdc.sdc_notation import parse_brackets, to_json
from tests.annotation_app.browser import COMMAND, Browser, described, engine_of, rows_in
from tests.annotation_app.conftest import NO_PRACTICE, study_of
from tests.annotation_app.signing_in import signed_in
from tests.annotation_app.study_setup.clips import clip
from tests.annotation_app.study_setup.test_own_videos import set_up

SPLIT = "EVENT(r = Pick up, l = OBJ(f = OBJ(f = the tires), r = by, l = OBJ(f = the truck)))"
WHOLE = "EVENT(r = Pick up, l = OBJ(f = the tires by the truck))"
TREES = [to_json(parse_brackets(text, command=COMMAND)) for text in (SPLIT, WHOLE)]


def segmented(app: Flask, study: str, *trees: int) -> None:
    """One person describes a video, and as many as there are trees segment it."""
    people = [Browser(app, study=study) for _ in trees]
    page = people[0].lease("describe", study).json
    assert people[0].answer(page["item"], described()).status_code == 200
    for person, tree in zip(people, trees, strict=True):
        page = person.lease("segment", study).json
        assert person.answer(page["item"], {"sdcs": TREES[tree]}).status_code == 200


def adopted(app: Flask) -> list[int]:
    """The trees that are adopted."""
    found = rows_in(app, select(Answer.body).where(Answer.task == "segment", Answer.adopted))
    return [TREES.index(body["sdcs"]) for body in found]


@pytest.fixture
def study(rule: str | float, answers: int) -> StudyConfig:
    segment = {"answers": answers, "adoption": rule, "practice": False}
    of_segment = type(NO_PRACTICE)(**segment)
    return study_of(describe=NO_PRACTICE, segment=of_segment, ground=NO_PRACTICE)


@pytest.mark.parametrize(
    ("rule", "answers", "trees", "chosen"),
    [
        ("all", 3, (0, 0, 0), [0]),
        ("all", 3, (0, 1, 0), []),
        ("majority", 3, (1, 0, 0), [0]),
        ("majority", 2, (1, 0), []),
        (0.75, 3, (1, 0, 0), []),
        (0.66, 3, (0, 1, 1), [1]),
        ("adjudicator", 2, (0, 0), []),
        ("adjudicator", 1, (0,), []),
        ("all", 1, (1,), [1]),
    ],
)
def test_the_studys_rule_adopts(app: Flask, trees: tuple[int, ...], chosen: list[int]) -> None:
    segmented(app, "tests", *trees)
    assert adopted(app) == chosen
    ground = rows_in(app, select(Item.id).where(Item.task == "ground"))
    assert len(ground) == len(chosen)
    judge = signed_in(app, "judy", "adjudicator")
    listed = judge.client.get("/api/dashboard/studies/tests/queue").json["data"]
    assert len(listed) == 1 - len(chosen)
    if listed:
        assert judge.client.get(f"/dashboard/tests/queue/{listed[0]['item']}").status_code == 200


def test_a_share_of_the_items_is_kept_for_several_people(tmp_path: Path) -> None:
    clip(tmp_path / "clips/push.mp4", 40)
    texts = [f"Push cup {number}." for number in range(30)]
    (tmp_path / "given.csv").write_text("\n".join(["video,command", *(f"push,{t}" for t in texts)]))
    segment = {"practice": False, "answers": 2, "overlap": 0.3}
    study = {"name": "arm", "title": "An arm", "videos": "clips", "commands": "given.csv"}
    file = tmp_path / "arm.yaml"

    def taken(app: Flask) -> set[str]:
        """The commands that somebody gets."""
        person, found = Browser(app, study="arm"), set()
        while (leased := person.lease("segment", "arm")).status_code == 200:
            text = leased.json["payload"]["command"]
            tree = to_json(parse_brackets("EVENT(r = Push, l = OBJ(f = cup))", command=text))
            assert person.answer(leased.json["item"], {"sdcs": tree}).status_code == 200
            found.add(text)
        return found

    file.write_text(json.dumps({**study, "tasks": {"segment": segment}}))
    for _ in range(2):  # the second start adds nothing
        with set_up(file):
            pass
    with set_up(file) as app:
        assert taken(app) == set(texts)
        several = taken(app)
        assert 3 <= len(several) <= 15
        assert taken(app) == set()
        assert len(adopted_texts(app)) == len(texts)
    file.write_text(json.dumps({**study, "tasks": {"segment": {**segment, "overlap": 1}}}))
    with set_up(file) as app:
        assert taken(app) == set(texts) - several


def adopted_texts(app: Flask) -> set[str]:
    answered = select(Item.payload).join(Answer, Answer.item_id == Item.id)
    found = rows_in(app, answered.where(Answer.task == "segment", Answer.adopted))
    return {payload["text"] for payload in found}


def test_a_new_rule_decides_about_what_is_there(tmp_path: Path) -> None:
    clip(tmp_path / "clips/push.mp4", 40)
    segment = {"practice": False, "answers": 3}
    study = {
        "name": "arm",
        "title": "An arm",
        "videos": "clips",
        "watching": "flagged",
        "tasks": {"describe": {"practice": False}, "segment": segment},
    }
    file = tmp_path / "arm.yaml"
    file.write_text(json.dumps(study))
    with set_up(file) as app:
        segmented(app, "arm", 0, 1, 0)
        assert adopted(app) == []
    file.write_text(
        json.dumps(
            {**study, "tasks": {**study["tasks"], "segment": {**segment, "adoption": "majority"}}}
        )
    )
    with set_up(file) as app:
        assert adopted(app) == [0]
        with reading(engine_of(app)) as session:
            study_id = find_study(session, "arm").id
            count = session.scalar(select(func.count()).where(Answer.study_id == study_id))
        assert count == 4
