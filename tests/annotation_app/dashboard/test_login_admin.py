"""The pages on which admins manage logins and read the audit trail."""

from __future__ import annotations

import re
from typing import Any

import pytest
from flask import Flask

from annotation_app.store.audit import note
from annotation_app.store.database import transaction
from annotation_app.store.models import Role
from tests.annotation_app.browser import Browser, described, engine_of
from tests.annotation_app.signing_in import PASSWORD, Member, link_in, signed_in

LOGINS = "/admin/logins"


@pytest.fixture
def admin(app: Flask) -> Member:
    return signed_in(app, "boss", "admin")


def text_of(response: Any) -> str:
    return re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", response.text))


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_inviting_and_adding(app: Flask, admin: Member) -> None:
    invited = admin.post(f"{LOGINS}/invite", role="adjudicator")
    assert invited.status_code == 200
    assert "Invitations nobody has used yet" in admin.client.get(LOGINS).text
    guest = Member(app, "Bea")
    path = link_in(invited.text)
    assert guest.post(path, login="Bea", password=PASSWORD, again=PASSWORD).status_code == 303
    assert guest.role == "adjudicator"
    added = admin.post(f"{LOGINS}/add", role="annotator", login="cy")
    other = Member(app, "cy")
    path = link_in(added.text)
    assert "cy annotator, no password yet never signed in" in text_of(admin.client.get(LOGINS))
    assert other.post(path, password=PASSWORD, again=PASSWORD).status_code == 303
    assert other.role == "annotator"
    told = text_of(admin.client.get(LOGINS))
    assert "bea adjudicator signed in 20" in told
    assert "cy annotator signed in 20" in told
    assert "Invitations nobody has used yet" not in told


@pytest.mark.parametrize(
    ("path", "form", "status", "told"),
    [
        ("add", {"login": "boss", "role": "annotator"}, 422, "This login is taken"),
        ("add", {"login": "new", "role": "worker"}, 422, "Choose a role"),
        ("add", {"login": "<b>\0", "role": "annotator"}, 422, "1 to 100 characters"),
        ("nobody/block", {}, 404, "There is no such login"),
        ("../invitations/withdraw", {"invitation": "x"}, 404, "has been used or has run out"),
    ],
)
def test_mistakes(admin: Member, path: str, form: dict[str, str], status: int, told: str) -> None:
    path = "/admin/invitations/withdraw" if path.startswith("..") else f"{LOGINS}/{path}"
    response = admin.post(path, **form)
    assert response.status_code == status
    assert told in response.text
    assert "<b>" not in response.text


def test_an_invitation_is_withdrawn(app: Flask, admin: Member) -> None:
    link = link_in(admin.post(f"{LOGINS}/invite", role="admin").text)
    found = re.search(r'name="invitation" value="(\w+)"', admin.client.get(LOGINS).text)
    assert found is not None
    assert admin.post("/admin/invitations/withdraw", invitation=found[1]).status_code == 303
    assert app.test_client().get(link).status_code == 404


def test_changing_somebody(app: Flask, admin: Member) -> None:
    member = signed_in(app, "ann", "annotator")
    path = f"{LOGINS}/{member.person.id}"
    assert admin.post(f"{path}/role", role="adjudicator").status_code == 303
    assert member.role is None
    member.sign_in()
    assert member.role == "adjudicator"
    assert admin.post(f"{path}/block").status_code == 303
    assert member.role is None
    assert "ann adjudicator, blocked" in text_of(admin.client.get(LOGINS))
    assert admin.post(f"{path}/unblock").status_code == 303
    assert member.sign_in().status_code == 303
    link = link_in(admin.post(f"{path}/reset").text)
    assert member.role is None
    assert member.post(link, password=PASSWORD, again=PASSWORD).status_code == 303
    assert "can’t be undone" in admin.client.get(f"{path}/remove").text
    assert member.role == "adjudicator"  # to look at the question changes nothing
    assert admin.post(f"{path}/remove").status_code == 303
    assert member.role is None
    assert admin.client.get(path).status_code == 404
    assert re.search(r"\bann\b", text_of(admin.client.get(LOGINS))) is None


def test_nobody_changes_their_own_login_here(app: Flask, admin: Member) -> None:
    signed_in(app, "other", "admin")
    path = f"{LOGINS}/{admin.person.id}"
    assert "Another admin can change the rest" in admin.client.get(path).text
    for what in ("role", "block", "unblock", "reset", "remove"):
        refused = admin.post(f"{path}/{what}", role="annotator")
        assert refused.status_code == 422
        assert "This is your own login" in refused.text
    assert admin.role == "admin"


def test_the_last_admin_cannot_be_blocked_on_a_studys_page(app: Flask, admin: Member) -> None:
    refused = admin.post(f"/dashboard/tests/people/{admin.person.id}", block="yes")
    assert refused.status_code == 422
    assert "last admin" in refused.text
    assert admin.role == "admin"


@pytest.mark.parametrize("role", ["worker", "annotator", "adjudicator"])
def test_only_admins_get_in(app: Flask, role: Role, admin: Member) -> None:
    browser = Browser(app, role)
    path = f"{LOGINS}/{admin.person.id}"
    for page in (LOGINS, path, f"{path}/remove", "/admin/audit"):
        assert browser.client.get(page).status_code == 403
    form = {"csrf_token": browser.csrf, "role": "admin", "login": "eve"}
    for action in (
        *(f"{path}/{what}" for what in ("role", "block", "unblock", "reset", "remove")),
        f"{LOGINS}/invite",
        f"{LOGINS}/add",
        "/admin/invitations/withdraw",
    ):
        assert browser.client.post(action, data=form).status_code == 403
        assert app.test_client().post(action).status_code == 400  # without the token
    assert admin.role == "admin"


def test_blocking_a_worker_is_noted(app: Flask, admin: Member) -> None:
    worker = Browser(app)
    worker.do("describe", described())
    admin.post(f"/dashboard/tests/people/{worker.person.id}", block="yes")
    subject = worker.person.external_hash[:12]
    assert f"boss blocked {subject}" in text_of(admin.client.get("/admin/audit"))


def test_the_audit_trail_is_paged_and_filtered(app: Flask, admin: Member) -> None:
    with transaction(engine_of(app)) as session:
        for number in range(120):
            note(
                session, "ann" if number % 2 else "bob", "exported", f"study-{number}", format="<i>"
            )
    first = admin.client.get("/admin/audit").text
    assert "study-119" in first
    assert "study-69" not in first
    assert "<i>" not in first
    seen, page = [], "/admin/audit?person=ann&action=exported"
    while True:
        found = admin.client.get(page).text
        seen += re.findall(r"study-(\d+)", found)
        older = re.search(r'href="(/admin/audit\?[^"]*before=[^"]*)"', found)
        if older is None:
            break
        page = older[1].replace("&amp;", "&")
    assert seen == [str(number) for number in range(119, 0, -2)]
    assert "Nothing like this" in admin.client.get("/admin/audit?person=eve").text
    for odd in ("before=x", "before=²", f"before={'9' * 400}", "person=%00", "action=%00"):
        assert admin.client.get(f"/admin/audit?{odd}").status_code == 200
