"""The dashboard's pages, for people with a login."""

from __future__ import annotations

import flask
from flask import Blueprint, Response
from flask.typing import ResponseReturnValue
from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.core.problems import Refusal
from annotation_app.dashboard import adjudication_queue as queue
from annotation_app.dashboard import dashboard_charts as charts
from annotation_app.dashboard.consensus import agreement
from annotation_app.dashboard.disagreements import disagreements
from annotation_app.dashboard.exports import export_response
from annotation_app.dashboard.study_statistics import (
    collected,
    durations,
    histories,
    progress_by_task,
    progress_by_video,
)
from annotation_app.dashboard.workers import workers
from annotation_app.export import answer_tables
from annotation_app.people import accounts
from annotation_app.people.participants import RANKS, subject_of
from annotation_app.store.audit import name_of
from annotation_app.store.installation import now
from annotation_app.store.models import Person, Study
from annotation_app.tasks.task_registry import tasks
from annotation_app.web.who_asks import changed_by, refused, seen_by
from annotation_app.work.handing_out import find_study

blueprint = Blueprint(
    "dashboard",
    __name__,
    url_prefix="/dashboard",
    template_folder="templates",
    static_folder="static",
)
blueprint.register_error_handler(Refusal, refused)


@blueprint.get("/")
def studies() -> str:
    """All studies."""
    with seen_by("annotator") as (session, person):
        found = session.scalars(select(Study).order_by(Study.name)).all()
        return _page("studies.html", person, studies=found)


@blueprint.get("/<study_name>")
def overview(study_name: str) -> str:
    """How a study is going. Names of videos and people's work are for adjudicators."""
    with seen_by("annotator", one_state=True) as (session, person):
        study = find_study(session, study_name)
        by_video = progress_by_video(session, study.id, now=now())
        sees_all = RANKS[person.role] >= RANKS["adjudicator"]
        people = workers(session, study.id) if sees_all else []
        times = durations(session, study.id)
        agreed = agreement(session, study.id) if sees_all else []
        came = histories(session, study.id, now=now())
        return _page(
            "overview.html",
            person,
            study=study,
            by_task=progress_by_task(by_video),
            by_video=by_video if sees_all else [],
            durations=times,
            histories=came,
            charts={
                "history": charts.history_chart(came),
                "times": charts.time_chart(times),
                "agreement": charts.agreement_chart(agreed),
            },
            collected=collected(session, study.id),
            counts=[task.counts for task in tasks() if task.counts is not None],
            tables=answer_tables.TABLES,
            agreement=agreed,
            disagreements=disagreements(session, study.id, most=1) if sees_all else [],
            flagged=[worker for worker in people if worker.reasons],
            disputes=queue.disputes(session, study.id) if sees_all else [],
            sees_all=sees_all,
        )


@blueprint.get("/<study_name>/people")
def people(study_name: str) -> str:
    """Everybody who has answered."""
    with seen_by("adjudicator", one_state=True) as (session, person):
        study = find_study(session, study_name)
        return _page("people.html", person, study=study, workers=workers(session, study.id))


@blueprint.get("/<study_name>/people/<person_id>")
def confirm_block(study_name: str, person_id: str) -> str:
    """Whether somebody is really to get no more items."""
    with seen_by("admin") as (session, admin):
        study = find_study(session, study_name)
        found = _person(session, person_id)
        return _page(
            "block.html",
            admin,
            study=study,
            name=subject_of(found),
            about="They get no more items, in any study. What they have answered stays, and what "
            "they have begun they can still send. You can unblock them.",
            back=flask.url_for("dashboard.people", study_name=study.name),
        )


@blueprint.post("/<study_name>/people/<person_id>")
def block(study_name: str, person_id: str) -> ResponseReturnValue:
    """Give somebody no more items, or items again."""
    with changed_by("admin") as (session, admin):
        find_study(session, study_name)
        person = _person(session, person_id)
        wanted = flask.request.form.get("block") == "yes"
        change = accounts.block if wanted else accounts.unblock
        change(session, person, actor=name_of(admin))
    return flask.redirect(flask.url_for("dashboard.people", study_name=study_name), 303)


@blueprint.get("/<study_name>/export/<form>")
def export(study_name: str, form: str) -> Response:
    """All answers as they are, or the corpus that they make."""
    return export_response(study_name, form)


def _person(session: Session, person_id: str) -> Person:
    person = session.get(Person, person_id)
    if person is None:
        raise Refusal(404, "There is no such person.")
    return person


def _page(template: str, person: Person, **values: object) -> str:
    return flask.render_template(f"dashboard/{template}", person=person, **values)
