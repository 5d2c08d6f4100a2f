"""What a model proposes for things and places, and what answers tell of it.

Who sees a suggestion, and who doesn't, is tested in `test_offers`.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest
from flask import Flask

from annotation_app.serving.factory import create_app
from annotation_app.store.models import Record
from annotation_app.studies.study_file import StudyConfig, TaskConfig
from annotation_app.work.answer_flags import UNREAD
from g3.sdc.sdc_notation import parse_brackets, to_json
from tests.annotation_app.browser import COMMAND, Browser, engine_of, installation_of
from tests.annotation_app.conftest import study_of
from tests.annotation_app.work import suggesting
from tests.annotation_app.work.suggesting import of, rows

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
    return study_of(ground=TaskConfig(answers=3, practice=False))


put = partial(suggesting.put, sdcs=SDCS)


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


def test_without_a_model_nothing_is_suggested(app: Flask, study: StudyConfig) -> None:
    put(app, study, "on")
    person = Browser(app)
    page = person.take("ground")
    assert page["payload"]["suggestion"] is None
    cant = {node: {"cant_tell": True} for node in (TIRES, PLACE, TRUCK)}
    person.answer(page["item"], sent(cant))
    assert [of(row) for row in rows(app)] == [("none", None, None)]


@pytest.mark.slow
def test_a_trained_model_suggests_things_of_the_map(
    app: Flask, study: StudyConfig, trained: Callable[[str], Path]
) -> None:
    put(app, study, "on")
    config = replace(installation_of(app).config, model=trained("one-scenario"))
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
