"""The page on which items are assigned to people and groups."""

from __future__ import annotations

import flask
from flask import Blueprint
from flask.typing import ResponseReturnValue
from sqlalchemy.orm import Session

from annotation_app.core.problems import Refusal
from annotation_app.dashboard import answer_browsing as browsing
from annotation_app.people.person_names import shown_name
from annotation_app.store.audit import name_of
from annotation_app.store.models import Person
from annotation_app.studies.study_file import restored
from annotation_app.web.who_asks import changed_by, refused, refused_on, seen_by
from annotation_app.work import assigning
from annotation_app.work.handing_out import find_study

blueprint = Blueprint("assigning_pages", __name__, url_prefix="/dashboard")
blueprint.register_error_handler(Refusal, refused)


def _assign_page(session: Session, person: Person, study_name: str, problem: str = "") -> str:
    study = find_study(session, study_name)
    counts = assigning.assigned(session, study.id)
    people = assigning.assignable(session, study.id)
    config = restored(study.config)
    members = assigning.groups(session)
    return flask.render_template(
        "dashboard/assign.html",
        person=person,
        study=study,
        problem=problem,
        form=flask.request.form,
        tasks=list(config.tasks),
        shares=config.groups,
        videos=browsing.videos(session, study.id),
        groups={
            name: [shown_name(one) for one in members.get(name, ())]
            for name in sorted({*members, *config.groups})
        },
        people=[
            (
                one.id,
                shown_name(one),
                [(task, count) for (who, task), count in sorted(counts.items()) if who == one.id],
            )
            for one in people
        ],
    )


@blueprint.get("/<study_name>/assign")
def assign_page(study_name: str) -> str:
    """Show who has which items, and the form to assign them."""
    with seen_by("adjudicator") as (session, person):
        return _assign_page(session, person, study_name)


@blueprint.post("/<study_name>/assign")
@refused_on(_assign_page, "adjudicator")
def assign(study_name: str) -> ResponseReturnValue:
    """Assign the open items of a task to people."""
    form = flask.request.form
    way, task = form.get("way", ""), form.get("task", "")
    with changed_by("adjudicator") as (session, person):
        study = find_study(session, study_name)
        ways = [one for one in assigning.WAYS if one == way]
        if not ways or task not in study.config["tasks"]:
            raise Refusal(422, "Choose a task, and who gets its items.")
        count = assigning.assign(
            session,
            study,
            task,
            form.getlist("people"),
            form.getlist("groups"),
            actor=name_of(person),
            way=ways[0],
            video=form.get("video", "").replace("\0", "")[:200],
        )
    items = "item" if count == 1 else "items"
    flask.flash(f"{count} open {items} of {task} assigned.")
    return flask.redirect(flask.url_for(".assign_page", study_name=study_name), 303)


@blueprint.post("/<study_name>/assign/groups")
@refused_on(_assign_page, "adjudicator")
def set_group(study_name: str) -> ResponseReturnValue:
    """Make a group of the chosen people, or remove one."""
    form = flask.request.form
    with changed_by("adjudicator") as (session, person):
        removed = form.get("remove", "")
        people = [] if removed else form.getlist("people")
        if not people and not removed:
            raise Refusal(422, "Choose the people of the group.")
        name = assigning.set_group(
            session, removed or form.get("group", ""), people, actor=name_of(person)
        )
    flask.flash(f"The group {name} is {'removed' if removed else 'saved'}.")
    return flask.redirect(flask.url_for(".assign_page", study_name=study_name), 303)
