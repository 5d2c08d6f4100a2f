"""One page for each task, which takes an item or says why there is none, and one to practise.

People practise with a study's own items, or in a made-up scene at sea, which suggests no words.
"""

from __future__ import annotations

import flask
from flask import Blueprint
from flask.typing import ResponseReturnValue
from sqlalchemy import select

from annotation_app.core.languages import gettext, speak
from annotation_app.core.problems import Refusal
from annotation_app.items.assignment import Lease
from annotation_app.items.media import media_files
from annotation_app.pages.entrance import wants_welcome
from annotation_app.pages.study_progress import TaskProgress, progress
from annotation_app.people.browser_sessions import current_person, had_login
from annotation_app.store.database import reading, transaction
from annotation_app.store.installation import installation, now
from annotation_app.store.models import Person, Study, TaskName
from annotation_app.studies.study_file import in_its_language, language_of, restored
from annotation_app.tasks.practice_example import OwnPractice, practice_example
from annotation_app.tasks.task_registry import task_of
from annotation_app.tasks.task_texts import task_words
from annotation_app.web.api import read_task
from annotation_app.web.public_links import here
from annotation_app.web.task_page import WHO_CHARACTERS, render_practice, render_task
from annotation_app.web.who_asks import sign_in_page
from annotation_app.work.handing_out import EXPLANATIONS, HOLD_S, Reason, take_work, visit
from annotation_app.work.page_data import opened_page

blueprint = Blueprint("tasks", __name__)


@blueprint.get("/s/<study_name>/<task_name>")
def task_page(study_name: str, task_name: str) -> ResponseReturnValue:
    """Show an item to work on."""
    task = read_task(task_name)
    of_task = task_of(task)
    # What only reads is done beside whoever writes; a suggestion may take seconds.
    engine = installation().engine
    with reading(engine) as session:
        person, study = visit(session, study_name)
    if person is None and had_login():
        return sign_in_page()
    if person is None or wants_welcome(study, person):
        return flask.redirect(here(f"/s/{study.name}/welcome?task={task}"))
    with transaction(engine) as session:
        taken = take_work(session, study, task, person, now=now(), hold_s=HOLD_S)
    with reading(engine) as session:
        tasks = progress(session, study, person)
        if not isinstance(taken, Lease):
            return _why(study, task, person, taken, tasks)
    data = opened_page(engine, taken.item_id, person.id, installation().salt)
    data["who"] = person.id[:WHO_CHARACTERS]
    data["next"] = here(f"/s/{study.name}/{task}")
    mine = next((entry for entry in tasks if entry.task == task), None)
    config = in_its_language(restored(study.config))
    return render_task(
        of_task,
        config,
        data,
        study=study,
        title=None if of_task.hides_title else config.title,
        has_practice=of_task.example is not None,
        progress=mine,
        person=person,
    )


def _why(
    study: Study, task: TaskName, person: Person, reason: Reason, tasks: list[TaskProgress]
) -> ResponseReturnValue:
    if reason == "no practice":
        return flask.redirect(here(f"/practice/{task}?study={study.name}"))
    if reason == "role":
        return sign_in_page()
    others = [entry for entry in tasks if entry.task != task and entry.done < entry.items]
    config = restored(study.config)
    return flask.render_template(
        "stopped.html",
        study=study,
        config=config,
        task=task,
        words=task_words(config, task_of(task)),
        reason=reason,
        message=gettext(EXPLANATIONS[reason]),
        tasks=others,
        person=person,
    )


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
