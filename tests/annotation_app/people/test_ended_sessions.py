"""A session that has ended is nobody's, whatever is asked for with its cookie."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import pytest
from flask import Flask
from sqlalchemy import Table, event, select
from werkzeug.routing import Rule

from annotation_app.crowds.participation import Offer, sign_offer
from annotation_app.people.accounts import add_login
from annotation_app.people.participants import invitation
from annotation_app.store.database import core, reading, transaction
from annotation_app.store.models import Answer, Base, Media, Person
from annotation_app.work.handing_out import find_study
from tests.annotation_app.browser import Browser, described, engine_of, installation_of, session_of
from tests.annotation_app.signing_in import PASSWORD, Member, signed_in

UUID = "0" * 8 + "-0000-0000-0000-" + "0" * 12
JSON = {
    "draft": {"revision": 1, "body": {"text": "Go"}},
    "answer": {"uuid": UUID, "body": described()},
    "adjudicate": {"uuid": UUID, "body": described()},
    "skip": {"uuid": UUID},
    "flag": {"uuid": UUID},
    "review": {"action": "comment", "text": "Good."},
}
FORM = {
    "role": "annotator",
    "login": "new",
    "current": PASSWORD,
    "password": "another long password",
    "again": "another long password",
    "agree": "on",
}
NOT_TRIED = {"static", "dashboard.static", "making.static", "trying.try_"}
"""Files, and what would start a process when it is allowed."""


@dataclass(frozen=True)
class Request:
    """A request to a route, with names of things that there are."""

    route: str
    method: str
    path: str

    def send(self, app: Flask, cookie: str) -> Any:
        client = app.test_client()
        client.set_cookie("session", cookie)
        name = self.path.rpartition("/")[2]
        if self.path.startswith("/api/"):
            sent: dict[str, Any] = {"json": JSON.get(name, {})}
        else:
            sent = {"data": FORM}
        with client.open(self.path, method=self.method, **sent) as response:
            response.get_data()
            return response


@pytest.fixture
def member(app: Flask) -> Member:
    """Who may do everything, and has an item; forms need no token here."""
    app.config["WTF_CSRF_ENABLED"] = False
    Member(app, "other", "admin")
    found = signed_in(app, "ann", "admin")
    found.agree()
    return found


def requests(app: Flask, member: Member) -> Iterator[Request]:
    """A request to each route with each method."""
    other = Browser(app)
    other.do("describe", described())
    with reading(engine_of(app)) as session:
        study = find_study(session, "tests").id
        media = session.scalars(select(Media.id).where(Media.role == "video")).first()
        answer = session.scalars(select(Answer.id)).first()
    key = installation_of(app).config.secret_key
    values = {
        "study_name": "tests",
        "task_name": "describe",
        "item_id": member.take("describe")["item"],
        "answer_id": answer,
        "media_id": media,
        "person_id": other.person.id,
        "provider_name": "links",
        "form": "jsonl",
        "name": "0" * 24,
        "scenario": "dock_pick_up_tires",
        "file": "tree.svg",
        "step_name": "texts",
        "page": "tasks",
        "number": 0,
    }
    for rule in app.url_map.iter_rules():
        if rule.endpoint in NOT_TRIED:
            continue
        tokens = {
            "entrance.invited": invitation(key, study, "guest"),
            "crowds.enter": sign_offer(key, Offer(study, "describe", 1)),
        }
        known = {**values, "token": tokens.get(rule.endpoint, "token")}
        for method in sorted((rule.methods or set()) - {"HEAD", "OPTIONS"}):
            yield Request(rule.endpoint, method, _path(rule, known))


def _path(rule: Rule, values: dict[str, Any]) -> str:
    return re.sub(r"<(?:\w+:)?(\w+)>", lambda found: str(values[found[1]]), rule.rule)


def rows_of(app: Flask, person_id: str) -> list[tuple[Any, ...]]:
    """Everything in the database that is or names a person."""
    found: list[tuple[Any, ...]] = []
    with reading(engine_of(app)) as session:
        for mapper in Base.registry.mappers:
            table: Table = core(mapper.class_)
            found += [
                (table.name, *map(repr, row))
                for row in session.execute(select(table))
                if person_id in row or "ann" in row
            ]
    return sorted(found)


@pytest.mark.parametrize("ending", ["sign out", "block", "reset", "role", "remove", "password"])
def test_no_route_answers_who_has_been_signed_out(app: Flask, member: Member, ending: str) -> None:
    tried = list(requests(app, member))
    assert {"api.answer", "dashboard.export", "login_admin.invite", "media.media"} <= {
        request.route for request in tried
    }
    old, stranger = session_of(member), "none"
    admin = Member(app, "other")
    assert admin.sign_in().status_code == 303
    path = f"/admin/logins/{member.person.id}"
    if ending == "sign out":
        assert member.post("/logout").status_code == 303
    elif ending == "password":
        elsewhere = Member(app, "ann")
        assert elsewhere.sign_in().status_code == 303
        assert elsewhere.post("/account/password", **FORM).status_code == 303
    else:
        status = 200 if ending == "reset" else 303
        assert admin.post(f"{path}/{ending}", role="adjudicator").status_code == status
    before = rows_of(app, member.person.id)
    for request in tried:
        answered, as_stranger = request.send(app, old), request.send(app, stranger)
        what = f"{request.method} {request.path}"
        ended = answered.status_code, answered.location
        known = as_stranger.status_code, as_stranger.location
        # A browser in which somebody had a login is told to sign in.
        to_sign_in = 302, f"/login?next={request.path}"
        assert ended in (known, to_sign_in), what
        assert re.search(r"\bann\b", answered.text) is None, what
        if request.route == "api.session_":
            assert answered.json["signed_in"] is False
    assert rows_of(app, member.person.id) == before


def test_each_of_these_requests_tells_who_is_signed_in_from_strangers(
    app: Flask, member: Member
) -> None:
    """So that the test above can fail: with a cookie that holds, most routes answer otherwise."""
    cookie = session_of(member)
    same = set()
    for request in requests(app, member):
        if request.route in ("account.logout", "account.change_password"):
            continue
        with transaction(engine_of(app)) as session:
            session.get_one(Person, member.person.id).role = "admin"
        answered, as_stranger = request.send(app, cookie), request.send(app, "none")
        if (answered.status_code, answered.location) == (
            as_stranger.status_code,
            as_stranger.location,
        ):
            same.add(request.route)
    assert same <= {
        "account.login", "account.setup", "account.sign_in_", "account.use_link_",
        "openapi.openapi", "api.session_", "crowds.enter", "crowds.finish", "dashboard.studies",
        "entrance.home", "entrance.offline", "entrance.offline_worker",
        "entrance.invited", "entrance.welcome", "entrance.agree", "tasks.practice_page",
        "trying.file", "trying.tried",
    }  # fmt: skip


def test_who_is_signed_in_is_read_with_what_is_asked_for(app: Flask) -> None:
    """No statement more than before there were numbers of sessions."""
    person = Browser(app)
    item = person.take("describe")["item"]
    statements: list[str] = []
    connections: set[Any] = set()

    def listen(dbapi_connection: Any, *_: Any) -> None:
        if dbapi_connection not in connections:
            connections.add(dbapi_connection)
            dbapi_connection.set_trace_callback(statements.append)

    event.listen(engine_of(app), "checkout", listen)
    assert person.client.get(f"/api/items/{item}").status_code == 200
    about_people = [s for s in statements if re.search(r"\bperson\b", s)]
    assert len(about_people) == 1
    assert "handout" in about_people[0]
    statements.clear()
    assert person.lease("describe").status_code == 200
    about_people = [s for s in statements if s.startswith("SELECT") and "FROM study JOIN" in s]
    assert len(about_people) == 1
    assert "session_number" in about_people[0]
    for connection in connections:
        connection.set_trace_callback(None)


def test_a_worker_who_is_blocked_may_still_send_what_they_have(app: Flask) -> None:
    worker, admin = Browser(app), signed_in(app, "ann", "admin")
    item = worker.take("describe")["item"]
    path = f"/dashboard/tests/people/{worker.person.id}"
    assert admin.post(path, block="yes").status_code == 303
    assert worker.lease("describe").json["reason"] == "blocked"
    assert worker.answer(item, described()).status_code == 200


def test_signing_out_ends_what_a_worker_holds_too(app: Flask) -> None:
    worker = Browser(app)
    cookie = session_of(worker)
    assert worker.client.post("/logout", data={"csrf_token": worker.csrf}).status_code == 303
    thief = app.test_client()
    thief.set_cookie("session", cookie)
    assert thief.get("/api/session").json["signed_in"] is False


def test_somebody_else_cannot_end_sessions_with_an_old_cookie(app: Flask) -> None:
    member = signed_in(app, "ann", "annotator")
    cookie = session_of(member)
    member.post("/logout")
    assert member.sign_in().status_code == 303
    thief = Member(app, "ann")
    thief.client.set_cookie("session", cookie)
    thief.post("/logout")
    assert member.role == "annotator"


def test_a_login_added_by_hand_needs_no_installation(app: Flask) -> None:
    with transaction(engine_of(app)) as session:
        assert add_login(session, "cy", "annotator", actor="tests").session_number == 1
