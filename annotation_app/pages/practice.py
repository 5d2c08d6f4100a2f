"""Practice: a study's own items, or a made-up scene at sea, which suggests no words."""

from __future__ import annotations

import flask
from flask import Blueprint
from sqlalchemy import select

from annotation_app.core.languages import gettext, speak
from annotation_app.core.problems import Refusal
from annotation_app.items.media import media_files
from annotation_app.people.browser_sessions import current_person
from annotation_app.store.database import reading
from annotation_app.store.installation import installation
from annotation_app.store.models import Study
from annotation_app.studies.study_file import in_its_language, language_of, restored
from annotation_app.tasks.practice_example import OwnPractice, practice_example
from annotation_app.tasks.task_registry import task_of
from annotation_app.web.api import read_task
from annotation_app.web.public_links import here
from annotation_app.web.task_page import render_practice

blueprint = Blueprint("practice", __name__)


@blueprint.get("/practice/<task_name>")
def practice_page(task_name: str) -> str:
    """Show a practice example with feedback; keep nothing that is done there."""
    task = read_task(task_name)
    of_task = task_of(task)
    if of_task.example is None:
        raise Refusal(404, gettext("There is no practice example for this task."))
    name = flask.request.args.get("study", "")
    number = flask.request.args.get("item", 0, type=int)
    with reading(installation().engine) as session:
        study = session.scalars(select(Study).where(Study.name == name)).first()
        person = current_person(session)
        if study is not None:
            speak(language_of(study.config))
        config = in_its_language(restored(study.config)) if study is not None else None
        own = config.tasks[task].practice_items if config and task in config.tasks else ()
        if study is None or person is None or not own:
            own, payload = (), of_task.example(practice_example())
        elif not 0 <= number < len(own):
            raise Refusal(404, gettext("There is no such practice item."))
        else:
            files = media_files(session, study.id, own[number].video)
            folder, corpus = files.paths["manifest"].parent, files.paths.get("corpus")
            payload = of_task.own_example(OwnPractice(own[number], folder, files.public, corpus))
    onwards = f"/s/{study.name}/{task}" if study is not None else "/"
    if number + 1 < len(own):
        onwards = f"/practice/{task}?study={name}&item={number + 1}"
    data = {
        "item": f"practice-{task}-{number}",
        # Who has done the last one has practised.
        "signed_in": person is not None and number + 1 >= len(own),
        "next": here(onwards),
        "who": "practice",
    }
    item = own[number] if own else None
    shown = {"study": study, "title": None, "person": person}
    return render_practice(of_task, config, payload, item, data, **shown)
