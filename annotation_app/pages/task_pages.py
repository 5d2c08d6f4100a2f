"""One page for each task: it takes an item, or gives the reason why there is none."""

from __future__ import annotations

import flask
from flask import Blueprint
from flask.typing import ResponseReturnValue

from annotation_app.core.languages import gettext
from annotation_app.items.assignment import Lease
from annotation_app.pages.entrance import wants_welcome
from annotation_app.pages.study_progress import TaskProgress, progress
from annotation_app.people.browser_sessions import had_login
from annotation_app.store.database import reading, transaction
from annotation_app.store.installation import installation, now
from annotation_app.store.models import Person, Study, TaskName
from annotation_app.studies.study_file import in_its_language, restored
from annotation_app.tasks.task_registry import task_of
from annotation_app.tasks.task_texts import task_words
from annotation_app.web.api import read_task
from annotation_app.web.public_links import here
from annotation_app.web.task_page import WHO_CHARACTERS, render_task
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
