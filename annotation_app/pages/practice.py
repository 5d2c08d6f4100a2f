"""Practice examples: a made-up scene at sea, so that they put no words into anybody's mouth."""

from __future__ import annotations

import functools
from importlib import resources
from typing import Any

import flask
import msgspec
from flask import Blueprint
from sqlalchemy import select

from annotation_app.people.browser_sessions import current_person
from annotation_app.store.database import reading
from annotation_app.store.installation import installation
from annotation_app.store.models import Study
from annotation_app.tasks.task_words import KEYS, LIKERT, TASK_WORDS
from annotation_app.web.api import read_task

STATEMENT = "The boat in the video is executing the above spoken command"

blueprint = Blueprint("practice", __name__)


@blueprint.get("/practice/<task_name>")
def practice_page(task_name: str) -> str:
    """A practice example with feedback; nothing that is done there is kept."""
    task = read_task(task_name)
    name = flask.request.args.get("study", "")
    with reading(installation().engine) as session:
        study = session.scalars(select(Study).where(Study.name == name)).first()
        person = current_person(session)
    onwards = f"/s/{study.name}/{task}" if study is not None else "/"
    data = {
        "item": f"practice-{task}",
        "task": task,
        "draft": None,
        "payload": examples()[task],
        "practice": True,
        "signed_in": person is not None,
        "next": onwards,
        "who": "practice",
    }
    return flask.render_template(
        "task.html",
        study=study,
        title=None,
        task=task,
        words=TASK_WORDS[task],
        keys=KEYS[task],
        statement=STATEMENT,
        likert=LIKERT,
        progress=None,
        person=person,
        data=data,
        is_practice=True,
    )


@functools.cache
def examples() -> dict[str, Any]:
    """The payload of each task's example."""
    file = resources.files("annotation_app.pages") / "practice.json"
    found: dict[str, Any] = msgspec.json.decode(file.read_bytes())
    return found
