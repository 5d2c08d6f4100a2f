"""A person with a browser, as far as the JSON interface is concerned."""

from __future__ import annotations

import io
import uuid
from typing import Any, TypeVar

from flask import Flask
from sqlalchemy import Engine, Executable, Select, update

from annotation_app.core.random_ids import new_id
from annotation_app.export.answer_tables import TABLES
from annotation_app.people.participants import add_person, keep_consent
from annotation_app.store.database import reading, transaction
from annotation_app.store.installation import Installation
from annotation_app.store.models import Handout, Person, Role
from annotation_app.work.handing_out import find_study

T = TypeVar("T")

COMMAND = "Pick up the tires by the truck."


class Browser:
    """Signed in, with consent given to a study."""

    def __init__(self, app: Flask, role: Role = "worker", study: str | None = "tests") -> None:
        self.client = app.test_client()
        engine = self.engine = installation_of(app).engine
        with transaction(engine) as session:
            person = add_person(session, "test", new_id(), role)
            if study is not None:
                keep_consent(person, find_study(session, study).id, {})
        self.person: Person = person
        self.sign_in()

    def sign_in(self) -> None:
        """Make the browser's cookie."""
        with self.client.session_transaction() as cookie:
            cookie["person"] = self.person.id
        self.csrf = self.client.get("/api/session").json["csrf"]

    def send(self, method: str, path: str, value: Any) -> Any:
        return self.client.open(path, method=method, json=value, headers={"X-CSRFToken": self.csrf})

    def lease(self, task: str, study: str = "tests") -> Any:
        return self.send("POST", f"/api/studies/{study}/tasks/{task}/lease", {})

    def practise(self, *tasks: str) -> None:
        for task in tasks:
            assert self.send("POST", f"/api/practice/{task}", {}).status_code < 300

    def take(self, task: str) -> dict[str, Any]:
        response = self.lease(task)
        assert response.status_code == 200, response.text
        return response.json

    def answer(self, item: str, body: Any, event: str | None = None) -> Any:
        sent = {"uuid": event or str(uuid.uuid4()), "body": body}
        return self.send("POST", f"/api/items/{item}/answer", sent)

    def watched(self, page: dict[str, Any]) -> dict[str, float]:
        """Return the fields of an answer to a page whose videos were watched, without a wait."""
        films = page["payload"].get("scenes", [page["payload"]])
        seconds = sum(film["duration_s"] for film in films)
        earlier = {"at": Handout.at - seconds, "since_boot_s": Handout.since_boot_s - seconds}
        mine = Handout.person_id == self.person.id
        execute(self.engine, update(Handout).where(mine).values(earlier))
        return {"watched_s": seconds}

    def draft(self, item: str, revision: int, body: Any) -> Any:
        return self.send("PUT", f"/api/items/{item}/draft", {"revision": revision, "body": body})

    def note(self, item: str, what: str, reason: str) -> None:
        """Flag an item, or skip it."""
        sent = {"uuid": str(uuid.uuid4()), "reason": reason}
        response = self.send("POST", f"/api/items/{item}/{what}", sent)
        assert response.status_code == 200, response.text

    def adjudicate(self, item: str, body: Any, comment: str = "") -> Any:
        """Send an answer of one's own in the place of others'."""
        sent = {"uuid": str(uuid.uuid4()), "body": body, "comment": comment}
        return self.send("POST", f"/api/items/{item}/adjudicate", sent)

    def do(self, task: str, body: Any) -> Any:
        response = self.answer(self.take(task)["item"], body)
        assert response.status_code == 200, response.text
        return response.json


def installation_of(app: Flask) -> Installation:
    found = app.extensions["annotation"]
    assert isinstance(found, Installation)
    return found


def engine_of(app: Flask) -> Engine:
    return installation_of(app).engine


def session_of(person: Any) -> str:
    """The cookie by which somebody's browser is known."""
    cookie = person.client.get_cookie("session")
    assert cookie is not None
    return str(cookie.value)


def rows_in(where: Flask | Engine, statement: Select[tuple[T]]) -> list[T]:
    """What a SELECT finds in the database, the first column of each row."""
    with reading(engine_of(where) if isinstance(where, Flask) else where) as session:
        return list(session.scalars(statement))


def row_in(where: Flask | Engine, statement: Select[tuple[T]]) -> T:
    """What a SELECT finds that finds one row."""
    (found,) = rows_in(where, statement)
    return found


def execute(where: Flask | Engine, statement: Executable) -> None:
    """Change the database as nobody can by the app."""
    with transaction(engine_of(where) if isinstance(where, Flask) else where) as session:
        session.execute(statement)


def exported(app: Flask, form: str, study: str = "tests") -> bytes:
    """An export of a study's answers."""
    with reading(engine_of(app), one_state=True) as session:
        file = io.BytesIO()
        TABLES[form].write(session, find_study(session, study), file)
    return file.getvalue()


def described(text: str = COMMAND) -> dict[str, Any]:
    return {"text": text, "played_to_end": True, "watched_s": 2.0}
