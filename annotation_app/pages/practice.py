"""Practice examples: a made-up scene at sea, so that they put no words into anybody's mouth."""

from __future__ import annotations

import flask
from flask import Blueprint
from sqlalchemy import select

from annotation_app.core.problems import Refusal
from annotation_app.people.browser_sessions import current_person
from annotation_app.store.database import reading
from annotation_app.store.installation import installation
from annotation_app.store.models import Study
from annotation_app.tasks.practice_example import practice_example
from annotation_app.tasks.task_registry import task_of
from annotation_app.web.api import read_task

blueprint = Blueprint("practice", __name__)


@blueprint.get("/practice/<task_name>")
def practice_page(task_name: str) -> str:
    """A practice example with feedback; nothing that is done there is kept."""
    task = read_task(task_name)
    of_task = task_of(task)
    if of_task.example is None:
        raise Refusal(404, "There is no practice example for this task.")
    name = flask.request.args.get("study", "")
    with reading(installation().engine) as session:
        study = session.scalars(select(Study).where(Study.name == name)).first()
        person = current_person(session)
    onwards = f"/s/{study.name}/{task}" if study is not None else "/"
    data = {
        "item": f"practice-{task}",
        "task": task,
        "draft": None,
        "payload": of_task.example(practice_example()),
        "practice": True,
        "signed_in": person is not None,
        "next": onwards,
        "who": "practice",
    }
    return flask.render_template(
        of_task.template,
        study=study,
        title=None,
        task=task,
        words=of_task.words,
        progress=None,
        person=person,
        data=data,
        is_practice=True,
    )
