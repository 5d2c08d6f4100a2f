"""What can be answered, and what people are told."""

from __future__ import annotations

import json
from typing import Any

import pytest
from flask import Flask
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from sqlalchemy import select

from annotation_app.core.sent_text import clean_text
from annotation_app.store.models import Answer
from g3.sdc.sdc_notation import parse_brackets, to_json
from tests.annotation_app.browser import COMMAND, Browser, described, row_in
from tests.annotation_app.work.test_adoption import SDCS, grounded


def problems(person: Browser, item: str, body: Any) -> list[str]:
    response = person.answer(item, body)
    assert response.status_code == 422, response.text
    return [problem["message"] for problem in response.json["problems"]]


@pytest.mark.parametrize(
    ("text", "kept"),
    [
        ("  Go \t to the\ntruck ", "Go to the truck"),
        ("Fahr zum Cafe\u0301 😀", "Fahr zum Café 😀"),
        ("اذهب إلى الشاحنة", "اذهب إلى الشاحنة"),
        ("=HYPERLINK(1)", "=HYPERLINK(1)"),
        ("<b>Go</b>", "<b>Go</b>"),
    ],
)
def test_texts_are_kept(app: Flask, text: str, kept: str) -> None:
    Browser(app).do("describe", described(text))
    assert row_in(app, select(Answer)).body["text"] == kept


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"text": " "}, "Type a command"),
        ({"text": "?!"}, "Type a command"),
        ({"text": "x" * 2001}, "2001 characters long. Use at most 2000"),
        ({"text": "a " * 201}, "at most 200 words"),
        ({"text": "Go\0there"}, "invisible character NUL"),
        ({"text": 5}, "can't be read"),
        ({"more": 5}, "can't be read"),
    ],
)
def test_texts_are_refused(app: Flask, change: dict[str, Any], told: str) -> None:
    person = Browser(app)
    item = person.take("describe")["item"]
    (message,) = problems(person, item, {**described(), **change})
    assert told in message
    assert person.answer(item, described()).json["state"] == "accepted"


@pytest.mark.parametrize("sent", [rb'"\ud800"', b'"\xff"', b"1e999", b"NaN", b"[" * 5000])
def test_what_is_no_text_is_refused(app: Flask, sent: bytes) -> None:
    person = Browser(app)
    item = person.take("describe")["item"]
    reply = person.client.put(
        f"/api/items/{item}/draft",
        data=b'{"revision": 1, "body": {"text": ' + sent + b"}}",
        headers={"X-CSRFToken": person.csrf, "Content-Type": "application/json"},
    )
    assert reply.status_code == 400
    assert "can't be read" in reply.json["error"]


@given(st.text(max_size=200))
def test_clean_text_stays_clean(text: str) -> None:
    clean = clean_text(text)
    assert clean_text(clean) == clean
    assert "\n" not in clean


def segmenting(app: Flask) -> tuple[Browser, str]:
    person = Browser(app)
    person.do("describe", described())
    return person, person.take("segment")["item"]


def tree(notation: str) -> list[Any]:
    return to_json(parse_brackets(notation, command=COMMAND))


@pytest.mark.parametrize(
    ("sdcs", "told"),
    [
        ([], "Mark at least one clause"),
        ([{"type": "OBJECT"}], "Mark at least one clause"),
        ([*tree("OBJ(f = tires)"), {"type": "PLACE"}], "has no words"),
        ([{"type": "OBJECT", "f": [["tires", 3]]}], "“tires” is not in the command there"),
        ([{"type": "THING", "f": [["tires", 12]]}], "There is no type 'THING'"),
        (
            [{"type": "EVENT", "r": [["Pick", 0]], "l": [{"type": "OBJECT", "f": [["Pick", 0]]}]}],
            "“Pick” is used twice",
        ),
        ([{"type": "OBJECT", "f": "tires"}], "Expected a list"),
    ],
)
def test_segmentations_are_refused(app: Flask, sdcs: list[Any], told: str) -> None:
    person, item = segmenting(app)
    assert any(told in message for message in problems(person, item, {"sdcs": sdcs}))


def test_groundings_are_refused_in_plain_words(app: Flask) -> None:
    person, item = segmenting(app)
    person.answer(item, {"sdcs": SDCS})
    page = person.take("ground")
    right = grounded(page)
    place = page["payload"]["map"]["places"][0]["id"]

    def with_node(value: Any) -> dict[str, Any]:
        return {**right, "groundings": {**right["groundings"], "3": value}}

    told = {
        "Show what “the tires” is": with_node({}),
        "isn't in this picture": with_node({"objects": ["tires-1"]}),
        "Choose either something": with_node({"places": [{"place": place}], "cant_tell": True}),
        "isn't on this map": with_node({"places": [{"place": "receiving"}]}),
        "too small": with_node({"places": [{"xy": [[0, 0], [1, 1], [2, 2]]}]}),
        "far outside": with_node({"places": [{"xy": [[0, 0], [9e5, 0], [9e5, 9e5]]}]}),
        "no such clause to ground": {
            **right,
            "groundings": {**right["groundings"], "77": {"cant_tell": True}},
        },
        "no such clause to trim": {**right, "trims": {"3": [0, 1]}},
        "must begin before it ends": {**right, "trims": {"0": [5, 1]}},
    }
    for message, body in told.items():
        assert any(message in m for m in problems(person, page["item"], body)), message
    place_answer = with_node({"places": [{"place": place}, {"xy": [[0, 0], [1, 0], [1, 1]]}]})
    assert person.answer(page["item"], place_answer).status_code == 200


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    max_leaves=12,
)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=60)
@given(body=JSON, task=st.sampled_from(["describe", "segment", "ground"]))
def test_any_json_is_answered_properly(app: Flask, body: Any, task: str) -> None:
    person = _busy(app)
    for name in ("answer", "draft"):
        value = {"uuid": "0" * 8 + "-0000-0000-0000-" + "0" * 12, "body": body}
        if name == "draft":
            value = {"revision": 1, "body": {"any": body}}
        response = person.client.open(
            f"/api/items/{person.items[task]}/{name}",  # type: ignore[attr-defined]
            method="PUT" if name == "draft" else "POST",
            data=json.dumps(value),
            headers={"X-CSRFToken": person.csrf, "Content-Type": "application/json"},
        )
        assert response.status_code in (200, 400, 422), response.text
        assert response.is_json


def _busy(app: Flask) -> Browser:
    """Somebody with an item of three tasks."""
    known = app.extensions.get("tests")
    if known is None:
        known, item = segmenting(app)
        known.answer(item, {"sdcs": SDCS})
        known.do("describe", described("Go away"))
        tasks = ("describe", "segment", "ground")
        known.items = {task: known.take(task)["item"] for task in tasks}
        app.extensions["tests"] = known
    return known
