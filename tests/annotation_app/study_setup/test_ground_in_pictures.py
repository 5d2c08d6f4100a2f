"""Ground where a picture is all that is known: there is no map, and no question about one."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import BrowserContext, expect
from sqlalchemy import Engine, select

from annotation_app.cli import served_studies
from annotation_app.core.config import open_instance
from annotation_app.serving import server
from annotation_app.serving.factory import create_app
from annotation_app.store.database import opened
from annotation_app.store.models import Answer
from g3.sdc.sdc_notation import parse_brackets, to_json
from tests.annotation_app.browser import Browser, described, row_in
from tests.annotation_app.conftest import put_tables
from tests.annotation_app.in_browser import errors_of, look, serving, sign_in
from tests.annotation_app.study_setup.clips import HEIGHT, WIDTH, clip
from tests.annotation_app.study_setup.test_coco_things import STUDY

COMMAND = "Take the box from the bench, put it on the van, and then fly back to the left side."
NOTATION = """\
EVENT(r = Take, l = OBJ(f = the box), l2 = PATH(r = from, l = OBJ(f = the bench)))
EVENT(r = put, l = OBJ(f = it), l2 = PLACE(r = on, l = OBJ(f = the van)))
EVENT(r = fly, l = PATH(r = back), l2 = PATH(r = to, l = OBJ(f = the left side)))"""


@contextmanager
def asked(
    folder: Path, coco: Any, command: str, notation: str, study: Any = STUDY
) -> Iterator[tuple[Engine, Browser, str]]:
    """A command to be grounded in a video with things: the database, somebody, an address."""
    clip(folder / "clips/push.mp4", 40)
    (folder / "things.json").write_text(json.dumps(coco))
    (folder / "arm.yaml").write_text(json.dumps(study))
    config = replace(open_instance(folder / "instance"), rate_limits=False)
    put_tables(config.database)
    server.prepare(config)
    served_studies.put_file(config, folder / "arm.yaml")
    with opened(config.database) as engine:
        app = create_app(config, engine)
        person = Browser(app, study="arm")
        page = person.lease("describe", "arm").json
        assert person.answer(page["item"], described(command)).status_code == 200
        page = person.lease("segment", "arm").json
        sdcs = to_json(parse_brackets(notation, command=command))
        assert person.answer(page["item"], {"sdcs": sdcs}).status_code == 200
        with serving(app) as url:
            yield engine, Browser(app, study="arm"), url


@pytest.mark.firefox
@pytest.mark.slow
def test_twelve_clauses_take_six_answers(context: BrowserContext, tmp_path: Path) -> None:
    boxes = ([2, 3, 20, 30], [30, 3, 20, 30])
    coco = {
        "images": [{"id": 1, "file_name": "push.png", "width": WIDTH, "height": HEIGHT}],
        "annotations": [
            {"id": 7 + i, "image_id": 1, "category_id": 1, "bbox": box}
            for i, box in enumerate(boxes)
        ],
        "categories": [{"id": 1, "name": "box"}],
    }
    with asked(tmp_path, coco, COMMAND, NOTATION) as (engine, person, address):
        sign_in(context, person, address)
        ground = context.new_page()
        errors = errors_of(ground)
        ground.goto(f"{address}/s/arm/ground")
        ground.get_by_role("button", name="Play the video").click()
        expect(ground.locator(".ask q")).to_have_text("the box")
        for key, words in (
            ("1", "the box"),
            ("2", "the bench"),
            ("2", "the van"),
            ("x", "the left side"),
        ):
            expect(ground.locator(".ask q")).to_have_text(words)
            ground.keyboard.press(key)
        for moment, words in (
            ("0.3", "put it on the van"),
            ("0.6", "fly back to the left side"),
        ):
            expect(ground.locator(".ask q")).to_have_text(words)
            ground.get_by_label("Time in the video, in seconds").fill(moment)
            expect(
                ground.get_by_text("Outlines are shown at the start of the video.")
            ).to_be_visible()
            ground.get_by_role("button", name="It begins here").click()
        expect(ground.locator("body")).not_to_contain_text("The map moves with it")
        expect(ground.locator(".follows .phrase")).to_have_text(
            ["it", "on the van", "from the bench", "back", "to the left side"]
        )
        expect(ground.locator(".follows .said").nth(1)).to_have_text("2")
        assert look(ground, "ground-follows") == []
        with ground.expect_navigation():
            ground.keyboard.press("y")
        assert errors == []
        answer = row_in(engine, select(Answer).where(Answer.task == "ground"))
    assert len(answer.body["groundings"]) == 6
    assert len(answer.body["trims"]) == 6


@pytest.mark.firefox
@pytest.mark.slow
def test_outlines_go_along_with_things_that_were_followed(
    context: BrowserContext, tmp_path: Path
) -> None:
    marked = ((1, 0.0, [2, 3, 10, 20]), (1, 0.8, [42, 3, 10, 20]), (2, 0.4, [2, 30, 8, 8]))
    about = {"width": WIDTH, "height": HEIGHT, "video": "push"}
    coco = {
        "images": [
            {"id": f"at-{t}", "file_name": f"{t}.png", "time_s": t, **about}
            for t in (0.0, 0.4, 0.8)
        ],
        "annotations": [
            {"id": n, "image_id": f"at-{t}", "category_id": 1, "bbox": box, "track_id": track}
            for n, (track, t, box) in enumerate(marked)
        ],
        "categories": [{"id": 1, "name": "box"}],
    }
    command, notation = "Take the box", "EVENT(r = Take, l = OBJ(f = the box))"
    with asked(tmp_path, coco, command, notation) as (engine, person, address):
        sign_in(context, person, address)
        ground = context.new_page()
        errors = errors_of(ground)
        ground.goto(f"{address}/s/arm/ground")
        seen = ground.locator(".outlines .thing:not(.away)")
        expect(seen).to_have_count(1)
        expect(ground.get_by_text("Later in the video: 1")).to_be_visible()
        ground.get_by_role("button", name="Play the video").click()
        expect(ground.locator(".ask q")).to_have_text("the box")
        ground.get_by_label("Time in the video, in seconds").fill("0.4")
        expect(seen).to_have_count(2)
        moved = ground.locator(".outlines .thing .shape").first.evaluate("path => path.getBBox().x")
        assert {round(moved), 2} == {22, 2}
        assert look(ground, "ground-moments") == []
        seen.last.locator(".hit").click(force=True)
        with ground.expect_navigation():
            ground.get_by_role("button", name="Send", exact=True).click()
        assert errors == []
        answer = row_in(engine, select(Answer).where(Answer.task == "ground"))
    (grounding,) = answer.body["groundings"].values()
    assert grounding["objects"] in (["1"], ["2"])
