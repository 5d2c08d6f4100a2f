from __future__ import annotations

import io
import re
import uuid
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from flask import Flask
from jsonschema import Draft202012Validator
from sqlalchemy import select, update

from annotation_app.export.answer_tables import TABLES
from annotation_app.store.database import reading, transaction
from annotation_app.store.models import Answer, Event, Item
from annotation_app.tasks.rate import passes
from annotation_app.tasks.task_registry import tasks
from corpus_tools.corpus.corpus_model import Corpus
from g3.sdc.sdc_notation import format_brackets, from_json, parse_brackets, to_json
from tests.annotation_app.browser import (
    COMMAND,
    Browser,
    described,
    engine_of,
    execute,
    row_in,
    rows_in,
)
from tests.annotation_app.conftest import STUDY
from tests.annotation_app.rendered import VIDEOS

ONE = "EVENT(r = Pick up, l = OBJ(f = OBJ(f = the tires), r = by, l = OBJ(f = the truck)))"
OTHER = "EVENT(r = Pick up, l = OBJ(f = the tires), l2 = PLACE(r = by, l = OBJ(f = the truck)))"
BASE = "/dashboard/tests"


def sdcs(notation: str) -> dict[str, Any]:
    return {"sdcs": to_json(parse_brackets(notation, command=COMMAND))}


def dispute(app: Flask) -> str:
    """Two people segment a command differently; the id of its item."""
    one, other = Browser(app), Browser(app)
    one.do("describe", described())
    page = one.take("segment")
    one.answer(page["item"], sdcs(ONE))
    assert other.take("segment")["item"] == page["item"]
    other.answer(page["item"], sdcs(OTHER))
    return str(page["item"])


def post(browser: Browser, path: str, **form: str) -> Any:
    sent = {"csrf_token": browser.csrf, "uuid": str(uuid.uuid4()), **form}
    return browser.client.post(path, data=sent)


def adopted(app: Flask, task: str) -> list[Answer]:
    return rows_in(app, select(Answer).where(Answer.task == task, Answer.adopted))


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_an_overview(app: Flask) -> None:
    dispute(app)
    page = Browser(app, "adjudicator").client.get(BASE)
    assert page.status_code == 200
    text = re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", page.text))
    assert "describe 3 % 1 of 27 –" in text
    assert "segment 100 % 2 of 2 –" in text
    assert "segment span F, mean over pairs 1 item; shown from 10 1" in text
    assert "1 dispute to decide" in text
    assert "At work in the last hour" in text
    assert f"{VIDEOS[0]} 1 of 9 2 of 2 0 of 9" in text


def test_who_sees_what(app: Flask) -> None:
    item = dispute(app)
    pages = (BASE, f"{BASE}/people", f"{BASE}/queue", f"{BASE}/queue/{item}", f"{BASE}/export/csv")
    api = "/api/dashboard/studies/tests"
    numbers = (f"{api}/progress", f"{api}/agreement", f"{api}/people", f"{api}/videos")
    for role, expected in {
        "worker": (403,) * 9,
        "annotator": (200, 403, 403, 403, 403, 200, 403, 403, 403),
        "adjudicator": (200,) * 9,
    }.items():
        browser = Browser(app, role)  # type: ignore[arg-type]
        found = tuple(browser.client.get(path).status_code for path in (*pages, *numbers))
        assert found == expected, role
    stranger = app.test_client()
    assert {stranger.get(path).status_code for path in numbers} == {401}
    assert {stranger.get(path).headers.get("Location") for path in pages} == {
        f"/login?next={path}" for path in pages
    }
    overview = Browser(app, "annotator").client.get(BASE).text
    assert not any(video in overview for video in VIDEOS)


def test_choosing_an_answer(app: Flask) -> None:
    item = dispute(app)
    judge = Browser(app, "adjudicator")
    page = judge.client.get(f"{BASE}/queue/{item}").text
    assert "Choose answer 1" in page
    assert "Choose answer 2" in page
    second = re.findall(r'name="choice" value="(\d+)"', page)[1]
    sent = {"uuid": str(uuid.uuid4()), "choice": second}
    for _ in range(2):  # a second click does nothing
        assert post(judge, f"{BASE}/queue/{item}", **sent).status_code == 303
    (answer,) = adopted(app, "segment")
    assert format_brackets(from_json(answer.body["sdcs"])).startswith(
        "EVENT_1(r = Pick up, l = OBJ_2(f = the"
    )
    assert answer.id == int(second)
    (event,) = rows_in(app, select(Event).where(Event.name == "adjudicate"))
    assert event.body == {"answer": int(second)}
    assert event.person_id == judge.person.id
    assert row_in(app, select(Item).where(Item.task == "ground"))
    assert "nothing to decide" in judge.client.get(f"{BASE}/queue").text


def grounding_dispute(app: Flask, judge: Browser) -> tuple[str, list[int]]:
    """Two people ground a command's objects differently; its item, and the clauses."""
    assert judge.adjudicate(dispute(app), sdcs(ONE)).status_code == 200
    for number, person in enumerate((Browser(app), Browser(app))):
        if number:
            assert "nothing to decide" in judge.client.get(f"{BASE}/queue").text
        page = person.take("ground")
        objects = [o["id"] for o in page["payload"]["map"]["objects"]]
        nodes = [c["node"] for c in page["payload"]["clauses"] if c["type"] == "OBJECT"]
        groundings = {str(n): {"objects": [objects[number]]} for n in nodes}
        person.answer(page["item"], {"groundings": groundings, "trims": {}})
    return page["item"], nodes


def test_forms_need_their_token(app: Flask) -> None:
    item = dispute(app)
    judge = Browser(app, "adjudicator")
    assert judge.client.post(f"{BASE}/queue/{item}", data={"choice": "1"}).status_code == 400
    assert post(judge, f"{BASE}/queue/{item}", uuid="x", choice="1").status_code == 400
    assert post(judge, f"{BASE}/queue/{item}", choice="999").status_code == 422
    assert post(judge, f"{BASE}/queue/nothing", choice="1").status_code == 404


def rate(app: Flask, ratings: dict[bool | None, int], count: int, seconds: float) -> Browser:
    """Somebody who rates, by what is right (None where nobody knows)."""
    one = Browser(app)
    for _ in range(count):
        item = one.take("rate")["item"]
        with reading(one.engine) as session:
            right = session.get_one(Item, item).payload["right"]
        one.answer(item, {"rating": ratings[right], "watched_s": 1.0})
    execute(
        one.engine, update(Answer).where(Answer.person_id == one.person.id).values(seconds=seconds)
    )
    return one


def test_flagged_workers(app: Flask) -> None:
    author = Browser(app)
    for number in range(3):
        author.do("describe", described(f"Command {number}."))
    good = rate(app, {True: 5, False: 1, None: 4}, 8, 30.0)
    fast = rate(app, {True: 5, False: 1, None: 2}, 8, 3.0)
    careless = rate(app, {True: 1, False: 5, None: 3}, 8, 30.0)
    copier = Browser(app)
    for _ in range(3):
        copier.do("describe", described("go"))
    reply = Browser(app, "admin").client.get("/api/dashboard/studies/tests/people").json
    reasons = {person["person_id"]: person["reasons"] for person in reply["data"]}
    assert reasons[author.person.id] == []
    assert reasons[good.person.id] == []
    assert reasons[fast.person.id] == ["too fast: 3 s for an item of rate, others take 30 s"]
    assert reasons[careless.person.id] == ["failed 2 of 2 attention checks"]
    assert reasons[copier.person.id] == ["typed the same command 3 times"]
    flagged_first = [bool(person["reasons"]) for person in reply["data"]]
    assert flagged_first == sorted(flagged_first, reverse=True)


def test_always_the_same_rating(app: Flask) -> None:
    author = Browser(app)
    for number in range(3):
        author.do("describe", described(f"Command {number}."))
    other = Browser(app)
    for number in range(3):
        other.do("describe", described(f"Order {number}."))
    rate(app, {True: 5, False: 1, None: 3}, 10, 30.0)
    page = Browser(app, "adjudicator").client.get(BASE).text
    assert "always the same rating: 3, 8 times" in page


@pytest.mark.parametrize(
    ("right", "rating", "passed"),
    [(True, 4, True), (True, 3, False), (False, 2, True), (False, 3, False)],
)
def test_attention_checks(right: bool, rating: int, passed: bool) -> None:
    assert passes({"right": right}, {"rating": rating}) is passed


def test_blocking(app: Flask) -> None:
    one, admin, judge = Browser(app), Browser(app, "admin"), Browser(app, "adjudicator")
    one.do("describe", described())
    path = f"{BASE}/people/{one.person.id}"
    assert post(judge, path, block="yes").status_code == 403
    # It asks first: the list leads to a page that changes nothing.
    assert f'href="{path}"' in admin.client.get(f"{BASE}/people").text
    assert "get no more items, in any study" in admin.client.get(path).text
    assert judge.client.get(path).status_code == 403
    assert one.lease("describe").status_code == 200
    assert post(admin, path, block="yes").status_code == 303
    assert one.lease("describe").json["reason"] == "blocked"
    assert "Unblock" in admin.client.get(f"{BASE}/people").text
    assert post(admin, path, block="no").status_code == 303
    assert one.lease("describe").status_code == 200


def test_times(app: Flask) -> None:
    one = Browser(app)
    for _ in range(3):
        one.do("describe", described())
    with transaction(engine_of(app)) as session:
        for number, answer in enumerate(session.scalars(select(Answer))):
            answer.seconds = (10.0, 20.0, 60.0)[number]
    reply = Browser(app, "annotator").client.get("/api/dashboard/studies/tests/times").json
    # Quartiles of 10, 20, 60 between the values: 15, 20, 40.
    assert reply["data"] == [
        {"task": "describe", "answers": 3, "lower_s": 15.0, "median_s": 20.0, "upper_s": 40.0}
    ]


def test_answers_over_time(app: Flask) -> None:
    one = Browser(app)
    for _ in range(3):
        one.do("describe", described())
    day = 86_400.0
    with transaction(engine_of(app)) as session:
        for number, answer in enumerate(session.scalars(select(Answer).order_by(Answer.id))):
            answer.at -= (4 - 2 * number) * day
    client = Browser(app, "annotator").client
    (history,) = client.get("/api/dashboard/studies/tests/history").json["data"]
    assert history["task"] == "describe"
    assert history["answers"] == sorted(history["answers"])
    assert (history["answers"][0], history["answers"][-1]) == (1, 3)
    middle = [n for at, n in zip(history["at"], history["answers"], strict=True) if n == 2]
    assert len(middle) in (19, 20, 21)  # half of the time
    page = client.get(BASE).text
    assert page.count('class="series ') == 1
    assert page.count("<polyline") == 1
    assert "All numbers as tables" in page


def test_agreement_of_ten_items_has_an_interval(app: Flask) -> None:
    people, rng = (Browser(app), Browser(app)), np.random.default_rng(1)
    found = []
    for authors in (1, 4):
        for _ in range(authors):
            author = Browser(app)
            for _ in VIDEOS:
                author.do("describe", described(f"Command {rng.integers(10**9)}."))
        for person in people:
            while (reply := person.lease("rate")).status_code == 200:
                person.answer(reply.json["item"], {"rating": int(rng.integers(1, 6))})
        numbers = Browser(app, "adjudicator").client.get("/api/dashboard/studies/tests/agreement")
        found.append(next(one for one in numbers.json["data"] if one["task"] == "rate"))
    few, enough = found
    assert few["items"] < 10
    assert (few["value"], few["low"], few["reason"]) == (None, None, "few items")
    assert enough["items"] >= 10
    assert -1 <= enough["low"] < enough["value"] < enough["high"] <= 1
    page = Browser(app, "adjudicator").client.get(BASE).text
    assert page.count('class="dot ') >= 1
    assert f"{enough['low']:.2f} to {enough['high']:.2f}".replace("-", "−") in page


def test_who_rates_as_nobody_else_has_less_weight(app: Flask) -> None:
    """Dawid and Skene's model needs three people, and ten items with several ratings."""
    judge = Browser(app, "adjudicator")
    people = [Browser(app) for _ in range(4)]
    for authors, is_weighed in ((1, False), (4, True)):
        for author in [Browser(app) for _ in range(authors)]:
            for video in VIDEOS:
                author.do("describe", described(f"Command {author.person.id} {video}."))
        for number, person in enumerate(people):
            while (reply := person.lease("rate")).status_code == 200:
                with reading(person.engine) as session:
                    about = session.get_one(Item, reply.json["item"]).payload
                fits = about["video"] == about["own_video"]
                person.answer(reply.json["item"], {"rating": 5 if fits == (number < 3) else 1})
        page = judge.client.get(f"{BASE}/people").text
        assert (">Weight<" in page) == is_weighed
    found = judge.client.get("/api/dashboard/studies/tests/people").json["data"]
    weights = {one["person_id"]: one["weight"] for one in found}
    good, contrary = (weights[people[number].person.id]["rate"] for number in (0, 3))
    assert (round(good, 2), round(contrary, 2)) == (1.0, 0.0)
    assert "rate 1.00" in page
    assert "rate 0.00" in page


def test_the_work_that_is_left(app: Flask) -> None:
    for one in [Browser(app) for _ in range(4)]:
        for _ in VIDEOS:
            one.do("describe", described())
    with transaction(engine_of(app)) as session:
        for number, answer in enumerate(session.scalars(select(Answer).order_by(Answer.id))):
            answer.at -= (12 - number) * 3600
            answer.seconds = 60.0
    page = Browser(app, "annotator").client.get(BASE).text
    text = re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", page))
    assert re.search(r"\d+ answers left", text)
    assert "min of work without" in text  # of describe's median; nobody has done the others
    assert re.search(r"done in \S+ (h|days) at last week’s pace", text)


def test_exports_are_in_one_place(app: Flask) -> None:
    judge = Browser(app, "adjudicator")
    page = judge.client.get(f"{BASE}/exports").text
    assert "Nobody has answered yet" in page
    files = re.findall(r'href="(/dashboard/tests/export/[^"]+)"', page)
    assert len(files) == len(set(files)) > 8
    for path in files:
        with judge.client.get(path.replace("&amp;", "&")) as reply:
            assert reply.status_code == 200, path
    assert Browser(app, "annotator").client.get(f"{BASE}/exports").status_code == 403


def test_only_files_of_the_studys_tasks_are_shown(app: Flask) -> None:
    page = Browser(app, "adjudicator").client.get(f"{BASE}/exports").text
    files = set(re.findall(r'href="/dashboard/tests/export/([^"?]+)"', page))
    others = {name for task in tasks() for name in task.tables if task.name not in STUDY.tasks}
    assert others
    assert not files & others
    assert set(TABLES) - others <= files


def test_exports(app: Flask, tmp_path: Path) -> None:
    judge = Browser(app, "adjudicator")
    judge.adjudicate(dispute(app), sdcs(ONE))
    reply = judge.client.get(f"{BASE}/export/corpus")
    assert reply.headers["Content-Disposition"] == 'attachment; filename="tests-corpus.zip"'
    with zipfile.ZipFile(io.BytesIO(reply.data)) as archive:
        archive.extractall(tmp_path)
    assert [command.text for command in Corpus.load(tmp_path / "tests").commands.values()] == [
        COMMAND
    ]
    assert COMMAND in judge.client.get(f"{BASE}/export/jsonl").text
    assert COMMAND in judge.client.get(f"{BASE}/export/csv").text
    assert judge.client.get(f"{BASE}/export/nothing").status_code == 404


def test_workers_text_is_escaped(app: Flask) -> None:
    one, other = Browser(app), Browser(app)
    text = '<script>alert("x")</script> go'
    one.do("describe", described(text))
    for person, words in ((one, "go"), (other, "alert")):
        start = text.index(words)
        leaf = {"type": "EVENT", "r": [[words, start]]}
        assert person.answer(person.take("segment")["item"], {"sdcs": [leaf]}).status_code == 200
    judge = Browser(app, "adjudicator")
    queue = judge.client.get(f"{BASE}/queue").text
    item = re.search(r"/queue/(\w+)", queue)
    assert item is not None
    for page in (queue, judge.client.get(f"{BASE}/queue/{item[1]}").text):
        assert "<script>alert" not in page
        assert "&lt;script&gt;" in page


def test_an_empty_study_has_a_dashboard(app: Flask) -> None:
    admin = Browser(app, "admin", study=None)
    for path in ("/dashboard/", BASE, f"{BASE}/people", f"{BASE}/queue"):
        assert admin.client.get(path).status_code == 200
    assert admin.client.get("/dashboard/nothing").status_code == 404


def test_the_interface_is_described(app: Flask) -> None:
    dispute(app)
    admin = Browser(app, "admin")
    described_ = admin.client.get("/api/openapi.json").json
    of_answers = re.compile("/(answers|reports|export)")
    paths = [
        path
        for path in described_["paths"]
        if path.startswith("/api/dashboard") and not of_answers.search(path)
    ]
    assert len(paths) == 12
    for path in paths:
        assert list(described_["paths"][path].keys() - {"parameters"}) == ["get"]
        reply = admin.client.get(path.format(study="tests"))
        assert reply.status_code == 200, path
        content = described_["paths"][path]["get"]["responses"]["200"]["content"]
        schema = {**content["application/json"]["schema"], "components": described_["components"]}
        Draft202012Validator(schema).validate(reply.json)
        if "{study}" in path:
            wrong = {**reply.json, "data": [{"task": 7}]}
            assert not Draft202012Validator(schema).is_valid(wrong), path
    assert admin.send("POST", "/api/dashboard/studies", {}).status_code == 405


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_strange_names_are_unknown(app: Flask) -> None:
    admin = Browser(app, "admin")
    for name in ("a%00b", "%F0%9F%A6%86", "..%2f..", "x" * 5000):
        paths = (
            f"/dashboard/{name}",
            f"{BASE}/queue/{name}",
            f"{BASE}/export/{name}",
            f"/api/dashboard/studies/{name}/progress",
            f"/crowd/mturk/{name}",
            f"/crowd/{name}/{name}",
        )
        assert {admin.client.get(path).status_code for path in paths} == {404}, name
        assert post(admin, f"{BASE}/people/{name}", block="yes").status_code == 404
