"""A person with a browser, as far as the JSON interface is concerned."""

from __future__ import annotations

import io
import uuid
from typing import Any

from flask import Flask
from sqlalchemy import Engine

from annotation_app.core.random_ids import new_id
from annotation_app.export.answer_tables import TABLES
from annotation_app.people.participants import add_person, keep_consent
from annotation_app.store.database import reading, transaction
from annotation_app.store.installation import Installation
from annotation_app.store.models import Person, Role
from annotation_app.work.handing_out import find_study

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
        with self.client.session_transaction() as cookie:
            cookie["person"] = person.id
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

    def draft(self, item: str, revision: int, body: Any) -> Any:
        return self.send("PUT", f"/api/items/{item}/draft", {"revision": revision, "body": body})

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


def exported(app: Flask, form: str, study: str = "tests") -> bytes:
    """An export of a study's answers."""
    with reading(engine_of(app), one_state=True) as session:
        file = io.BytesIO()
        TABLES[form].write(session, find_study(session, study), file)
    return file.getvalue()


def described(text: str = COMMAND) -> dict[str, Any]:
    return {"text": text, "played_to_end": True, "watched_s": 1.0}
