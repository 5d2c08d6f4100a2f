"""How long sessions hold."""

from __future__ import annotations

from typing import Any

import pytest
from flask import Flask

from tests.annotation_app.browser import Browser
from tests.annotation_app.signing_in import Member, signed_in

HOUR_S = 3600.0
DAY_S = 24 * HOUR_S


def worker(app: Flask) -> Browser:
    person = Browser(app)
    with person.client.session_transaction() as cookie:
        cookie.permanent = True
    return person


def test_who_has_a_login_and_does_nothing_is_signed_out(app: Flask, set_clock: Any) -> None:
    member, person = signed_in(app, "ann", "adjudicator"), worker(app)
    set_clock(11 * HOUR_S)
    assert member.client.get("/dashboard/").status_code == 200  # which makes it hold on
    set_clock(22 * HOUR_S)
    assert member.role == "adjudicator"
    set_clock(24 * HOUR_S)
    assert member.role is None
    assert member.client.get("/dashboard/").location == "/login?next=/dashboard/"
    set_clock(11 * HOUR_S)  # what the browser holds now signs nobody in, whatever the clock says
    assert member.role is None
    set_clock(59 * DAY_S)
    assert person.client.get("/api/session").json["role"] == "worker"
    set_clock(61 * DAY_S)
    assert person.client.get("/api/session").json["role"] is None


def test_a_form_of_somebody_who_was_idle_tells_them_to_sign_in(app: Flask, set_clock: Any) -> None:
    member = signed_in(app, "ann", "admin")
    token = member.client.get("/api/session").json["csrf"]
    set_clock(13 * HOUR_S)
    form = {"csrf_token": token, "role": "annotator"}
    refused = member.client.post("/admin/logins/invite", data=form)
    assert refused.status_code == 401
    assert "/login" in refused.text


def test_who_works_on_one_page_is_not_idle_but_a_page_that_asks_for_numbers_is(
    app: Flask, set_clock: Any
) -> None:
    working, watching = signed_in(app, "ann", "adjudicator"), signed_in(app, "bob", "adjudicator")
    csrf = {"X-CSRFToken": working.client.get("/api/session").json["csrf"]}
    for hour in range(1, 25):
        set_clock(hour * HOUR_S)
        working.client.post("/api/studies/tests/tasks/describe/lease", json={}, headers=csrf)
        watching.client.get("/api/dashboard/studies/tests/progress")
    assert working.role == "adjudicator"
    assert watching.role is None


def test_quick_requests_of_scripts_bring_no_cookie(app: Flask, set_clock: Any) -> None:
    member = signed_in(app, "ann", "annotator")
    csrf = {"X-CSRFToken": member.client.get("/api/session").json["csrf"]}
    lease = "/api/studies/tests/tasks/describe/lease"
    assert "Set-Cookie" not in member.client.post(lease, json={}, headers=csrf).headers
    set_clock(600.0)
    assert "Set-Cookie" in member.client.post(lease, json={}, headers=csrf).headers


@pytest.mark.parametrize("back_s", [5.0, DAY_S, 400 * DAY_S])
def test_a_clock_that_is_set_back_signs_nobody_out(
    app: Flask, set_clock: Any, back_s: float
) -> None:
    person, member = worker(app), signed_in(app, "ann", "admin")
    item = person.take("describe")["item"]
    set_clock(-back_s)
    assert person.draft(item, 1, {"text": "Go"}).status_code == 200
    assert member.post("/admin/logins/invite", role="annotator").status_code == 200


def test_a_cookie_of_before_sessions_were_numbered_holds_for_workers(app: Flask) -> None:
    person = Browser(app)
    with person.client.session_transaction() as cookie:
        assert set(cookie) == {"person", "csrf_token"}  # as older programs made them
    assert person.lease("describe").status_code == 200
    assert Member(app, "nobody").role is None
