"""What a model proposes for things and places, who sees it, and what answers tell of it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import pytest
from flask import Flask

from annotation_app.items.new_items import NewItem, add_item
from annotation_app.serving.factory import create_app
from annotation_app.store.database import transaction
from annotation_app.store.models import Record
from annotation_app.studies.study_file import StudyConfig, Suggestions, TaskConfig, stored
from annotation_app.work.answer_flags import UNREAD
from annotation_app.work.handing_out import find_study
from corpus_tools.importers.authored.bundled import open_corpus
from g3.inference.training.search_training import TOLERANCE, search_sets, training_data
from g3.learning.grounding_model import GroundingModel
from g3.sdc.sdc_notation import parse_brackets, to_json
from tests.annotation_app.browser import COMMAND, Browser, engine_of, exported, installation_of
from tests.annotation_app.rendered import VIDEOS

NOTATION = "EVENT(r = Pick up, l = OBJ(f = the tires), l2 = PLACE(r = by, l = OBJ(f = the truck)))"
SDCS = to_json(parse_brackets(NOTATION, command=COMMAND))
TIRES, PLACE, TRUCK = "2", "3", "4"
"""Nodes, breadth first."""


def one(objects: list[str], places: list[Record]) -> Record:
    return {"objects": objects, "places": places, "cant_tell": False, "time_s": 0.0}


SUGGESTED = {
    "groundings": {
        TIRES: one(["tires-1"], []),
        PLACE: one([], [{"place": 1}]),
        TRUCK: one(["truck"], []),
    }
}


@pytest.fixture
def study() -> StudyConfig:
    return StudyConfig(
        name="tests", title="A study", tasks={"ground": TaskConfig(answers=3, practice=False)}
    )


def put(app: Flask, study: StudyConfig, wanted: Suggestions, items: int = 1, **more: Any) -> None:
    config = msgspec.structs.replace(
        study, tasks={"ground": msgspec.structs.replace(study.tasks["ground"], suggestions=wanted)}
    )
    with transaction(engine_of(app)) as session:
        found = find_study(session, "tests")
        found.config = stored(config)
        for number in range(items):
            about = {
                "text": COMMAND, "command": number, "video": VIDEOS[0], "sdcs": SDCS, **more
            }  # fmt: skip
            add_item(session, found, config, NewItem("ground", f"command {number}", about))


def rows(app: Flask) -> list[Record]:
    return [json.loads(line) for line in exported(app, "jsonl").splitlines()]


def of(row: Record) -> tuple[str, bool | None, float | None]:
    return row["suggestion"], row["unchanged"], row["likeness"]


def sent(groundings: Record) -> Record:
    return {"groundings": groundings, "trims": {}, "whole": []}


def test_people_get_the_names_of_their_page_and_answers_tell_what_became_of_it(
    app: Flask, study: StudyConfig
) -> None:
    put(app, study, "on", suggestion=SUGGESTED)
    person, other = Browser(app), Browser(app)
    page = person.take("ground")
    suggestion = page["payload"]["suggestion"]
    assert "tires" not in json.dumps(suggestion)
    known = {thing["id"] for thing in page["payload"]["map"]["objects"]}
    assert set(suggestion[TIRES]["objects"]) < known
    assert suggestion.keys() == {TIRES, PLACE, TRUCK}
    assert person.answer(page["item"], sent(suggestion)).status_code == 200
    page = other.take("ground")
    changed = page["payload"]["suggestion"] | {PLACE: {"cant_tell": True}}
    assert other.answer(page["item"], sent(changed)).status_code == 200
    first, second = rows(app)
    assert (of(first), of(second)) == (("shown", True, 1.0), ("shown", False, 0.667))
    assert first["body"]["groundings"] == SUGGESTED["groundings"]
    assert UNREAD in first["flags"]
    assert UNREAD not in second["flags"]
    assert first["seconds"] >= 0


def test_a_study_can_do_without(app: Flask, study: StudyConfig) -> None:
    put(app, study, "off", suggestion=SUGGESTED)
    page = Browser(app).take("ground")
    assert page["payload"]["suggestion"] is None


def test_without_a_model_nothing_is_suggested(app: Flask, study: StudyConfig) -> None:
    put(app, study, "on")
    person = Browser(app)
    page = person.take("ground")
    assert page["payload"]["suggestion"] is None
    cant = {node: {"cant_tell": True} for node in (TIRES, PLACE, TRUCK)}
    person.answer(page["item"], sent(cant))
    assert [of(row) for row in rows(app)] == [("none", None, None)]


def test_half_of_the_items_have_theirs(app: Flask, study: StudyConfig) -> None:
    put(app, study, "half", items=30, suggestion=SUGGESTED)
    person = Browser(app)
    shown = 0
    for _ in range(30):
        page = person.take("ground")
        shown += page["payload"]["suggestion"] is not None
        cant = {node: {"cant_tell": True} for node in (TIRES, PLACE, TRUCK)}
        person.answer(page["item"], sent(cant))
    assert 7 <= shown <= 23
    assert {(row["suggestion"], row["likeness"]) for row in rows(app)} == {
        ("shown", 0.0),
        ("withheld", 0.0),
    }


@pytest.mark.slow
def test_a_trained_model_suggests_things_of_the_map(
    app: Flask, study: StudyConfig, tmp_path: Path
) -> None:
    annotations = open_corpus("warehouse").annotations
    known = [a for a in annotations if a.command.scenario == "hall_pick_up_boxes"]
    model = tmp_path / "small.npz"
    GroundingModel(tolerance=TOLERANCE).fit(training_data(known, search_sets())).save(model)
    put(app, study, "on")
    config = replace(installation_of(app).config, model=model)
    person = Browser(create_app(config, engine_of(app)))
    page = person.take("ground")
    suggestion = page["payload"]["suggestion"]
    assert {TIRES, TRUCK} <= suggestion.keys() <= {TIRES, PLACE, TRUCK}
    assert (
        person.answer(page["item"], sent(suggestion | {PLACE: {"cant_tell": True}})).status_code
        == 200
    )
    (row,) = rows(app)
    assert row["suggestion"] == "shown"
    assert row["body"]["groundings"][TRUCK]["objects"] == ["truck"]


def test_a_model_that_cannot_be_read_suggests_nothing(
    app: Flask, study: StudyConfig, tmp_path: Path
) -> None:
    broken = tmp_path / "broken.npz"
    broken.write_bytes(b"no model")
    put(app, study, "on")
    config = replace(installation_of(app).config, model=broken)
    assert (
        Browser(create_app(config, engine_of(app))).take("ground")["payload"]["suggestion"] is None
    )
