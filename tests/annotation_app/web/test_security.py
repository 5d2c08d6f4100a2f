"""What people can't do, and what nobody is told."""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest
from flask import Flask
from sqlalchemy import select

from annotation_app.core.config import DATABASE_FILE, open_instance
from annotation_app.core.key_file import KEY_FILE
from annotation_app.core.problems import Refusal
from annotation_app.people.participants import accept_invitation, find_or_add, invitation
from annotation_app.serving.factory import create_app
from annotation_app.store.database import opened, reading, transaction
from annotation_app.store.models import Media, Person, Study
from annotation_app.work.handing_out import find_study
from tests.annotation_app.browser import Browser, described, engine_of, installation_of
from tests.annotation_app.rendered import VIDEOS, WORDS

SHOWN = ("tire", "truck", "pallet", "boxes", "yard", "dock", "load", "fetch")
"""What videos show and forklifts do; a forklift it is that people are told about."""


def test_the_key_is_its_owners_alone(tmp_path: Path) -> None:
    config = open_instance(tmp_path / "new")
    key = tmp_path / "new" / "secret-key"
    assert stat.S_IMODE(key.stat().st_mode) == 0o600
    assert stat.S_IMODE(key.parent.stat().st_mode) == 0o700
    assert open_instance(tmp_path / "new").secret_key == config.secret_key
    assert config.secret_key.decode() not in repr(config)


def test_files_are_their_owners_alone_in_a_folder_that_all_may_read(tmp_path: Path) -> None:
    tmp_path.chmod(0o755)
    previous = os.umask(0)
    try:
        config = open_instance(tmp_path)
        with opened(config.database) as engine, transaction(engine) as session:
            session.connection().exec_driver_sql("CREATE TABLE salts (salt TEXT)")
            modes = {path.name: stat.S_IMODE(path.stat().st_mode) for path in tmp_path.iterdir()}
    finally:
        os.umask(previous)
    beside = ("", "-wal", "-shm", "-turn")
    assert modes == dict.fromkeys((KEY_FILE, *(DATABASE_FILE + end for end in beside)), 0o600)


def test_headers(app: Flask) -> None:
    for path in ("/api/session", "/api/items/none", "/nowhere", "/media/none"):
        headers = app.test_client().get(path).headers
        policy = headers["Content-Security-Policy"]
        assert "unsafe" not in policy
        assert "frame-ancestors 'none'" in policy
        assert headers["X-Content-Type-Options"] == "nosniff"
        assert headers["Referrer-Policy"] == "no-referrer"


def test_cookies(app: Flask) -> None:
    config = installation_of(app).config
    cookie = app.test_client().get("/api/session").headers["Set-Cookie"]
    assert "HttpOnly" in cookie
    assert "SameSite=Lax" in cookie
    framed = replace(config, https=True, frame_ancestors=("https://crowd.example",))
    response = create_app(framed, engine_of(app)).test_client().get("/api/session")
    cookie = response.headers["Set-Cookie"]
    assert all(word in cookie for word in ("Secure", "SameSite=None", "Partitioned"))
    policy = response.headers["Content-Security-Policy"]
    assert "frame-ancestors https://crowd.example" in policy


def test_pages_make_the_cookie_hold_longer_and_scripts_do_not(app: Flask) -> None:
    person = Browser(app)
    with person.client.session_transaction() as cookie:
        cookie.permanent = True
    assert "Set-Cookie" not in person.client.get("/api/session").headers
    assert "Set-Cookie" not in person.lease("describe").headers
    assert "Expires=" in person.client.get("/s/tests").headers["Set-Cookie"]


def test_changes_need_the_token(app: Flask) -> None:
    person = Browser(app)
    item = person.take("describe")["item"]
    person.csrf = "wrong"
    assert person.answer(item, described()).status_code == 400
    assert person.draft(item, 1, {}).status_code == 400


def test_changes_need_a_person(app: Flask) -> None:
    stranger = Browser(app)
    stranger.client.delete_cookie("session")
    stranger.csrf = stranger.client.get("/api/session").json["csrf"]
    response = stranger.lease("describe")
    assert response.status_code == 401
    assert "Open the study's address again" in response.json["error"]


def test_a_forged_cookie_is_nobody(app: Flask) -> None:
    client = app.test_client()
    client.set_cookie("session", "eyJwZXJzb24iOiJ4In0.aaaaaa.bbbbbbbbbbbbbbbbbbbbbbbbbbb")
    assert client.get("/api/session").json["signed_in"] is False


def test_only_adjudicators_see_others_answers(app: Flask) -> None:
    worker = Browser(app)
    item = worker.take("describe")["item"]
    worker.answer(item, described())
    assert worker.client.get(f"/api/items/{item}/answers").status_code == 403
    assert worker.adjudicate(item, described()).status_code == 403
    adjudicator = Browser(app, "adjudicator")
    found = adjudicator.client.get(f"/api/items/{item}/answers").json
    assert [a["body"]["text"] for a in found["answers"]] == [described()["text"]]


def test_who_is_blocked_while_signed_in_sees_nothing_more(app: Flask) -> None:
    item = Browser(app).take("describe")["item"]
    adjudicator = Browser(app, "adjudicator")
    paths = (f"/api/items/{item}/answers", "/api/dashboard/studies", "/dashboard/")
    assert [adjudicator.client.get(path).status_code for path in paths] == [200, 200, 200]
    with transaction(engine_of(app)) as session:
        session.get_one(Person, adjudicator.person.id).blocked_at = 1.0
    assert [adjudicator.client.get(path).status_code for path in paths] == [403, 403, 403]


def names(words: Sequence[str], told: str) -> list[str]:
    """Words that something begins with."""
    return [word for word in words if re.search(rf"(?<![a-z]){word}", told, re.IGNORECASE)]


def test_nothing_of_describe_names_what_the_video_shows(app: Flask) -> None:
    """As people get it: headers, source, data and names of files."""
    person = Browser(app)
    lease = person.lease("describe")
    media = [f"/media/{lease.json['payload'][role]}" for role in ("video", "poster")]
    told = {"lease": f"{lease.headers} {lease.text}"}
    for path in ("/s/tests/describe", "/api/openapi.json", *media):
        response = person.client.get(path, buffered=True)
        assert response.status_code == 200, path
        told[path] = f"{path} {response.headers}"
        if path not in media:
            told[path] += response.text
    assert [names(WORDS, told[path]) for path in ("lease", *media)] == [[], [], []]
    videos = [name.replace("_", "[-_ ]") for name in VIDEOS]
    for path, text in told.items():
        words = "|".join(
            (*videos, "tires-1", "boxes-1", r"log\.mcap", r"video\.mp4", "manifest.json")
        )
        assert not re.search(words, text, re.IGNORECASE), path
    page = told["/s/tests/describe"]
    assert "video" in page
    assert names(SHOWN, page) == []


def test_nothing_that_was_sent_is_in_a_log(app: Flask, caplog: pytest.LogCaptureFixture) -> None:
    person = Browser(app)
    item = person.take("describe")["item"]
    with engine_of(app).begin() as connection:
        connection.exec_driver_sql("DROP TABLE draft")
    response = person.draft(item, 1, {"text": "my own words"})
    assert response.status_code == 500
    assert "Nothing that you typed is lost" in response.json["error"]
    assert "draft" in caplog.text
    assert "my own words" not in caplog.text
    assert person.person.id not in caplog.text
    assert installation_of(app).config.secret_key.decode() not in caplog.text


def test_media(app: Flask) -> None:
    person = Browser(app)
    name = person.take("describe")["payload"]["video"]
    whole = person.client.get(f"/media/{name}", buffered=True)
    part = person.client.get(f"/media/{name}", headers={"Range": "bytes=2-5"}, buffered=True)
    assert (part.status_code, part.data) == (206, whole.data[2:6])
    assert "Content-Disposition" not in whole.headers
    assert app.test_client().get(f"/media/{name}").status_code == 401
    with reading(engine_of(app)) as session:
        manifest = session.scalars(select(Media.id).where(Media.role == "manifest")).first()
    for path in (manifest, "../secret-key", "..%2fsecret-key", "%2e%2e/%2e%2e/etc/passwd"):
        assert person.client.get(f"/media/{path}").status_code == 404


def test_a_film_opens_for_who_takes_part_in_its_study(app: Flask) -> None:
    """And for staff; it doesn't for a worker of another study, who knows its name."""
    name = Browser(app).take("describe")["payload"]["video"]
    address = f"/media/{name}"
    with transaction(engine_of(app)) as session:
        own = session.get_one(Media, name)
        here = session.get_one(Study, own.study_id)
        other = Study(id="other", name="other", config=here.config, created_at=0.0)
        session.add(other)
    assert Browser(app, study="tests").client.get(address, buffered=True).status_code == 200
    assert Browser(app, study="other").client.get(address, buffered=True).status_code == 404
    assert Browser(app, study=None).client.get(address, buffered=True).status_code == 404
    for role in ("annotator", "adjudicator", "admin"):
        assert Browser(app, role, study=None).client.get(address, buffered=True).status_code == 200


def test_an_invitation_to_one_study_is_none_to_another(app: Flask) -> None:
    with transaction(engine_of(app)) as session:
        here = find_study(session, "tests")
        invited = {**here.config, "access": "invited"}
        for name in ("one", "other"):
            session.add(Study(id=name, name=name, config=invited, created_at=0.0))
    key = installation_of(app).config.secret_key
    client = app.test_client()
    reply = client.get(f"/s/one/invitation/{invitation(key, 'one', 'guest')}")
    assert reply.status_code == 302
    csrf = client.get("/api/session").json["csrf"]

    def agrees(study: str) -> bool:
        form = {"csrf_token": csrf, "agree": "on"}
        return bool(client.post(f"/s/{study}/welcome", data=form).status_code == 303)

    assert not agrees("other")
    assert agrees("one")
    assert not agrees("other")
    assert client.get("/s/one").status_code == 200
    assert "other" not in client.get("/").text


def test_too_much_is_refused(app: Flask) -> None:
    person = Browser(app)
    item = person.take("describe")["item"]
    response = person.draft(item, 1, {"text": "x" * 2_000_000})
    assert response.status_code == 413
    assert "too large" in response.json["error"]


def test_requests_are_limited(app: Flask) -> None:
    config = replace(installation_of(app).config, rate_limits=True)
    limited = create_app(config, engine_of(app))
    person = Browser(limited)
    item = person.take("describe")["item"]
    codes = [person.draft(item, i, {}).status_code for i in range(250)]
    assert codes[0] == 200
    assert codes[-1] == 429
    assert "Wait a minute" in person.draft(item, 999, {}).json["error"]
    app.test_client()  # the limiter is one for all apps of a process
    create_app(installation_of(app).config, engine_of(app))


def test_ids_are_hashed_with_the_installations_salt(app: Flask) -> None:
    with app.app_context(), transaction(engine_of(app)) as session:
        person = find_or_add(session, "prolific", "worker-one")
        assert find_or_add(session, "prolific", "worker-one").id == person.id
        assert find_or_add(session, "mturk", "worker-one").id != person.id
        assert "worker-one" not in str(vars(person))


def test_invitations(app: Flask) -> None:
    config = installation_of(app).config
    token = invitation(config.secret_key, "study-1", "ann@example.org")
    assert "ann" not in token
    with app.test_request_context(), transaction(engine_of(app)) as session:
        study, person = accept_invitation(session, token)
        assert study == "study-1"
        assert accept_invitation(session, token)[1].id == person.id
        for wrong in (token[:-1], token + "x", "", "a.b"):
            with pytest.raises(Refusal):
                accept_invitation(session, wrong)
        assert len(session.scalars(select(Person)).all()) == 1
