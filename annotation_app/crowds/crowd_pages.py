"""Pages through which workers arrive from a platform, and leave."""

from __future__ import annotations

import flask
from flask import Blueprint
from flask.typing import ResponseReturnValue
from sqlalchemy.orm import Session

from annotation_app.core.languages import gettext, speak
from annotation_app.core.problems import Refusal
from annotation_app.crowds.crowd_registry import find_provider
from annotation_app.crowds.participation import (
    begin,
    completion_code,
    done_of,
    read_offer,
    receive,
)
from annotation_app.crowds.platform import Arrival
from annotation_app.items.assignment import Lease
from annotation_app.people.browser_sessions import current_person, is_signed_in, sign_in
from annotation_app.people.participants import add_anonymous, find_or_add
from annotation_app.store.database import transaction
from annotation_app.store.installation import installation, now
from annotation_app.store.models import Participation, Person, Study
from annotation_app.studies.study_file import in_its_language, language_of, restored
from annotation_app.tasks.task_registry import task_of
from annotation_app.tasks.task_texts import task_words
from annotation_app.web.limits import arrivals, limited
from annotation_app.web.public_links import here
from annotation_app.work.handing_out import HOLD_S, take_work

IN_COOKIE = "participation"
NOTHING_LEFT = ("done", "all taken", "nothing to do", "closed")
"""Reasons for which somebody's assignment ends before it is full."""

blueprint = Blueprint("crowds", __name__, url_prefix="/crowd", template_folder="templates")


@blueprint.get("/<provider_name>/<token>")
@limited(arrivals)
def enter(provider_name: str, token: str) -> ResponseReturnValue:
    """Let a worker in."""
    provider = find_provider(provider_name)
    if provider is None:
        raise Refusal(404, gettext("There is no such page."))
    offer = read_offer(installation().config.secret_key, token)
    arrival = provider.load().enter(flask.request.args, offer.study_id)
    with transaction(installation().engine) as session:
        study = session.get(Study, offer.study_id)
        if study is None:
            raise Refusal(404, gettext("There is no such study."))
        speak(language_of(study.config))
        if arrival.is_preview:
            config = in_its_language(restored(study.config))
            return flask.render_template(
                "crowds/preview.html",
                title=config.title,
                provider=provider,
                offer=offer,
                words=task_words(config, task_of(offer.task)),
                config=config,
            )
        person = _person(session, arrival)
        participation = begin(
            session,
            offer,
            person,
            provider=provider.name,
            assignment=arrival.assignment or f"{offer.study_id} {offer.task} {person.id}",
            code=completion_code(installation().config.secret_key, offer),
            submit_to=arrival.submit_to,
            now=now(),
        )
        # Signing in again would make the tokens of pages that are open invalid.
        if not is_signed_in(person):
            sign_in(person)
        flask.session[IN_COOKIE] = participation.id
        return flask.redirect(here(f"/s/{study.name}/{offer.task}"))


@blueprint.get("/finish")
def finish() -> ResponseReturnValue:
    """Show somebody's progress, and the way back to the platform when all is done."""
    with transaction(installation().engine) as session:
        person, participation = _current(session)
        if person is None or participation is None:
            raise Refusal(404, gettext("There is no assignment that you work on. Open it again."))
        study = session.get_one(Study, participation.study_id)
        speak(language_of(study.config))
        done = done_of(session, participation)
        is_received = _receive(session, study, person, participation, done)
        provider = find_provider(participation.provider)
        assert provider is not None  # noqa: S101 - it has brought the person in
        code = participation.code or ""
        return flask.render_template(
            "crowds/finish.html",
            title=restored(study.config).title,
            provider=provider,
            done=done,
            items=participation.items,
            is_received=is_received,
            code=code,
            data_code=person.code,
            ending=provider.load().leave(participation, code),
            go_on=here(f"/s/{study.name}/{participation.task}"),
        )


@blueprint.before_app_request
def leave_when_done() -> ResponseReturnValue | None:
    """Show the way back to the platform, in place of the next item, to who has done all."""
    if flask.request.method != "GET" or not flask.request.path.startswith("/s/"):
        return None
    if IN_COOKIE not in flask.session:
        return None
    with transaction(installation().engine) as session:
        person, participation = _current(session)
        if person is None or participation is None:
            return None
        study = session.get_one(Study, participation.study_id)
        if flask.request.path != f"/s/{study.name}/{participation.task}":
            return None
        done = done_of(session, participation)
        if not _receive(session, study, person, participation, done):
            return None
        return flask.redirect(here("/crowd/finish"))


def _receive(
    session: Session, study: Study, person: Person, participation: Participation, done: int
) -> bool:
    nothing_left = False
    if 0 < done < participation.items and participation.received_at is None:
        taken = take_work(session, study, participation.task, person, now=now(), hold_s=HOLD_S)
        nothing_left = not isinstance(taken, Lease) and taken in NOTHING_LEFT
    return receive(participation, done=done, nothing_left=nothing_left, now=now())


def _current(session: Session) -> tuple[Person | None, Participation | None]:
    person = current_person(session)
    found = flask.session.get(IN_COOKIE)
    participation = session.get(Participation, found) if isinstance(found, int) else None
    if person is None or participation is None or participation.person_id != person.id:
        return None, None
    return person, participation


def _person(session: Session, arrival: Arrival) -> Person:
    if arrival.person is not None:
        return find_or_add(session, arrival.provider, arrival.person)
    known = current_person(session)
    if known is not None and known.provider == arrival.provider:
        return known
    return add_anonymous(session)
