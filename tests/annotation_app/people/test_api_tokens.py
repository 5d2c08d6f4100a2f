"""Tokens by which programs read: made, listed, revoked, and what they may."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import pytest
from flask import Flask
from sqlalchemy import inspect, select, update

from annotation_app.people.api_tokens import PREFIX, make_token
from annotation_app.serving.factory import create_app
from annotation_app.store.database import reading, transaction
from annotation_app.store.models import ApiToken, AuditEntry
from tests.annotation_app.browser import Browser, described, engine_of, execute, installation_of
from tests.annotation_app.signing_in import signed_in

API = "/api/dashboard/studies"


def made(app: Flask, name: str = "report", days: float = 30) -> str:
    with app.app_context(), transaction(engine_of(app)) as session:
        return make_token(session, name, days, actor="tests")


def get(app: Flask, path: str, token: str, **more: Any) -> Any:
    headers = {"Authorization": f"Bearer {token}"}
    return app.test_client().open(path, method=more.pop("method", "GET"), headers=headers, **more)


@pytest.mark.parametrize("kind", ["sqlite", "postgresql"])
def test_a_program_reads_numbers_and_answers(app: Flask) -> None:
    Browser(app).do("describe", described())
    token = made(app)
    assert get(app, API, token).json == {"studies": ["tests"]}
    views = ("progress", "videos", "times", "corpus", "agreement", "people", "queue")
    for view in (*views, "disagreements", "reports"):
        assert get(app, f"{API}/tests/{view}", token).status_code == 200, view
    (answer,) = get(app, f"{API}/tests/answers", token).json["data"]
    assert answer["body"]["text"] == described()["text"]
    assert get(app, f"{API}/tests/answers/{answer['answer']}", token).status_code == 200
    exported = get(app, f"{API}/tests/export/csv", token)
    assert described()["text"] in exported.text
    assert get(app, f"{API}/tests/export/nothing", token).status_code == 404


def test_it_changes_nothing_and_opens_no_page(app: Flask) -> None:
    Browser(app).do("describe", described())
    token = made(app)
    (answer,) = get(app, f"{API}/tests/answers", token).json["data"]
    path = f"{API}/tests/answers/{answer['answer']}/review"
    sent = {"action": "exclude", "text": "no"}
    assert get(app, path, token, method="POST", json=sent).status_code in (400, 401)
    assert get(app, f"{API}/tests/answers", token).json["data"][0]["states"] != ["excluded"]
    for page in ("/dashboard/tests", "/admin/tokens", "/admin/audit"):
        assert get(app, page, token).status_code == 302
    assert get(app, "/api/items/x/answers", token).status_code == 401


def test_wrong_tokens_read_nothing(app: Flask) -> None:
    token = made(app)
    assert token.startswith(PREFIX)
    execute(app, update(ApiToken).values(expires_at=1.0))
    for wrong in (token, "", "x" * 5000, f"{PREFIX}é", token.upper()):
        reply = get(app, f"{API}/tests/progress", wrong.encode().decode("latin-1"))
        assert reply.status_code == 401
        assert "token" in reply.json["error"]
    # A cookie doesn't help a program whose token is wrong.
    admin = Browser(app, "admin")
    headers = {"Authorization": "Bearer nothing"}
    assert admin.client.get(API, headers=headers).status_code == 401
    assert admin.client.get(API).status_code == 200


def test_only_a_digest_is_kept(app: Flask) -> None:
    token = made(app)
    with reading(engine_of(app)) as session:
        for table in inspect(session.connection()).get_table_names():
            rows = session.connection().exec_driver_sql(f'SELECT * FROM "{table}"').all()
            assert not [row for row in rows if token in repr(row) or token[8:] in repr(row)], table


def test_the_audit_trail_names_programs(app: Flask) -> None:
    token = made(app)
    for _ in range(3):
        get(app, f"{API}/tests/progress", token)
    get(app, f"{API}/tests/export/jsonl", token)
    with reading(engine_of(app)) as session:
        rows = session.execute(
            select(AuditEntry.actor, AuditEntry.action, AuditEntry.about).order_by(AuditEntry.id)
        ).all()
        (found,) = session.scalars(select(ApiToken))
    assert [tuple(row) for row in rows] == [
        ("tests", "made a token", "report"),
        ("token report", "read with a token", ""),  # once an hour
        ("token report", "exported", "tests"),
    ]
    assert found.used_at is not None


def test_reading_is_counted(app: Flask) -> None:
    of_app = installation_of(app)
    counted = create_app(replace(of_app.config, rate_limits=True), of_app.engine)
    token = made(counted)
    statuses = [get(counted, API, token).status_code for _ in range(601)]
    assert statuses.count(200) == 600
    assert statuses[-1] == 429
    # One program's reading doesn't stop another one's.
    assert get(counted, API, made(counted, "other")).status_code == 200
    wrong = [get(counted, API, f"wrong{i}").status_code for i in range(61)]
    assert (wrong.count(401), wrong[-1]) == (60, 429)


def test_the_pages_of_tokens(app: Flask) -> None:
    admin = signed_in(app, "ada", "admin")
    assert "There are no tokens." in admin.client.get("/admin/tokens").text
    for name, days in (("a b", "9"), ("", "9"), ("x" * 61, "9"), ("good", "0"), ("good", "many")):
        refused = admin.post("/admin/tokens", name=name, days=days)
        assert refused.status_code == 422, (name, days)
        assert 'role="alert"' in refused.text
    shown = admin.post("/admin/tokens", name="notebook", days="30")
    found = re.search(rf'value="({PREFIX}[\w-]+)"', shown.text)
    assert found is not None
    listed = admin.client.get("/admin/tokens").text
    assert "notebook" in listed
    assert found[1] not in listed
    assert admin.post("/admin/tokens", name="notebook", days="30").status_code == 422
    assert get(app, API, found[1]).status_code == 200
    assert "used 20" in admin.client.get("/admin/tokens").text
    # Revoking asks first.
    path = "/admin/tokens/revoke"
    assert "Revoke notebook?" in admin.client.get(f"{path}?name=notebook").text
    assert get(app, API, found[1]).status_code == 200
    assert admin.post(path, name="notebook").status_code == 303
    assert get(app, API, found[1]).status_code == 401
    assert admin.client.get(f"{path}?name=notebook").status_code == 404
    assert admin.post(path, name="notebook").status_code == 404


def test_tokens_are_for_admins(app: Flask) -> None:
    judge = signed_in(app, "judy", "adjudicator")
    assert judge.client.get("/admin/tokens").status_code == 403
    assert judge.post("/admin/tokens", name="mine", days="3").status_code == 403
    assert judge.post("/admin/tokens/revoke", name="mine").status_code == 403
    assert app.test_client().get("/admin/tokens").status_code == 302
