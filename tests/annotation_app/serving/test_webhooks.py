"""Webhooks: what is told, signed how, again until it arrives, and nothing lost by a kill."""

from __future__ import annotations

import base64
import hashlib
import hmac
import signal
import threading
import time
from pathlib import Path
from typing import Any

import msgspec
import pytest
from flask import Flask
from sqlalchemy import func, select

from annotation_app.core.config import Config
from annotation_app.core.problems import Refusal
from annotation_app.privacy.erasure import erase
from annotation_app.serving.webhook_delivery import (
    CLAIM_S,
    GIVE_UP_S,
    Delivered,
    deliver_due,
    wait_s,
)
from annotation_app.store.database import reading, transaction
from annotation_app.store.models import Answer, Person
from annotation_app.store.program_models import WebhookMessage
from annotation_app.studies.study_file import StudyConfig, TaskConfig
from annotation_app.work.handing_out import find_study
from annotation_app.work.webhooks import (
    add_webhook,
    check_webhook,
    remove_webhook,
    try_again,
    webhook_states,
    written_secret,
)
from tests.annotation_app.browser import (
    Browser,
    described,
    engine_of,
    installation_of,
    row_in,
    rows_in,
)
from tests.annotation_app.conftest import STUDY
from tests.annotation_app.dashboard.test_pages import ONE, OTHER, sdcs
from tests.annotation_app.real_server import new_uuid, running
from tests.annotation_app.serving.receiver import Receiver, receiving

ONCE = TaskConfig(practice=False)
TWICE = TaskConfig(answers=2, practice=False)
LINKS = "https://study.example.org"


@pytest.fixture
def study() -> StudyConfig:
    """A study in which one person describes, and two segment."""
    tasks = {**STUDY.tasks, "describe": ONCE, "segment": TWICE}
    return msgspec.structs.replace(STUDY, tasks=tasks)


def hook(app: Flask, url: str, **more: Any) -> str:
    allowed = {"allows_private": True, **more}
    check_webhook(url, links_to=LINKS, allows_private=allowed["allows_private"])
    with app.app_context(), transaction(engine_of(app)) as session:
        study = find_study(session, "tests")
        return add_webhook(session, study, url, links_to=LINKS, actor="tests", **allowed).id


def deliver(app: Flask, after_s: float = 0.0) -> Delivered:
    key = installation_of(app).config.secret_key
    return deliver_due(engine_of(app), key, now=time.time() + after_s)


def waiting(app: Flask, state: str = "waiting") -> int:
    counted = select(func.count()).where(WebhookMessage.state == state)
    return row_in(app, counted) or 0


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_finished_items_are_told(app: Flask, receiver: Receiver) -> None:
    Browser(app).do("describe", described())
    name = hook(app, f"{receiver.url}/hook?from=here")
    assert waiting(app) == 0  # only what is finished from now on
    one, other = Browser(app), Browser(app)
    one.do("describe", described())
    item = one.take("segment")["item"]
    one.answer(item, sdcs(ONE))
    assert other.take("segment")["item"] == item
    other.answer(item, sdcs(OTHER))
    Browser(app, "adjudicator").adjudicate(item, sdcs(ONE))
    assert receiver.requests == []  # nothing is sent while people wait
    assert deliver(app) == Delivered(sent=3)
    assert deliver(app) == Delivered()
    told = [body["data"] for body in receiver.bodies]
    assert {body["type"] for body in receiver.bodies} == {"item.finished"}
    assert [(d["study"], d["task"], d["state"]) for d in told] == [
        ("tests", "describe", "answered"),
        ("tests", "segment", "in dispute"),
        ("tests", "segment", "adopted"),
    ]
    assert told[1]["link"] == f"{LINKS}/dashboard/tests/queue/{item}"
    (mine,) = rows_in(app, select(Answer.id).where(Answer.adopted, Answer.task == "segment"))
    assert told[2]["link"] == f"{LINKS}/dashboard/tests/answers/{mine}"
    assert {key for data in told for key in data} == {"study", "item", "task", "state", "link"}
    assert b"tires" not in b"".join(body for _, _, body in receiver.requests)
    # The signature is as https://www.standardwebhooks.com has it.
    key = installation_of(app).config.secret_key
    secret = base64.b64decode(written_secret(key, name).removeprefix("whsec_"))
    for path, headers, body in receiver.requests:
        assert path == "/hook?from=here"
        signed = f"{headers['webhook-id']}.{headers['webhook-timestamp']}.".encode() + body
        expected = base64.b64encode(hmac.new(secret, signed, hashlib.sha256).digest()).decode()
        assert headers["webhook-signature"] == f"v1,{expected}"
        assert abs(int(headers["webhook-timestamp"]) - time.time()) < 60
    assert len(set(receiver.ids)) == 3


def test_answers_are_sent_if_somebody_asks_for_them(app: Flask, receiver: Receiver) -> None:
    hook(app, receiver.url, with_answers=True)
    Browser(app).do("describe", described("Wait for me."))
    other = Browser(app)
    other.do("describe", described("Go away."))
    with transaction(engine_of(app)) as session:
        person = session.get_one(Person, other.person.id)
        erase(session, person, now=time.time())  # before it was sent: it is told no more
    assert deliver(app).sent == 2
    texts = [[a["body"]["text"] for a in body["data"]["answers"]] for body in receiver.bodies]
    assert texts == [["Wait for me."], []]


def test_nothing_is_written_without_a_webhook(app: Flask) -> None:
    Browser(app).do("describe", described())
    assert row_in(app, select(func.count()).select_from(WebhookMessage)) == 0


def test_what_fails_is_sent_again_later_and_later(app: Flask, receiver: Receiver) -> None:
    hook(app, receiver.url)
    Browser(app).do("describe", described())
    receiver.answer = lambda number: (500, 302, 404, 429, 204)[number]
    at, tries = 0.0, 0
    while deliver(app, at) != Delivered(sent=1):
        tries += 1
        assert waiting(app) == 1
        assert deliver(app, at + 0.79 * wait_s(tries)) == Delivered()  # not before its time
        at += 1.21 * wait_s(tries)
    assert tries == 4
    assert [path for path, _, _ in receiver.requests] == ["/"] * 5  # redirects aren't followed
    assert len(set(receiver.ids)) == 1  # whoever gets it twice can tell
    assert waiting(app, "sent") == 1
    assert [round(wait_s(n)) for n in (1, 2, 3, 4, 30)] == [10, 40, 160, 640, 6 * 3600]


def test_it_is_given_up_after_days_and_can_be_tried_again(app: Flask, receiver: Receiver) -> None:
    name = hook(app, receiver.url)
    Browser(app).do("describe", described())
    receiver.answer = lambda _number: 503
    assert deliver(app, GIVE_UP_S + 60) == Delivered(given_up=1)
    assert deliver(app, 2 * GIVE_UP_S) == Delivered()
    with reading(engine_of(app)) as session:
        (state,) = webhook_states(session)
    assert (state.webhook, state.given_up, state.problem) == (name, 1, "status 503")
    receiver.answer = lambda _number: 200
    with transaction(engine_of(app)) as session:
        assert try_again(session, now=time.time(), webhook_id="another") == 0
        assert try_again(session, now=time.time()) == 1
    assert deliver(app) == Delivered(sent=1)


def test_nobody_there(app: Flask) -> None:
    with receiving() as gone:
        hook(app, gone.url)
    Browser(app).do("describe", described())
    assert deliver(app) == Delivered(failed=1)
    with reading(engine_of(app)) as session:
        assert webhook_states(session)[0].problem.startswith("no connection")


def test_private_addresses_need_leave(app: Flask, receiver: Receiver) -> None:
    for url in ("https://localhost/", "https://127.0.0.1:1/", "https://[::1]/", receiver.url, "x"):
        with pytest.raises(Refusal, match=r"private|https|address"):
            hook(app, url, allows_private=False)
    # A name that leads to a private address later is looked at again when something is sent.
    name = hook(app, receiver.url.replace("http:", "https:"))
    with transaction(engine_of(app)) as session:
        session.connection().exec_driver_sql("UPDATE webhook SET allows_private = 0")
    Browser(app).do("describe", described())
    assert deliver(app) == Delivered(failed=1)
    with reading(engine_of(app)) as session:
        assert webhook_states(session)[0].problem == "the address is private"
    assert receiver.requests == []
    with app.app_context(), transaction(engine_of(app)) as session:
        remove_webhook(session, name, actor="tests")
    assert waiting(app) == 0


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_two_processes_send_each_message_once(app: Flask, receiver: Receiver) -> None:
    hook(app, receiver.url)
    one = Browser(app)
    for number in range(3):
        one.do("describe", described(f"Command {number}."))
    receiver.answer = lambda _number: (time.sleep(0.1), 204)[1]
    done: list[Delivered] = []
    threads = [threading.Thread(target=lambda: done.append(deliver(app))) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sum(each.sent for each in done) == 3
    assert len(receiver.ids) == len(set(receiver.ids)) == 3


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_the_last_answers_at_the_same_moment(app: Flask, receiver: Receiver) -> None:
    hook(app, receiver.url)
    author, one, other = Browser(app), Browser(app), Browser(app)
    author.do("describe", described())
    items = [person.take("segment")["item"] for person in (one, other)]
    assert items[0] == items[1]
    threads = [
        threading.Thread(target=person.answer, args=(items[0], sdcs(notation)))
        for person, notation in ((one, ONE), (other, OTHER))
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    deliver(app)
    states = [body["data"]["state"] for body in receiver.bodies]
    assert sorted(states) == ["answered", "in dispute"]


@pytest.mark.slow
def test_a_killed_server_loses_nothing(app: Flask, config: Config, tmp_path: Path) -> None:
    with receiving() as receiver:
        hook(app, receiver.url)
        killed = threading.Event()
        receiver.answer = lambda _number: (killed.wait(60), 204)[1]
        person = Browser(app)
        with running(config, tmp_path) as server:
            client = server.client(person)
            item = client.send("POST", "/api/studies/tests/tasks/describe/lease", {})[1]["item"]
            assert client.answer(item, described(), new_uuid())[0] == 200
            assert receiver.came.acquire(timeout=30)  # it is being sent in the background
            server.end(signal.SIGKILL)
        killed.set()
        # It isn't known whether it arrived. Nobody else tries it before the killed one's time ends.
        assert waiting(app) == 1
        assert deliver(app) == Delivered()
        assert deliver(app, CLAIM_S + 1) == Delivered(sent=1)
        assert len(receiver.ids) == 2
        assert len(set(receiver.ids)) == 1
        # Another server goes on with what comes then.
        with running(config, tmp_path) as server:
            client = server.client(person)
            item = client.send("POST", "/api/studies/tests/tasks/describe/lease", {})[1]["item"]
            assert client.answer(item, described(), new_uuid())[0] == 200
            assert receiver.came.acquire(timeout=30)
            assert receiver.came.acquire(timeout=30)
        deliver(app, CLAIM_S + 1)  # the reply may have come after the server's end
        assert waiting(app, "sent") == 2
        assert len(set(receiver.ids)) == 2
