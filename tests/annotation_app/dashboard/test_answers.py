"""Answers for researchers: found, excluded, redone, exported."""

from __future__ import annotations

import csv
import io
import re
from datetime import datetime, timedelta, timezone
from itertools import pairwise
from typing import Any

import pytest
from flask import Flask
from playwright.sync_api import BrowserContext, expect
from sqlalchemy import func, select

from annotation_app.export.answer_tables import TABLES, WITH_EXCLUDED
from annotation_app.export.corpus_export import export_corpus
from annotation_app.privacy.erasure import erase
from annotation_app.store.database import reading, transaction
from annotation_app.store.models import Answer, AuditEntry, Item, Person, Remark, Slot
from annotation_app.work.handing_out import find_study
from tests.annotation_app.browser import COMMAND, Browser, described, engine_of, row_in, rows_in
from tests.annotation_app.dashboard.test_pages import (
    BASE,
    ONE,
    adopted,
    dispute,
    grounding_dispute,
    post,
    sdcs,
)
from tests.annotation_app.in_browser import errors_of, look, sign_in

API = "/api/dashboard/studies/tests"


@pytest.fixture
def judge(app: Flask) -> Browser:
    return Browser(app, "adjudicator")


def found(judge: Browser, **asked: str) -> list[dict[str, Any]]:
    reply = judge.client.get(f"{API}/answers", query_string=asked)
    assert reply.status_code == 200, reply.text
    return list(reply.json["data"])


def review(judge: Browser, answer: int, action: str, text: str = "") -> Any:
    sent = {"action": action, "text": text}
    return judge.send("POST", f"{API}/answers/{answer}/review", sent)


def commands_of(app: Flask) -> list[str]:
    with reading(engine_of(app)) as session:
        corpus = export_corpus(session, find_study(session, "tests"))
    return [command.text for command in corpus.commands.values()]


def test_exports_are_told_apart_and_have_times_and_names(app: Flask, judge: Browser) -> None:
    dispute(app)
    names = []
    for form in ("corpus", "slu-core", *TABLES):
        for asked in ("", "?excluded=yes") if form in WITH_EXCLUDED else ("",):
            reply = judge.client.get(f"{BASE}/export/{form}{asked}")
            names.append(reply.headers["Content-Disposition"])
    assert len(set(names)) == len(names)
    assert all('filename="tests-' in name for name in names)
    before = datetime.now(timezone.utc)
    (first, *_) = csv.DictReader(io.StringIO(judge.client.get(f"{BASE}/export/csv").text))
    at = datetime.fromisoformat(first["at"])
    assert timedelta() < before - at < timedelta(hours=1)
    assert first["person"] in judge.client.get(f"{BASE}/people").text
    assert found(judge, person=first["person"]) == found(judge, person=first["subject"])


def bulk(judge: Browser, *answers: int, **form: str) -> Any:
    sent = {"csrf_token": judge.csrf, "answer": [str(one) for one in answers], **form}
    return judge.client.post(f"{BASE}/answers", data=sent, follow_redirects=True)


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_many_answers_are_excluded_restored_adopted_and_exported(
    app: Flask, judge: Browser
) -> None:
    dispute(app)
    segments = [one["answer"] for one in found(judge, task="segment")]
    assert "Tick the answers first" in bulk(judge, action="exclude", reason="x").text
    assert "2 not: Say why." in bulk(judge, *segments, action="exclude").text
    assert (
        "2 excluded." in bulk(judge, action="exclude", reason="x", task="segment", all="yes").text
    )
    assert [one["states"] for one in found(judge, task="segment")] == [["excluded"]] * 2
    assert "2 restored." in bulk(judge, *segments, action="restore").text
    assert "1 adopted." in bulk(judge, segments[0], action="adopt").text
    assert [answer.id for answer in adopted(app, "segment")] == [segments[0]]
    told = bulk(judge, *segments, 999, action="redo", reason="Odd").text
    assert "2 excluded, to be redone. 1 not: There is no such answer." in told
    reply = bulk(judge, segments[1], action="export")
    assert [row["answer"] for row in csv.DictReader(io.StringIO(reply.text))] == [str(segments[1])]
    assert Browser(app).client.post(f"{BASE}/answers").status_code in (400, 403)


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_answers_are_put_in_order(app: Flask, judge: Browser) -> None:
    dispute(app)
    other = Browser(app)
    for number in range(30):
        page = other.lease("describe")
        if page.status_code == 200:
            if number == 1:
                other.note(page.json["item"], "flag", "dark")
            other.answer(page.json["item"], described(f"Go {number}"))
    whole = found(judge)
    orders = {}
    for order in ("newest", "oldest", "person", "disagreement", "reports"):
        reply = judge.client.get(f"{API}/answers", query_string={"order": order}).json
        rows = reply["data"]
        if reply["before"] is not None:
            rows += found(judge, order=order, before=reply["before"])
        orders[order] = rows
        assert len({one["answer"] for one in orders[order]}) == len(orders[order])
    assert orders["newest"][: len(whole)] == whole
    assert orders["oldest"] == orders["newest"][::-1]
    assert {one["task"] for one in orders["disagreement"][:2]} == {"segment"}
    assert "Go 1" in [one["command"] for one in orders["reports"] if one["reports"]]
    assert [one["reports"] > 0 for one in orders["reports"]][:3].count(True) >= 1
    assert not orders["reports"][-1]["reports"]
    people = [one["person"] for one in orders["person"]]
    assert sum(one != after for one, after in pairwise(people)) == len(set(people)) - 1
    assert judge.client.get(f"{API}/answers", query_string={"order": "x"}).status_code == 404


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_filters(app: Flask, judge: Browser) -> None:
    dispute(app)
    other = Browser(app)
    other.do("describe", described("Fetch 100 % of the Pallets_now"))
    flagged = other.take("describe")["item"]
    other.note(flagged, "flag", "it is black")
    other.answer(flagged, described("Drive on"))
    everything = found(judge)
    assert [one["task"] for one in everything] == [
        "describe", "describe", "segment", "segment", "describe",
    ]  # fmt: skip
    by_text = {
        text: len(found(judge, text=text)) for text in ("TIRES", "% of", "s_n", "_", "zebra")
    }
    assert by_text == {"TIRES": 3, "% of": 1, "s_n": 1, "_": 1, "zebra": 0}
    assert [one["command"] for one in found(judge, flagged="1")] == ["Drive on"]
    assert len(found(judge, task="segment")) == 2
    assert len(found(judge, state="in dispute")) == 2
    assert len(found(judge, state="adopted")) == 3
    subject = everything[0]["subject"]
    assert {one["subject"] for one in found(judge, person=subject)} == {subject}
    video = everything[0]["video"]
    assert {one["video"] for one in found(judge, video=video)} == {video}
    assert found(judge, video="nothing") == []
    assert judge.client.get(f"{API}/answers?state=odd").status_code == 404
    assert judge.client.get(f"{API}/answers?task=odd").status_code == 404


def test_pages_of_answers(app: Flask, judge: Browser) -> None:
    for _ in range(9):
        one = Browser(app)
        for number in range(3):
            one.do("describe", described(f"Command {number}"))
    seen, address = [], f"{BASE}/answers?task=describe"
    while address:
        page = judge.client.get(address).text
        seen += re.findall(rf'href="{BASE}/answers/(\d+)"', page)
        older = re.search(rf'href="({BASE}/answers\?before=[^"]+)"', page)
        address = older[1].replace("&amp;", "&") if older else ""
    assert len(seen) == len(set(seen)) == 27
    assert seen == sorted(seen, key=int, reverse=True)


def test_a_page_for_each_answer(app: Flask, judge: Browser) -> None:
    admin = Browser(app, "admin")
    grounding_dispute(app, admin)
    for one in found(judge):
        page = judge.client.get(f"{BASE}/answers/{one['answer']}")
        assert page.status_code == 200
        assert COMMAND in page.text
        if one["task"] == "segment":
            assert "<svg" in page.text
            assert "EVENT_1(r = Pick up" in page.text
        elif one["task"] == "ground":
            assert "the tires by the truck" in page.text
            assert 'class="map"' in page.text
    assert judge.client.get(f"{BASE}/answers/999").status_code == 404
    assert judge.client.get(f"{BASE}/answers/{10**30}").status_code == 404


def test_leaving_out_and_taking_back(app: Flask, judge: Browser) -> None:
    item = dispute(app)
    first, second = [one["answer"] for one in reversed(found(judge, task="segment"))]
    post(judge, f"{BASE}/queue/{item}", choice=str(first))
    (command,) = [one["answer"] for one in found(judge, task="describe")]
    worker = Browser(app)
    assert review(judge, command, "exclude").status_code == 422
    assert review(judge, command, "exclude", "Rude.").json["states"] == ["excluded"]
    assert review(judge, command, "exclude", "Again.").status_code == 409
    # Neither it nor what was made of it counts any more, and nobody gets that.
    assert commands_of(app) == []
    assert worker.lease("ground").status_code == 409
    assert judge.client.get(f"{API}/corpus").json["data"]["commands"] == 0
    # The answers in the tables are those that count, unless one asks for the others.
    path = f"{BASE}/export/csv"
    for query, expected in (
        ("", [("", "False")] * 2),
        ("?excluded=yes", [("Rude.", "True"), *[("", "False")] * 2]),
    ):
        table = list(csv.DictReader(io.StringIO(judge.client.get(path + query).text)))
        assert [(row["reason"], row["excluded"]) for row in table] == expected
    assert review(judge, command, "restore").json["states"] == ["submitted", "adopted"]
    assert review(judge, command, "restore").status_code == 409
    assert commands_of(app) == [COMMAND]
    assert worker.lease("ground").status_code == 200
    assert [a.id for a in adopted(app, "segment")] == [first]
    assert second != first
    trail = [
        (entry.action, entry.about, entry.details)
        for entry in rows_in(app, select(AuditEntry).order_by(AuditEntry.id))
        if entry.action.endswith("an answer")
    ]
    about = {"answer": command}
    assert trail == [
        ("adopted an answer", "tests", {"answer": first}),
        ("excluded an answer", "tests", about), ("restored an answer", "tests", about),
    ]  # fmt: skip


def test_leaving_out_one_side_settles_a_dispute(app: Flask, judge: Browser) -> None:
    dispute(app)
    second, first = [one["answer"] for one in found(judge, task="segment")]
    assert review(judge, second, "exclude", "Wrong clauses.").status_code == 200
    assert [a.id for a in adopted(app, "segment")] == [first]
    assert "nothing to decide" in judge.client.get(f"{BASE}/queue").text
    assert review(judge, second, "restore").json["states"] == ["submitted"]
    assert [a.id for a in adopted(app, "segment")] == [first]


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_asking_somebody_else(app: Flask, judge: Browser) -> None:
    item = dispute(app)
    second, _ = [one["answer"] for one in found(judge, task="segment")]
    assert Browser(app).lease("segment").status_code == 409
    assert review(judge, second, "redo", "Wrong clauses.").status_code == 200
    assert found(judge, state="in dispute") == []
    other = Browser(app)
    assert other.take("segment")["item"] == item
    assert other.answer(item, sdcs(ONE)).json["state"] == "accepted"
    assert len(adopted(app, "segment")) == 1
    # The place is taken: the old answer counts as one that came late.
    assert review(judge, second, "restore").json["states"] == ["submitted", "late"]
    with reading(engine_of(app)) as session:
        slots = select(func.count()).where(Slot.item_id == item)
        assert session.scalar(slots) == 2


def test_who_answered_is_not_asked_again(app: Flask, judge: Browser) -> None:
    one = Browser(app)
    one.do("describe", described())
    page = one.take("segment")
    one.answer(page["item"], sdcs(ONE))
    (answer,) = [found_["answer"] for found_ in found(judge, task="segment")]
    assert review(judge, answer, "redo", "Once more.").status_code == 200
    assert one.lease("segment").status_code == 409
    assert review(judge, answer, "restore").json["states"] == ["submitted"]


def test_the_page_reviews(app: Flask, judge: Browser) -> None:
    Browser(app).do("describe", described())
    path = f"{BASE}/answers/{found(judge)[0]['answer']}"
    assert judge.client.post(path, data={"action": "comment", "text": "x"}).status_code == 400
    text = '<script>alert("x")</script>'
    assert post(judge, path, action="comment", text=text).status_code == 303
    page = judge.client.get(path).text
    assert "<script>alert" not in page
    assert "&lt;script&gt;alert" in page
    refused = post(judge, path, action="exclude", text=" ")
    assert refused.status_code == 422
    assert "Say why." in refused.text
    assert post(judge, path, action="odd").status_code == 404
    assert post(judge, path, action="exclude", text="Rude.").status_code == 303
    assert ">Restore<" in judge.client.get(path).text


def test_erasing_takes_what_was_said_along(app: Flask, judge: Browser) -> None:
    one = Browser(app)
    one.do("describe", described())
    review(judge, found(judge)[0]["answer"], "comment", "Quotes them.")
    with transaction(engine_of(app)) as session:
        erase(session, session.get_one(Person, one.person.id), now=0.0)
        assert session.scalars(select(Remark)).all() == []
        assert session.scalars(select(Answer)).all() == []


def test_reports_and_reasons(app: Flask, judge: Browser) -> None:
    one = Browser(app)
    for name, reason in (("flag", "It is <b>black</b>"), ("skip", "=cmd()")):
        one.note(one.take("describe")["item"], name, reason)
    listed = judge.client.get(f"{API}/reports").json["data"]
    assert [(r["kind"], r["reason"]) for r in listed] == [
        ("skip", "=cmd()"), ("flag", "It is <b>black</b>"),
    ]  # fmt: skip
    page = judge.client.get(f"{BASE}/reports").text
    assert "It is &lt;b&gt;black&lt;/b&gt;" in page
    table = judge.client.get(f"{BASE}/export/reports.csv").text
    assert [row["reason"] for row in csv.DictReader(io.StringIO(table))] == [
        "It is <b>black</b>", "'=cmd()",
    ]  # fmt: skip


def test_only_adjudicators_see_answers(app: Flask) -> None:
    Browser(app).do("describe", described())
    answer = row_in(app, select(Answer.id))
    item = rows_in(app, select(Item).where(Item.task == "describe", Item.video == ""))
    assert item == []
    paths = [
        f"{at}/{name}" for at in (BASE, API) for name in ("answers", f"answers/{answer}", "reports")
    ]
    for role, status in (("worker", 403), ("annotator", 403), ("adjudicator", 200), ("admin", 200)):
        one = Browser(app, role)  # type: ignore[arg-type]
        assert {one.client.get(path).status_code for path in paths} == {status}, role
        assert review(one, answer, "comment", "Good.").status_code == status
        page = post(one, f"{BASE}/answers/{answer}", action="comment", text="Good.")
        assert page.status_code == (303 if status == 200 else 403)
    stranger = app.test_client()
    assert {stranger.get(path).status_code for path in paths} == {302, 401}


@pytest.mark.slow
def test_long_words_are_accessible(app: Flask, address: str, context: BrowserContext) -> None:
    admin = Browser(app, "admin")
    grounding_dispute(app, admin)
    listed = found(admin)
    review(admin, listed[-1]["answer"], "comment", "A long comment without end " * 10)
    worker = Browser(app)
    worker.note(worker.take("describe")["item"], "flag", "W" * 300)
    sign_in(context, admin, address)
    page = context.new_page()
    errors = errors_of(page)
    wrong: list[str] = []
    by_task = {one["task"]: f"{BASE}/answers/{one['answer']}" for one in listed}
    for path in (f"{BASE}/answers", f"{BASE}/reports", *by_task.values()):
        page.goto(f"{address}{path}")
        wrong += look(page, path.replace("/", "-"))
    assert wrong == []
    assert errors == []


@pytest.mark.slow
def test_many_answers_are_ticked_in_a_browser(
    app: Flask, address: str, context: BrowserContext
) -> None:
    judge = Browser(app, "adjudicator")
    dispute(app)
    sign_in(context, judge, address)
    page = context.new_page()
    errors = errors_of(page)
    page.goto(f"{address}{BASE}/answers?task=segment&order=person")
    page.get_by_label("All on this page").check()
    expect(page.get_by_label("Answer 2")).to_be_checked()
    page.get_by_label("Reason").fill("Odd")
    page.get_by_role("button", name="Exclude").click()
    expect(page.get_by_text("2 excluded.")).to_be_visible()
    assert "order=person" in page.url
    page.get_by_label("All 2 that the filter shows").check()
    page.get_by_role("button", name="Restore").click()
    expect(page.get_by_text("2 restored.")).to_be_visible()
    page.get_by_label("Answer 3").check()
    with page.expect_download() as saved:
        page.get_by_role("button", name="Export (CSV)").click()
    assert saved.value.suggested_filename == "tests-answers-chosen.csv"
    assert errors == []
