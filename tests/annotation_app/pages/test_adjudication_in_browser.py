"""Deciding between answers in a real browser: the worker's own editor, and the worker's map."""

from __future__ import annotations

import itertools
import re
from typing import Any

import pytest
from playwright.sync_api import BrowserContext, Page, expect
from sqlalchemy import select

from annotation_app.store.models import Answer, Remark
from g3.sdc.sdc_notation import parse_brackets, to_json
from tests.annotation_app.browser import Browser, row_in, rows_in
from tests.annotation_app.in_browser import drawn_anew, errors_of, sign_in
from tests.annotation_app.pages.conftest import COMMAND, NOTATION, Site

pytestmark = pytest.mark.slow

FLAT = "EVENT(r = Go, l = PATH(f = to the red crate))"


def answered(site: Site, task: str, *bodies: Any) -> str:
    """Several people answer the task's item; its id. A body may be made of the page's data."""
    item = ""
    for body in bodies:
        person = Browser(site.app, study="sea")
        page = person.lease(task, "sea").json
        item = page["item"]
        sent = body(page["payload"]) if callable(body) else body
        assert person.answer(item, sent).status_code == 200
    return item


def trees(*notations: str) -> list[Any]:
    return [{"sdcs": to_json(parse_brackets(text, command=COMMAND))} for text in notations]


def named(number: int) -> Any:
    """Grounds the crate to a thing, by its place in the page's list."""

    def body(payload: Any) -> Any:
        node = next(str(c["node"]) for c in payload["clauses"] if c["type"] == "OBJECT")
        thing = payload["segmentation"]["objects"][number]["id"]
        trims = {"0": [0.0, 0.5]} if number else {}
        return {
            "groundings": {node: {"objects": [thing]}},
            "trims": trims,
            "whole": ["2"],
            "watched_s": 1.0,
        }

    return body


def judge_page(site: Site, context: BrowserContext, path: str) -> tuple[Browser, Page, list[str]]:
    judge = Browser(site.app, "adjudicator", study="sea")
    sign_in(context, judge, site.url)
    page = context.new_page()
    errors = errors_of(page)
    page.goto(f"{site.url}/dashboard/sea/queue/{path}")
    return judge, page, errors


def last_answer(site: Site, judge: Browser) -> Answer:
    return row_in(
        site.engine, select(Answer).where(Answer.person_id == judge.person.id, Answer.adopted)
    )


def test_a_tree_is_edited_as_workers_do(site: Site, context: BrowserContext) -> None:
    item = answered(site, "segment", *trees(NOTATION, FLAT))
    judge, page, errors = judge_page(site, context, item)
    page.get_by_role("link", name="Edit answer 1").click()
    expect(page.get_by_role("heading", name="Segment")).to_be_visible()
    adopt = page.get_by_role("button", name="Adopt this answer")
    expect(adopt).to_be_enabled()
    expect(page.get_by_text("start from nothing")).to_be_hidden()  # no program has suggested it
    page.keyboard.press("]")  # to the second clause, "to"
    page.keyboard.press("Delete")
    expect(page.locator("#undo")).to_be_enabled()
    page.reload()  # what was begun is kept in this browser
    expect(page.locator("#saving")).to_have_text("Your draft is back")
    page.get_by_role("link", name="Back to the answers").click()
    page.get_by_role("link", name="Edit answer 2").click()  # another answer has its own draft
    expect(page).to_have_url(re.compile(r"answer=\d+$"))
    expect(adopt).to_be_enabled()
    expect(page.locator("#saving")).to_be_empty()
    page.go_back()
    page.get_by_role("link", name="Edit answer 1").click()
    expect(page.locator("#saving")).to_have_text("Your draft is back")
    page.get_by_label("Comment, for those who run the study").fill("no path <b>")
    adopt.click()
    page.wait_for_url("**/dashboard/sea/queue")
    answer = last_answer(site, judge)
    assert '"PATH"' in str(trees(NOTATION)[0]).replace("'", '"')
    assert "PATH" not in str(answer.body["sdcs"])
    assert [r.text for r in rows_in(site.engine, select(Remark))] == ["no path <b>"]
    assert errors == []


def test_an_answer_is_adopted_as_it_is_in_the_editor(site: Site, context: BrowserContext) -> None:
    item = answered(site, "segment", *trees(FLAT, NOTATION))
    judge, page, errors = judge_page(site, context, item)
    page.get_by_role("link", name="Edit answer 2").click()
    page.get_by_role("button", name="Adopt this answer").click()
    page.wait_for_url("**/dashboard/sea/queue")
    assert [last_answer(site, judge).body] == trees(NOTATION)
    assert errors == []


def test_a_grounding_is_edited_as_workers_do(site: Site, context: BrowserContext) -> None:
    item = answered(site, "ground", named(0), named(1))
    judge, page, errors = judge_page(site, context, item)
    page.get_by_role("link", name="Edit answer 2").click()
    expect(page.get_by_role("heading", name="Ground")).to_be_visible()
    expect(page.locator(".map .thing")).to_have_count(4)
    for _ in range(4):  # wherever the page begins, the clause of the thing is among them
        if page.locator(".map .thing.chosen").count():
            break
        page.keyboard.press("]")
    expect(page.locator(".map .thing.chosen")).to_have_count(1)
    page.get_by_role("button", name="Adopt this answer").click()  # unchanged: nothing is missing
    page.wait_for_url("**/dashboard/sea/queue")
    answers = rows_in(site.engine, select(Answer).where(Answer.item_id == item).order_by(Answer.id))
    mine = last_answer(site, judge)
    second = answers[1]
    things = [[g["objects"] for g in one.body["groundings"].values()] for one in (mine, second)]
    assert things[0] == things[1]
    assert mine.body["trims"] == second.body["trims"] == {"0": [0.0, 0.5]}
    assert mine.body["whole"] == second.body["whole"]
    assert mine.id != second.id
    assert errors == []


CENTRE = "box => [box.x + box.width / 2, box.y + box.height / 2]"
OF_COMPARED = f"""() => Object.fromEntries(
  [...document.querySelectorAll("svg.map [data-label]")].map(
    thing => [thing.dataset.label, ({CENTRE})(thing.getBoundingClientRect())]))"""
CAPS = """() => [...document.querySelectorAll(".views .cap:not(.left-out) rect")].map(rect => {
  const { left, top, right, bottom } = rect.getBoundingClientRect();
  return [rect.parentNode.textContent, left, top, right, bottom];
})"""
OF_WORKERS = f"""() => Object.fromEntries(
  [...document.querySelectorAll("svg.map .thing")].map(thing => [
    thing.dataset.id, ({CENTRE})(thing.querySelector("polygon.shape").getBoundingClientRect())]))"""


def test_the_map_lies_as_the_workers(site: Site, context: BrowserContext) -> None:
    item = answered(site, "ground", named(0), named(1))
    _, page, errors = judge_page(site, context, item)
    expect(page.locator("svg.map .cap text").first).not_to_be_empty()
    compared = page.evaluate(OF_COMPARED)
    page.get_by_role("link", name="Edit answer 1").click()
    expect(page.locator(".map .thing")).to_have_count(4)
    worker = page.evaluate(OF_WORKERS)
    one, other = compared

    def direction(places: dict[str, list[float]]) -> tuple[float, float]:
        x, y = (places[other][i] - places[one][i] for i in (0, 1))
        length = (x * x + y * y) ** 0.5
        return x / length, y / length

    assert direction(compared) == pytest.approx(direction(worker), abs=0.06)
    assert errors == []


def test_labels_do_not_cover_each_other(site: Site, context: BrowserContext) -> None:
    item = answered(site, "ground", named(0), named(1))
    _, page, errors = judge_page(site, context, item)
    expect(page.locator("svg.map .cap")).to_have_count(2)
    for width in (1280, 390):
        page.set_viewport_size({"width": width, "height": 800})
        drawn_anew(page)
        caps = page.evaluate(CAPS)
        assert len(caps) == 4  # two in the picture, two on the map
        texts = set(page.locator("dd b[data-shown]").all_inner_texts())
        assert all(re.fullmatch(r"\d+", text) for text in texts), texts
        assert {text for text, *_ in caps} == texts
        for one, other in itertools.combinations(caps, 2):
            (_, left, top, right, bottom), (_, x, y, far, low) = one, other
            assert right <= x or far <= left or bottom <= y or low <= top, (one, other)
    assert errors == []


def test_drawings_of_three_answers_are_seen_whole(site: Site, context: BrowserContext) -> None:
    item = answered(site, "segment", *trees(NOTATION, FLAT))
    _, page, errors = judge_page(site, context, item)
    page.get_by_role("button", name="Ask one more person").click()
    page.wait_for_url("**/dashboard/sea/queue")
    assert answered(site, "segment", *trees("EVENT(r = Go to, l = OBJ(f = the red crate))")) == item
    page.set_viewport_size({"width": 1280, "height": 800})
    page.goto(f"{site.url}/dashboard/sea/queue/{item}")
    drawings, sides = page.locator(".drawing"), page.locator(".sides > section")
    expect(drawings).to_have_count(3)
    for width, rows in ((None, 1), (500, 2), (1000, 3)):
        if width is not None:  # as drawings of longer commands are
            drawings.locator("svg").evaluate_all(
                "(all, width) => all.forEach(svg => svg.setAttribute('width', width))", width
            )
        hidden = drawings.evaluate_all("all => all.map(d => d.scrollWidth - d.clientWidth)")
        assert hidden == [0, 0, 0], width
        tops = sides.evaluate_all("all => all.map(s => s.getBoundingClientRect().top)")
        assert len(set(tops)) == rows, width
    assert errors == []
