"""Deciding between answers: what differs, one of them, another one, or one more person."""

from __future__ import annotations

import json
import re
import uuid
from html import unescape
from typing import Any

import pytest
from flask import Flask
from sqlalchemy import select, update

from annotation_app.store.database import reading
from annotation_app.store.models import Answer, AuditEntry, Item, Remark, Slot, Study
from tests.annotation_app.browser import (
    COMMAND,
    Browser,
    described,
    engine_of,
    execute,
    row_in,
    rows_in,
)
from tests.annotation_app.dashboard.test_pages import (
    BASE,
    ONE,
    OTHER,
    adopted,
    dispute,
    grounding_dispute,
    post,
    sdcs,
)
from tests.annotation_app.rendered import VIDEOS


def plain(page: str) -> str:
    return re.sub(r"\s+", " ", unescape(re.sub(r"<[^>]+>", " ", page)))


def test_what_differs_in_trees_is_marked(app: Flask) -> None:
    item = dispute(app)
    page = Browser(app, "adjudicator").client.get(f"{BASE}/queue/{item}").text
    one, other = re.findall(r'<ul class="clauses">(.*?)</ul>', page, re.DOTALL)
    # Of the other tree, "by" is a PLACE of its own, and the truck is in it.
    assert re.findall(r"<mark>(\w+)</mark>", one) == ["by"]
    assert re.findall(r"<mark>(\w+)</mark>", other) == ["by"]
    assert "PLACE in answer 2" in plain(one)
    assert "second landmark of “Pick up” in answer 2" in plain(one)
    assert "OBJECT in answer 1" in plain(other)
    # What is marked in the list has a dashed border in the drawing.
    lists = [part.count('class="differs"') > 0 for part in (one, other)]
    drawings = re.findall(r"<svg xmlns.*?</svg>", page, re.DOTALL)
    assert [drawing.count("stroke-dasharray") > 0 for drawing in drawings] == lists == [True, True]


def test_what_differs_in_groundings_is_marked(app: Flask) -> None:
    judge = Browser(app, "adjudicator")
    item, nodes = grounding_dispute(app, judge)
    page = judge.client.get(f"{BASE}/queue/{item}").text
    first_frame, map_ = re.findall(r"<svg(?! class=.spans).*?</svg>", page, re.DOTALL)
    for view in (first_frame, map_):
        assert len(re.findall(r'class="thing named disputed"', view)) == 2
        assert len(set(re.findall(r'data-label="([^"]+)"', view))) == 2
    sides = page.split('<h2 id="side-')[1:]
    for side in sides:
        assert side.count("<mark>") == len(nodes)
    # The script gets the scene as the worker's page does, and nothing is called by its name there.
    scene = re.search(r'id="scene">(.*?)</script>', page, re.DOTALL)
    assert scene is not None
    shown = {thing["id"] for thing in json.loads(scene[1])["map"]["objects"]}
    assert set(re.findall(r'data-(?:shown|label)="([^"]+)"', page)) <= shown
    assert "tires-1" not in scene[1]


def test_parts_of_the_video_that_differ(app: Flask) -> None:
    judge = Browser(app, "adjudicator")
    judge.adjudicate(dispute(app), sdcs(ONE))
    for trims in ({"0": [0.2, 0.5]}, {}):
        person = Browser(app)
        page = person.take("ground")
        nodes = [c["node"] for c in page["payload"]["clauses"] if c["type"] == "OBJECT"]
        groundings = {str(n): {"cant_tell": True} for n in nodes}
        body = {"groundings": groundings, "trims": trims, **person.watched(page)}
        sent = person.answer(page["item"], body)
        assert sent.status_code == 200, sent.json
    shown = judge.client.get(f"{BASE}/queue/{page['item']}").text
    sides = shown.split('<h2 id="side-1"')[1]
    marked = re.findall(r"<mark>(.*?)</mark>", sides, re.DOTALL)
    assert [words.strip() for words in marked] == ["0.2 to 0.5 s", "the whole video"]
    # The video is one second long.
    assert "Answer 1: from 20 to 50 percent" in shown


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_a_third_answer(app: Flask) -> None:
    item = dispute(app)
    judge = Browser(app, "adjudicator")
    for wrong in ({"sdcs": []}, {"sdcs": [{"type": "EVENT", "r": [["Lift", 0]]}]}, {"x": 1}):
        assert judge.adjudicate(item, wrong).status_code == 422
    mine = sdcs("EVENT(r = Pick up, l = OBJ(f = the tires by the truck))")
    sent = {"uuid": str(uuid.uuid4()), "body": mine, "comment": "one thing, not two"}
    for _ in range(2):  # sent again, it counts once
        assert judge.send("POST", f"/api/items/{item}/adjudicate", sent).status_code == 200
    (answer,) = adopted(app, "segment")
    assert (answer.person_id, answer.body) == (judge.person.id, mine)
    (remark,) = rows_in(app, select(Remark))
    assert (remark.kind, remark.text) == ("adopted", "one thing, not two")
    notes = select(AuditEntry.actor).where(AuditEntry.action == "adopted an answer")
    assert rows_in(app, notes) == [judge.person.external_hash[:12]]
    assert row_in(app, select(Item).where(Item.task == "ground"))
    assert "one thing, not two" in judge.client.get(f"{BASE}/queue/{item}").text
    # It is neither one of the annotators' answers nor late.
    numbers = "/api/dashboard/studies/tests"
    assert judge.client.get(f"{numbers}/agreement").json["data"][0]["units"] == 1
    assert judge.client.get(f"{numbers}/corpus").json["data"]["surplus"] == 0
    # Deciding again replaces it.
    first = re.findall(
        r'name="choice" value="(\d+)"', judge.client.get(f"{BASE}/queue/{item}").text
    )
    assert post(judge, f"{BASE}/queue/{item}", choice=first[0]).status_code == 303
    assert [a.id for a in adopted(app, "segment")] == [int(first[0])]


def page_item(browser: Browser, item: str, answer: int) -> Any:
    page = browser.client.get(f"{BASE}/queue/{item}/edit?answer={answer}")
    assert page.status_code == 200
    found = re.search(r'id="item">(.*?)</script>', page.text, re.DOTALL)
    assert found is not None
    return json.loads(found[1])


def test_the_editor_begins_with_an_answer(app: Flask) -> None:
    judge = Browser(app, "adjudicator")
    item, nodes = grounding_dispute(app, judge)
    answers = rows_in(app, select(Answer).where(Answer.item_id == item).order_by(Answer.id))
    worker = judge.client.get(f"/api/items/{item}/answers").json
    for answer, sent in zip(answers, worker["answers"], strict=True):
        data = page_item(judge, item, answer.id)
        # The same page data as a worker's, so that the same script shows it.
        assert data["payload"]["map"] == worker["payload"]["map"]
        assert data["start"]["groundings"] == sent["body"]["groundings"]
        assert set(map(str, nodes)) == set(data["start"]["groundings"])
        assert (data["to"], data["from"], data["item"]) == ("adjudicate", answer.id, item)
    segmented = dispute(app)
    with reading(engine_of(app)) as session:
        one = session.scalars(select(Answer).where(Answer.item_id == segmented)).first()
    assert one is not None
    assert page_item(judge, segmented, one.id)["payload"]["suggestion"] == one.body["sdcs"]
    for strange in ("0", "x", "", str(answers[0].id), "9" * 30):
        path = f"{BASE}/queue/{segmented}/edit?answer={strange}"
        assert judge.client.get(path).status_code == 404
    assert Browser(app, "annotator").client.get(f"{BASE}/queue/{item}/edit").status_code == 403


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_one_more_person_is_asked(app: Flask) -> None:
    item = dispute(app)
    judge = Browser(app, "adjudicator")
    path = f"{BASE}/queue/{item}"
    sent = {"choice": "ask", "comment": "hard to tell", "uuid": str(uuid.uuid4())}
    for _ in range(2):  # a second click does nothing
        assert post(judge, path, **sent).status_code == 303
    slots = rows_in(app, select(Slot).where(Slot.item_id == item))
    assert sorted(slot.answered for slot in slots) == [False, True, True]
    assert post(judge, path, choice="ask").status_code == 409
    queue = plain(judge.client.get(f"{BASE}/queue").text)
    assert "There is nothing to decide. Waiting for one more answer Pick up the tires" in queue
    assert "hard to tell" in judge.client.get(path).text
    third = Browser(app)
    assert third.take("segment")["item"] == item
    assert third.answer(item, sdcs(OTHER)).json["state"] == "accepted"
    # It waits no more, and two of three say the same.
    assert "nothing to decide" not in judge.client.get(f"{BASE}/queue").text
    page = plain(judge.client.get(path).text)
    assert "the same as answer 3" in page
    assert "the same as answer 2" in page
    # Two pairs share .75 of their clauses, and one all of them.
    assert "Agreement of any two of the answers, on average: " in page


def test_deciding_lets_nobody_be_asked_any_more(app: Flask) -> None:
    item = dispute(app)
    judge = Browser(app, "adjudicator")
    post(judge, f"{BASE}/queue/{item}", choice="ask")
    page = judge.client.get(f"{BASE}/queue/{item}").text
    assert "waits for one more answer" in page
    first = re.findall(r'name="choice" value="(\d+)"', page)[0]
    assert post(judge, f"{BASE}/queue/{item}", choice=first, comment="clear").status_code == 303
    assert Browser(app).lease("segment").status_code == 409
    refused = post(judge, f"{BASE}/queue/{item}", choice="ask", comment="<b>again</b>")
    assert refused.status_code == 409
    assert "decided already" in refused.text
    assert "&lt;b&gt;again&lt;/b&gt;" in refused.text  # what was typed is still there


def test_nobody_is_asked_in_a_closed_study(app: Flask) -> None:
    item = dispute(app)
    execute(app, update(Study).values(closed_at=1.0))
    refused = post(Browser(app, "adjudicator"), f"{BASE}/queue/{item}", choice="ask")
    assert refused.status_code == 409
    assert "The study is closed" in refused.text


def test_what_people_disagree_on_most(app: Flask) -> None:
    judge = Browser(app, "adjudicator")
    grounded, _ = grounding_dispute(app, judge)
    found = judge.client.get("/api/dashboard/studies/tests/disagreements").json["data"]
    by_kind = {
        (one["kind"], one["what"], one["task"]): (one["disputed"], one["parts"]) for one in found
    }
    # Both name a thing for each of three clauses, never the same one.
    assert by_kind["task", "ground", "ground"][0] > 0
    things = {what for kind, what, _ in by_kind if kind == "thing"}
    assert len(things) == 2
    assert by_kind["words", "by", "segment"] == (2, 2)
    assert ("words", "up", "segment") not in by_kind
    items = [one for one in found if one["kind"] == "item"]
    assert {one["what"] for one in items} >= {grounded}
    page = judge.client.get(f"{BASE}/disagreements").text
    links = re.findall(r'class="name" href="([^"]+)"', page)
    assert len(links) == len(found)
    assert f"{BASE}/queue/{grounded}" in links
    for link in links:
        assert judge.client.get(unescape(link)).status_code == 200
    assert VIDEOS[0] in page
    assert Browser(app, "annotator").client.get(f"{BASE}/disagreements").status_code == 403


def test_nobody_disagrees_in_an_empty_study(app: Flask) -> None:
    Browser(app).do("describe", described(COMMAND))
    page = Browser(app, "adjudicator").client.get(f"{BASE}/disagreements").text
    assert "Nobody disagrees so far" in page
