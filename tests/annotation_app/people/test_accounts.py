"""Logins, roles, links that work once, and the first admin."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace

import pytest
from flask import Flask
from sqlalchemy import func, select, update
from sqlalchemy.orm import Session

from annotation_app.core.config import Config
from annotation_app.core.problems import Refusal
from annotation_app.people import account_links, accounts
from annotation_app.serving.factory import create_app
from annotation_app.serving.server import addresses, make_first_admin
from annotation_app.store.audit import trail
from annotation_app.store.database import reading, transaction
from annotation_app.store.models import AccountLink, Answer, Person, Role
from g3.errors import FormatError
from tests.annotation_app.browser import described, engine_of, installation_of
from tests.annotation_app.signing_in import PASSWORD, Member, signed_in

TESTS = {"actor": "tests"}


@contextmanager
def changing(app: Flask) -> Iterator[Session]:
    with app.app_context(), transaction(engine_of(app)) as session:
        yield session


def test_logins_and_passwords(app: Flask) -> None:
    with changing(app) as session:
        person = accounts.add_login(session, " Ann ", "annotator", PASSWORD, **TESTS)
        assert (person.login, person.role) == ("ann", "annotator")
        assert person.password_hash is not None
        assert person.password_hash.startswith("scrypt:")
        assert accounts.matching(session, "ANN", PASSWORD) is person
        assert accounts.matching(session, "ann", PASSWORD + "x") is None
        assert accounts.matching(session, "bob", PASSWORD) is None
        pending = accounts.add_login(session, "cy", "admin", **TESTS)
        assert pending.password_hash is None
        assert accounts.matching(session, "cy", "") is None
        for login, password in (
            ("ann", PASSWORD),
            ("ANN ", PASSWORD),
            ("bob", "too short"),
            ("bob", "x" * 201),
            ("a-long-login", "A-Long-Login"),
            ("", PASSWORD),
            ("x" * 101, PASSWORD),
            ("a\0b", PASSWORD),
        ):
            with pytest.raises(Refusal):
                accounts.add_login(session, login, "annotator", password, **TESTS)


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_of_two_who_take_a_login_at_once_one_gets_it(app: Flask) -> None:
    def take(_: int) -> bool:
        try:
            with changing(app) as session:
                accounts.add_login(session, "ann", "annotator", PASSWORD, **TESTS)
        except Refusal:
            return False
        return True

    with ThreadPoolExecutor(4) as pool:
        assert sum(pool.map(take, range(4))) == 1


def test_a_login_that_was_removed_leaves_its_answers_and_can_be_given_to_somebody_else(
    app: Flask,
) -> None:
    member = signed_in(app, "ann", "annotator")
    member.agree()
    member.do("describe", described())
    with changing(app) as session:
        person = accounts.required_login(session, "ann")
        accounts.remove(session, person, **TESTS)
    assert member.role is None
    assert member.sign_in().status_code == 422
    again = Member(app, "ann", "adjudicator")
    assert again.person.id != member.person.id
    assert again.sign_in().status_code == 303
    with reading(engine_of(app)) as session:
        assert session.scalars(select(Answer.person_id)).all() == [member.person.id]
        assert session.get_one(Person, member.person.id).role == "worker"


@pytest.mark.parametrize("role", ["annotator", "adjudicator", "admin"])
def test_people_with_a_login_agree_once_before_they_take_part(app: Flask, role: Role) -> None:
    member = signed_in(app, "ann", role)
    for page, asked in (("", ""), ("/describe", "?task=describe")):
        reply = member.client.get(f"/s/tests{page}")
        assert (reply.status_code, reply.location) == (302, f"/s/tests/welcome{asked}")
    assert member.lease("describe").json["reason"] == "no consent"
    assert "You may stop at any time" in member.client.get("/s/tests/welcome").text
    member.agree()
    assert member.role == role
    assert member.lease("describe").status_code == 200
    assert member.client.get("/s/tests").status_code == 200
    again = Member(app, "ann")  # in another browser
    assert again.sign_in().status_code == 303
    assert again.client.get("/s/tests/describe").status_code == 200


def test_the_last_admin_stays(app: Flask) -> None:
    with changing(app) as session:
        ann = accounts.add_login(session, "ann", "admin", PASSWORD, **TESTS)
        pending = accounts.add_login(session, "bob", "admin", **TESTS)  # can't sign in yet
        for change in (
            lambda: accounts.block(session, ann, **TESTS),
            lambda: accounts.remove(session, ann, **TESTS),
            lambda: accounts.change_role(session, ann, "adjudicator", **TESTS),
        ):
            with pytest.raises(Refusal, match="last admin"):
                change()
        accounts.set_password(session, pending, PASSWORD, **TESTS)
        accounts.block(session, ann, **TESTS)
        with pytest.raises(Refusal, match="last admin"):
            accounts.change_role(session, pending, "annotator", **TESTS)


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_two_admins_cannot_block_each_other_at_once(app: Flask) -> None:
    with changing(app) as session:
        ids = [
            accounts.add_login(session, name, "admin", PASSWORD, **TESTS).id
            for name in ("ann", "bob")
        ]

    def block(person_id: str) -> None:
        with changing(app) as session:
            accounts.block(session, session.get_one(Person, person_id), **TESTS)

    with ThreadPoolExecutor(2) as pool:
        results = [pool.submit(block, person_id) for person_id in ids]
    assert sum(isinstance(result.exception(), Refusal) for result in results) == 1
    with reading(engine_of(app)) as session:
        assert accounts.has_admin(session)


def test_an_invitation_works_once(app: Flask) -> None:
    with changing(app) as session:
        token = account_links.invite(session, "adjudicator", actor="ann")
        assert token not in str([vars(link) for link in session.scalars(select(AccountLink))])
    path = account_links.path_of(token)
    guest, late = Member(app, "guest"), Member(app, "late")
    assert "You are invited. Your role: adjudicator." in guest.client.get(path).text
    for wrong, told in (
        ({"login": "guest", "password": PASSWORD, "again": "other"}, "differ"),
        ({"login": "guest", "password": "short", "again": "short"}, "10 to 200"),
        ({"login": "", "password": PASSWORD, "again": PASSWORD}, "1 to 100"),
    ):
        refused = guest.post(path, **wrong)
        assert refused.status_code == 422
        assert told in refused.text
    made = guest.post(path, login="guest", password=PASSWORD, again=PASSWORD)
    assert made.status_code == 303
    assert guest.role == "adjudicator"
    assert late.client.get(path).status_code == 404
    again = late.post(path, login="late", password=PASSWORD, again=PASSWORD)
    assert again.status_code == 404
    assert "has been used" in again.text
    assert late.role is None


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_a_link_that_many_use_at_once_makes_one_login(app: Flask) -> None:
    with changing(app) as session:
        token = account_links.invite(session, "annotator", actor="ann")

    def use(number: int) -> bool:
        try:
            with changing(app) as session:
                account_links.use_link(session, token, f"guest-{number}", PASSWORD)
        except Refusal:
            return False
        return True

    with ThreadPoolExecutor(4) as pool:
        assert sum(pool.map(use, range(4))) == 1
    with reading(engine_of(app)) as session:
        assert len(accounts.accounts(session)) == 1


def test_links_run_out_and_can_be_withdrawn(app: Flask) -> None:
    with changing(app) as session:
        old = account_links.invite(session, "annotator", actor="ann")
        session.execute(update(AccountLink).values(expires_at=1.0))
        assert account_links.open_invitations(session) == []
        with pytest.raises(Refusal):
            account_links.read_link(session, old)
        account_links.invite(session, "annotator", actor="ann")
        (link,) = account_links.open_invitations(session)
        assert session.scalar(select(func.count()).select_from(AccountLink)) == 1
        account_links.withdraw(session, link.digest, actor="ann")
        with pytest.raises(Refusal):
            account_links.withdraw(session, link.digest, actor="ann")
    assert app.test_client().get(account_links.path_of(old)).status_code == 404
    guess = app.test_client().get("/setup/guess")
    assert guess.status_code == 404
    assert "made on the server with: ct annotate people invite --role admin" in guess.text


def test_a_reset_password_stops_working_until_a_new_one_is_set(app: Flask) -> None:
    member = signed_in(app, "ann", "admin")
    with changing(app) as session:
        person = accounts.required_login(session, "ann")
        accounts.reset(session, person, actor="command line")
        first = account_links.password_link(session, person, actor="command line")
        token = account_links.password_link(session, person, actor="command line")
    assert member.role is None
    assert member.sign_in().status_code == 422
    assert member.client.get(account_links.path_of(first)).status_code == 404
    path = account_links.path_of(token)
    assert "ann" in member.client.get(path).text
    new = "another long password"
    assert member.post(path, login="eve", password=new, again=new).status_code == 303
    assert member.role == "admin"
    assert Member(app, "ann").sign_in(new).status_code == 303
    assert Member(app, "eve").sign_in(new).status_code == 422


def test_links_to_the_first_admin_of_several_processes_all_work(app: Flask, config: Config) -> None:
    found = [dict(addresses(config, "https://lab.example.org")) for _ in range(3)]
    what = "make the first admin, once, within a day"
    paths = [one[what].removeprefix("https://lab.example.org") for one in found]
    assert len(set(paths)) == 3
    one = Member(create_app(config, engine_of(app)), "ann")  # another process than printed it
    assert all("The first admin" in one.client.get(path).text for path in paths)
    assert one.post(paths[0], login="ann", password=PASSWORD, again=PASSWORD).status_code == 303
    assert one.role == "admin"
    other = Member(app, "eve")
    for path in paths:
        assert other.client.get(path).status_code == 404
        refused = other.post(path, login="eve", password=PASSWORD, again=PASSWORD)
        assert refused.status_code == 404
    assert what not in dict(addresses(config, ""))
    assert "sign in" in dict(addresses(config, ""))


def test_the_environment_makes_the_first_admin_and_changes_no_other(
    app: Flask, config: Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ANNOTATE_ADMIN_PASSWORD", "short")
    with pytest.raises(FormatError, match="10 to 200") as refused:
        make_first_admin(config)
    assert "ANNOTATE_ADMIN_PASSWORD" in refused.value.where
    monkeypatch.setenv("ANNOTATE_ADMIN_PASSWORD", PASSWORD)
    for _ in range(2):
        make_first_admin(config)
    member = Member(app, "admin")
    assert member.sign_in().status_code == 303
    assert member.role == "admin"
    monkeypatch.setenv("ANNOTATE_ADMIN_PASSWORD", "another long password")
    monkeypatch.setenv("ANNOTATE_ADMIN_LOGIN", "eve")
    make_first_admin(config)
    assert member.sign_in("another long password").status_code == 422
    assert member.sign_in().status_code == 303
    assert Member(app, "eve").sign_in("another long password").status_code == 422


def test_everybody_can_change_their_password(app: Flask) -> None:
    member, elsewhere = signed_in(app, "ann", "annotator"), Member(app, "ann")
    assert elsewhere.sign_in().status_code == 303
    new = "another long password"
    for wrong, told in (
        ({"current": "wrong", "password": new, "again": new}, "isn&#39;t your password"),
        ({"current": PASSWORD, "password": new, "again": new + "x"}, "differ"),
        ({"current": PASSWORD, "password": "short", "again": "short"}, "10 to 200"),
    ):
        refused = member.post("/account/password", **wrong)
        assert refused.status_code == 422
        assert told in refused.text
    changed = member.post("/account/password", current=PASSWORD, password=new, again=new)
    assert changed.status_code == 303
    assert member.role == "annotator"
    assert "Your other sessions have ended" in member.client.get(changed.location).text
    assert elsewhere.role is None
    assert elsewhere.sign_in().status_code == 422
    assert elsewhere.sign_in(new).status_code == 303


def test_what_the_audit_trail_tells(app: Flask) -> None:
    admin = signed_in(app, "ann", "admin")
    member = signed_in(app, "bob", "annotator")
    path = f"/admin/logins/{member.person.id}"
    admin.post(f"{path}/role", role="adjudicator")
    member.sign_in("wrong password")
    member.sign_in("wrong password")
    Member(app, PASSWORD).sign_in()  # somebody typed the password as the login
    member.sign_in()
    member.client.get("/dashboard/tests/export/csv")
    member.post("/logout")
    admin.post(f"{path}/block")
    member.sign_in()
    with reading(engine_of(app)) as session:
        entries = [(e.actor, e.action, e.about, e.details) for e in trail(session)]
        assert PASSWORD not in str(entries)
    assert entries[::-1][3:] == [
        ("bob", "signed in", "", {}),
        ("ann", "role changed", "bob", {"role": "adjudicator", "before": "annotator"}),
        ("bob", "sign-in refused", "", {"reason": "wrong password"}),
        ("bob", "sign-in refused", "", {"reason": "wrong password"}),
        ("somebody", "sign-in refused", "", {"reason": "wrong password"}),
        ("bob", "signed in", "", {}),
        ("bob", "exported", "tests", {"format": "csv"}),
        ("bob", "signed out", "", {}),
        ("ann", "blocked", "bob", {}),
        ("bob", "sign-in refused", "", {"reason": "blocked"}),
    ]


def test_who_lost_the_cookie_is_told_to_sign_in_only_if_they_have_a_login(app: Flask) -> None:
    stranger = app.test_client()
    csrf = {"X-CSRFToken": stranger.get("/api/session").json["csrf"]}
    lease = "/api/studies/tests/tasks/describe/lease"
    told = stranger.post(lease, json={}, headers=csrf).json["error"]
    assert "Open the study's address again" in told
    assert "sign in" not in told.casefold()
    page = stranger.get("/media/none")
    assert page.status_code == 401
    assert "/login" not in page.text
    for path in ("/account", "/dashboard/", "/admin/logins", "/admin/audit"):
        assert stranger.get(path).location == f"/login?next={path}"
    member = signed_in(app, "ann", "annotator")
    with changing(app) as session:
        accounts.block(session, accounts.required_login(session, "ann"), **TESTS)
    assert member.client.get("/s/tests").location == "/login?next=/s/tests"
    assert "Sign in" in member.lease("describe").json["error"]
    assert "You were signed out" in member.client.get("/login").text
    member.post("/logout")  # use the browser without a login
    assert member.client.get("/s/tests").location == "/s/tests/welcome"


def test_limits_of_signing_in_count_by_address_whatever_cookie_comes(app: Flask) -> None:
    config = replace(installation_of(app).config, rate_limits=True)
    limited = create_app(config, engine_of(app))
    codes = [Member(limited, "nobody").sign_in().status_code for _ in range(65)]
    assert codes[-1] == 429
    create_app(installation_of(app).config, engine_of(app))
