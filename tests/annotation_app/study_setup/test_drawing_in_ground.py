"""People draw things in Ground where nobody has marked them."""

from __future__ import annotations

import copy
import csv
import io
import re
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import BrowserContext, Page, expect
from sqlalchemy import select

from annotation_app.store.models import Answer
from tests.annotation_app.browser import Browser, rows_in
from tests.annotation_app.in_browser import errors_of, look, sign_in
from tests.annotation_app.signing_in import signed_in
from tests.annotation_app.study_setup.test_coco_things import STUDY
from tests.annotation_app.study_setup.test_ground_in_pictures import asked

COMMAND, NOTATION = "Take the box", "EVENT(r = Take, l = OBJ(f = the box))"
DRAWN: dict[str, Any] = copy.deepcopy(STUDY)
del DRAWN["things"]
DRAWN["tasks"]["ground"] |= {"drawing": True, "answers": 2}
del DRAWN["tasks"]["check"]


def corners(x: float, y: float, w: float, h: float) -> list[list[float]]:
    return [[x, y], [x + w, y], [x + w, y + h], [x, y + h]]


class Person(Browser):
    def take(self, task: str) -> dict[str, Any]:
        response = self.lease(task, "arm")
        assert response.status_code == 200, response.text
        return response.json

    def draw(self, *box: float) -> Any:
        """Draw a box, and say that it is what is asked about."""
        page = self.take("ground")
        node = next(str(c["node"]) for c in page["payload"]["clauses"] if c["type"] == "OBJECT")
        drawn = {"id": "drawn-1", "polygons": [corners(*box)], "time_s": 0.0}
        body = {"groundings": {node: {"objects": ["drawn-1"]}}, "drawn": [drawn]}
        return self.answer(page["item"], body)


def objects(answer: Answer) -> list[str]:
    (grounding,) = answer.body["groundings"].values()
    found: list[str] = grounding["objects"]
    return found


def test_who_draws_around_the_same_thing_agrees(tmp_path: Path) -> None:
    with asked(tmp_path, None, COMMAND, NOTATION, DRAWN) as (engine, person, _):
        app = person.client.application
        assert Person(app, study="arm").draw(10, 10, 20, 20).status_code == 200
        assert Person(app, study="arm").draw(11, 9, 20, 22).status_code == 200
        first, second = rows_in(engine, select(Answer).where(Answer.task == "ground"))
        judge = signed_in(app, "ada", "admin")
        table = judge.client.get("/dashboard/arm/export/groundings.csv")
    assert objects(first) == objects(second)
    assert first.body["drawn"][0]["box"] == [10, 10, 20, 20]
    assert second.body["drawn"][0]["box"] == [11, 9, 20, 22]
    assert first.adopted or second.adopted
    rows = list(csv.DictReader(io.StringIO(table.text)))
    (row,) = (row for row in rows if row["things"])
    assert row["labels"] == "drawn thing"
    assert row["boxes"] in ("[[10.0,10.0,20.0,20.0]]", "[[11.0,9.0,20.0,22.0]]")


@pytest.mark.firefox
def test_an_adjudicator_sees_what_was_drawn(tmp_path: Path, context: BrowserContext) -> None:
    with asked(tmp_path, None, COMMAND, NOTATION, DRAWN) as (engine, person, url):
        app = person.client.application
        assert Person(app, study="arm").draw(10, 10, 20, 20).status_code == 200
        assert Person(app, study="arm").draw(40, 10, 20, 20).status_code == 200
        sign_in(context, signed_in(app, "ada", "admin"), url)
        page = context.new_page()
        errors = errors_of(page)
        page.goto(f"{url}/dashboard/arm/queue")
        page.get_by_role("link", name=COMMAND).click()
        expect(page.get_by_text("drawn thing 1")).to_be_visible()
        expect(page.get_by_text("drawn thing 2")).to_be_visible()
        page.get_by_role("button", name="Choose answer 1").click()
        expect(page.get_by_text("There is nothing to decide.")).to_be_visible()
        assert errors == []
        adopted = [a for a in rows_in(engine, select(Answer)) if a.task == "ground" and a.adopted]
    assert [one.body["drawn"][0]["box"] for one in adopted] == [[10, 10, 20, 20]]


@pytest.mark.parametrize(
    ("box", "told"), [((10, 10, 0, 20), "isn't in the picture"), ((-9, 1, 20, 20), "isn't in the")]
)
def test_what_is_not_in_the_picture_is_refused(
    tmp_path: Path, box: tuple[float, ...], told: str
) -> None:
    with asked(tmp_path, None, COMMAND, NOTATION, DRAWN) as (_, person, _):
        reply = Person(person.client.application, study="arm").draw(*box)
    assert reply.status_code == 422
    assert told in reply.text


def watched(page: Page, address: str) -> None:
    page.goto(f"{address}/s/arm/ground")
    page.get_by_role("button", name="Play the video").click()
    expect(page.locator(".ask q")).to_have_text("the box")


@pytest.mark.firefox
@pytest.mark.slow
@pytest.mark.parametrize("way", ["mouse", "keys"])
def test_a_box_is_drawn_while_grounding(context: BrowserContext, tmp_path: Path, way: str) -> None:
    with asked(tmp_path, None, COMMAND, NOTATION, DRAWN) as (engine, person, url):
        sign_in(context, person, url)
        page = context.new_page()
        errors = errors_of(page)
        watched(page, url)
        if way == "mouse":
            page.get_by_role("button", name="Draw it").click()
            # The picture may be narrower than the frame around it.
            scale, left, top = page.locator(".surface svg").evaluate(
                "svg => { const m = svg.getScreenCTM(); return [m.a, m.e, m.f]; }"
            )
            page.mouse.move(left + 16 * scale, top + 12 * scale)
            page.mouse.down()
            page.mouse.move(left + 32 * scale, top + 36 * scale, steps=3)
            page.mouse.up()
        else:
            page.keyboard.press("d")
            for key in ("ArrowLeft", "Shift+ArrowDown", "Enter"):
                page.keyboard.press(key)
        expect(page.locator(".clause-bar .said").first).to_have_text("1")
        shown = page.locator(".surface .drawn")
        expect(shown).to_have_attribute("aria-label", re.compile("^1 Box: "))
        assert look(page, f"ground-drawn-{way}") == []
        with page.expect_navigation():
            page.keyboard.press("Control+Enter")
        assert errors == []
        (answer,) = rows_in(engine, select(Answer).where(Answer.task == "ground"))
    (drawn,) = answer.body["drawn"]
    assert objects(answer) == [drawn["id"]]
    if way == "mouse":
        assert drawn["box"] == pytest.approx([16, 12, 16, 24], abs=0.5)
