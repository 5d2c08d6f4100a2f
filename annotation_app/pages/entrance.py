"""The start page, a study's own page, and what people agree to before they begin."""

from __future__ import annotations

import flask
from flask import Blueprint, Response
from flask.typing import ResponseReturnValue
from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.core.languages import gettext, speak
from annotation_app.core.problems import Refusal
from annotation_app.pages.study_progress import progress
from annotation_app.people.browser_sessions import current_person, had_login, is_signed_in, sign_in
from annotation_app.people.participants import (
    OPEN,
    RANKS,
    accept_invitation,
    add_anonymous,
    has_consented,
    keep_consent,
)
from annotation_app.store.database import reading, transaction
from annotation_app.store.installation import installation
from annotation_app.store.models import Participation, Person, Record, Study
from annotation_app.studies.safe_markdown import to_html
from annotation_app.studies.study_file import (
    StudyConfig,
    in_its_language,
    language_of,
    restored,
    told,
)
from annotation_app.web.limits import arrivals, limited
from annotation_app.web.public_links import here
from annotation_app.web.who_asks import sign_in_page
from annotation_app.work.handing_out import EXPLANATIONS, Reason, find_study

LONGEST_ANSWER = 500
INVITED_TO = "invited to"
"""Session key of the study that a person's link invites to, until they agree."""

blueprint = Blueprint("entrance", __name__)
blueprint.add_app_template_filter(to_html, "markdown")
blueprint.add_app_template_filter(told, "told")


@blueprint.get("/")
def home() -> str:
    """Show the studies that one can take part in."""
    with reading(installation().engine) as session:
        person = current_person(session)
        studies = [
            (study.name, restored(study.config))
            for study in session.scalars(select(Study).order_by(Study.created_at))
            if study.closed_at is None and _may_enter(session, study, person)
        ]
    tries = may_try(person)
    return flask.render_template("home.html", studies=studies, person=person, tries=tries)


@blueprint.get("/offline")
def offline() -> str:
    """Show what browsers keep for times without a connection."""
    return flask.render_template("offline.html")


@blueprint.get("/offline-worker.js")
def offline_worker() -> Response:
    """Return the script that shows the page; it works for the pages below its own address."""
    return flask.current_app.send_static_file("js/offline-worker.js")


@blueprint.get("/s/<study_name>")
def study_page(study_name: str) -> ResponseReturnValue:
    """Show a study's tasks, and a person's progress."""
    with reading(installation().engine) as session:
        study = _spoken_study(session, study_name)
        person = current_person(session)
        if person is None and had_login():
            return sign_in_page()
        if person is None or wants_welcome(study, person):
            return flask.redirect(here(f"/s/{study.name}/welcome"))
        config = restored(study.config)
        tasks = progress(session, study, person)
    return flask.render_template(
        "study.html", study=study, config=config, tasks=tasks, person=person
    )


@blueprint.get("/s/<study_name>/invitation/<token>")
@limited(arrivals)
def invited(study_name: str, token: str) -> ResponseReturnValue:
    """Receive a person who comes by a link of their own."""
    with transaction(installation().engine) as session:
        study = _spoken_study(session, study_name)
        study_id, person = accept_invitation(session, token)
        if study_id != study.id:
            raise Refusal(404, gettext("This link is for another study."))
    sign_in(person)
    flask.session[INVITED_TO] = study_id
    return flask.redirect(here(f"/s/{study.name}"))


@blueprint.get("/s/<study_name>/welcome")
def welcome(study_name: str) -> ResponseReturnValue:
    """Show a study's description, and the consent text."""
    with reading(installation().engine) as session:
        study = _spoken_study(session, study_name)
        may_enter = _may_enter(session, study, current_person(session))
    if study.closed_at is not None:
        return _stop(study, "closed")
    if not may_enter:
        return _stop(study, "not invited")
    return _welcome(study, {}, {})


@blueprint.post("/s/<study_name>/welcome")
@limited(arrivals)
def agree(study_name: str) -> ResponseReturnValue:
    """Keep a person's agreement; a new visitor becomes a person now."""
    form = flask.request.form
    with transaction(installation().engine) as session:
        study = _spoken_study(session, study_name)
        person = current_person(session)
        if not _may_enter(session, study, person):
            return _stop(study, "not invited")
        config = restored(study.config)
        answers = {
            q.id: form.get(f"q-{q.id}", "").replace("\0", "").strip()[:LONGEST_ANSWER]
            for q in config.questions
        }
        problems = _problems(config, answers)
        if problems:
            return _welcome(study, answers, problems), 422
        person = person or add_anonymous(session)
        keep_consent(session.merge(person), study.id, answers)
    if not is_signed_in(person):
        sign_in(person)
    return flask.redirect(here(_onwards(study)), 303)


def wants_welcome(study: Study, person: Person) -> bool:
    """Check that a person must read a study's welcome page first."""
    return not has_consented(person, study.id)


def may_try(person: Person | None) -> bool:
    """Check that a person may try commands: people with a login, in a demo everybody."""
    if installation().config.open_trying:
        return True
    return person is not None and RANKS[person.role] > RANKS["worker"] and not person.blocked_at


def _spoken_study(session: Session, name: str) -> Study:
    """Return a study, and switch to its language."""
    study = find_study(session, name)
    speak(language_of(study.config))
    return study


def _welcome(study: Study, answers: Record, problems: Record) -> str:
    return flask.render_template(
        "welcome.html",
        study=study,
        config=in_its_language(restored(study.config)),
        answers=answers,
        problems=problems,
        ticked=flask.request.form,
        onwards=flask.request.args.get("task", ""),
    )


def _onwards(study: Study) -> str:
    """Return the address of the task that a person chose, else of the study's page."""
    task = flask.request.form.get("task", "")
    return f"/s/{study.name}/{task}" if task in study.config["tasks"] else f"/s/{study.name}"


def _problems(config: StudyConfig, answers: Record) -> Record:
    form = flask.request.form
    problems = {}
    for question in config.questions:
        given = answers[question.id]
        if question.required and not given:
            problems[f"q-{question.id}"] = gettext("Please answer this question.")
        elif given and question.choices and given not in question.choices:
            problems[f"q-{question.id}"] = gettext("Please choose one of these.")
    for i, _ in enumerate(config.qualification):
        if f"confirm-{i}" not in form:
            problems[f"confirm-{i}"] = gettext("You can take part only if this is true of you.")
    if "agree" not in form:
        problems["agree"] = gettext(
            "Tick the box if you agree. If you don't, just close this page."
        )
    return problems


def _may_enter(session: Session, study: Study, person: Person | None) -> bool:
    """Check that a person may enter a study: an invitation to another study is none to this one."""
    if restored(study.config).access == "open":
        return True
    if person is None or RANKS[person.role] > RANKS["worker"]:
        return person is not None
    if person.provider == OPEN:
        return False
    if has_consented(person, study.id) or flask.session.get(INVITED_TO) == study.id:
        return True
    from_a_crowd = select(Participation.id).where(
        Participation.study_id == study.id, Participation.person_id == person.id
    )
    return session.scalar(from_a_crowd.limit(1)) is not None


def _stop(study: Study, reason: Reason) -> str:
    message = gettext(EXPLANATIONS[reason])
    return flask.render_template(
        "stopped.html", study=study, config=restored(study.config), message=message, tasks=()
    )
