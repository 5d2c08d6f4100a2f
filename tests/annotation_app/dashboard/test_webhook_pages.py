"""The pages on which admins see what became of webhooks' messages."""

from __future__ import annotations

import html
import re
import time

import msgspec
import pytest
from flask import Flask
from playwright.sync_api import BrowserContext, expect

from annotation_app.core import posting
from annotation_app.serving.webhook_delivery import GIVE_UP_S, deliver_due
from annotation_app.store.database import reading, transaction
from annotation_app.store.models import Role
from annotation_app.studies.study_file import StudyConfig, TaskConfig
from annotation_app.work.handing_out import find_study
from annotation_app.work.webhooks import add_webhook, webhook_states, written_secret
from tests.annotation_app.browser import Browser, described, engine_of, installation_of
from tests.annotation_app.conftest import STUDY
from tests.annotation_app.in_browser import errors_of, look, sign_in
from tests.annotation_app.serving.receiver import Receiver
from tests.annotation_app.signing_in import Member, signed_in

HOOKS = "/admin/webhooks"


@pytest.fixture
def study() -> StudyConfig:
    """A study in which one description finishes an item."""
    once = TaskConfig(practice=False)
    return msgspec.structs.replace(STUDY, tasks={**STUDY.tasks, "describe": once})


@pytest.fixture
def admin(app: Flask) -> Member:
    return signed_in(app, "ada", "admin")


def hook(app: Flask, url: str) -> str:
    with app.app_context(), transaction(engine_of(app)) as session:
        study, page = find_study(session, "tests"), "https://study.example.org"
        added = add_webhook(session, study, url, links_to=page, allows_private=True, actor="ada")
        return added.id


def said(page: str) -> str:
    return re.sub(r"\s+", " ", html.unescape(re.sub(r"<[^>]+>", " ", page)))


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_what_became_of_messages(app: Flask, admin: Member, receiver: Receiver) -> None:
    page = f"{HOOKS}/{hook(app, receiver.url)}"
    assert "No item has been finished" in said(admin.client.get(page).text)
    Browser(app).do("describe", described())
    assert "describe, answered: waiting not tried yet" in said(admin.client.get(page).text)
    receiver.answer = lambda _number: 503
    key = installation_of(app).config.secret_key
    deliver_due(engine_of(app), key, now=time.time() + GIVE_UP_S + 60)
    told = said(admin.client.get(page).text)
    assert "given up tried 1 time; status 503" in told
    assert "Last failure: status 503 ." in told
    assert "status 503" in admin.client.get(HOOKS).text
    receiver.answer = lambda _number: 204
    assert admin.post(f"{page}/again").status_code == 303
    assert deliver_due(engine_of(app), key, now=time.time()).sent == 1
    told = said(admin.client.get(page).text)
    assert "sent tried 2 times" in told
    assert "Nothing failed." in told
    assert "ada sent messages again tests" in said(admin.client.get("/admin/audit").text)


def test_a_test_says_whether_it_arrived(app: Flask, admin: Member, receiver: Receiver) -> None:
    name = hook(app, receiver.url)
    assert "The test arrived." in admin.post(f"{HOOKS}/{name}/test").text
    ((_, headers, body),) = receiver.requests
    assert msgspec.json.decode(body)["type"] == "test"
    assert msgspec.json.decode(body)["data"] == {"study": "tests"}
    assert headers["webhook-signature"].startswith("v1,")
    receiver.answer = lambda _number: 500
    assert "The test didn’t arrive: status 500." in admin.post(f"{HOOKS}/{name}/test").text
    assert len(receiver.requests) == 2  # it isn't tried again
    assert "ada tested a webhook tests" in said(admin.client.get("/admin/audit").text)


def test_adding_and_removing(
    app: Flask, admin: Member, monkeypatch: pytest.MonkeyPatch, receiver: Receiver
) -> None:
    monkeypatch.setattr(
        posting.socket, "getaddrinfo", lambda *_, **__: [(0, 0, 0, "", ("8.8.8.8",))]
    )
    url = "https://lab.example.org/hook?a=<b>"
    added = admin.post(HOOKS, study="tests", url=url, with_answers="on")
    with reading(engine_of(app)) as session:
        (state,) = webhook_states(session)
    assert (state.url, state.with_answers, state.allows_private) == (url, True, False)
    secret = written_secret(installation_of(app).config.secret_key, state.webhook)
    assert f'value="{secret}"' in added.text
    for page in (HOOKS, f"{HOOKS}/{state.webhook}"):
        assert secret not in admin.client.get(page).text
        assert "a=&lt;b&gt;" in admin.client.get(page).text
    monkeypatch.undo()
    for wrong in (receiver.url, "https://127.0.0.1/", "no address", "https://x.org/" + "y" * 2000):
        refused = admin.post(HOOKS, study="tests", url=wrong)
        assert refused.status_code == 422, wrong
        assert 'role="alert"' in refused.text
    assert admin.post(HOOKS, study="nothing", url=url).status_code == 404
    assert "Remove the webhook" in admin.client.get(f"{HOOKS}/{state.webhook}/remove").text
    assert admin.post(f"{HOOKS}/{state.webhook}/remove").status_code == 303
    assert "There are no webhooks." in admin.client.get(HOOKS).text
    for what in ("", "/remove"):
        assert admin.client.get(f"{HOOKS}/{state.webhook}{what}").status_code == 404
    for what in ("test", "again", "remove"):
        assert admin.post(f"{HOOKS}/{state.webhook}/{what}").status_code == 404


@pytest.mark.parametrize("role", ["worker", "annotator", "adjudicator"])
def test_only_admins_get_in(app: Flask, role: Role, receiver: Receiver) -> None:
    person, page = Browser(app, role), f"{HOOKS}/{hook(app, receiver.url)}"
    for path in (HOOKS, page, f"{page}/remove"):
        assert person.client.get(path).status_code == 403
    form = {"csrf_token": person.csrf, "study": "tests", "url": receiver.url}
    for path in (HOOKS, *(f"{page}/{what}" for what in ("test", "again", "remove"))):
        assert person.client.post(path, data=form).status_code == 403
        assert app.test_client().post(path).status_code == 400  # without the token
    assert receiver.requests == []
    assert "lab.example" not in person.client.get("/dashboard/").text


@pytest.mark.slow
def test_an_admin_tests_a_webhook_in_a_browser(
    app: Flask, address: str, admin: Member, context: BrowserContext, receiver: Receiver
) -> None:
    hook(app, f"{receiver.url}/a-long-address-of-somebodys-program/that/is-hardly-ever/cut?x=yes")
    Browser(app).do("describe", described())
    sign_in(context, admin, address)
    page = context.new_page()
    errors = errors_of(page)
    page.goto(f"{address}/dashboard/")
    page.get_by_role("link", name="Webhooks").click()
    found = look(page, "webhooks")
    page.get_by_role("link", name=re.compile("a-long-address")).click()
    found += look(page, "webhook")
    page.get_by_role("button", name="Send a test").click()
    expect(page.get_by_role("status")).to_have_text("The test arrived.")
    found += look(page, "webhook-tested")
    page.get_by_role("link", name="Remove…").click()
    found += look(page, "webhook-remove")
    page.get_by_role("button", name="Remove the webhook").click()
    expect(page.get_by_text("There are no webhooks.")).to_be_visible()
    assert found == []
    assert errors == []
    assert len(receiver.requests) == 1
