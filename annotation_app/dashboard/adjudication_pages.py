"""Pages on which adjudicators decide between answers, also in the editor that workers have."""

from __future__ import annotations

from uuid import uuid4

import flask
import msgspec
from flask import Blueprint
from flask.typing import ResponseReturnValue
from sqlalchemy.orm import Session

from annotation_app.core.problems import Refusal
from annotation_app.dashboard import adjudication_queue as queue
from annotation_app.dashboard.answer_browsing import posters, remarks
from annotation_app.items.item_scenes import beside_video
from annotation_app.store.installation import installation, now
from annotation_app.store.models import Answer, Item, Person, Study
from annotation_app.studies.study_file import restored
from annotation_app.tasks.task_record import Adjudication
from annotation_app.tasks.task_registry import task_of
from annotation_app.web.api import UUID
from annotation_app.web.task_page import WHO_CHARACTERS, render_task
from annotation_app.web.who_asks import changed_by, refused, refused_on, seen_by
from annotation_app.work import adjudicating
from annotation_app.work.handing_out import find_study
from annotation_app.work.page_data import page_data
from annotation_app.work.reviewing import LONGEST_REMARK

blueprint = Blueprint("adjudication", __name__, url_prefix="/dashboard")
blueprint.register_error_handler(Refusal, refused)


@blueprint.get("/<study_name>/queue")
def disputes(study_name: str) -> str:
    """List the items on which people disagree."""
    with seen_by("adjudicator") as (session, person):
        study = find_study(session, study_name)
        return flask.render_template(
            "dashboard/queue.html",
            person=person,
            study=study,
            disputes=queue.disputes(session, study.id),
            waiting=queue.waiting(session, study.id),
        )


@blueprint.get("/<study_name>/queue/next")
def following(study_name: str) -> ResponseReturnValue:
    """Open the first undecided item, or the list if there is none."""
    with seen_by("adjudicator") as (session, _):
        study = find_study(session, study_name)
        return _following(session, study)


def _comparison(
    session: Session, person: Person, study_name: str, item_id: str, problem: str = ""
) -> str:
    study = find_study(session, study_name)
    item, adjudication = _item(session, study, item_id)
    found = queue.compare(session, item, adjudication, installation().salt)
    return flask.render_template(
        adjudication.template,
        person=person,
        study=study,
        found=found,
        said=[one for side in found.sides for one in remarks(session, side.answer)],
        asked=adjudicating.asked(session, item),
        files=posters(session, study.id, [item.video]).get(item.video, {}),
        beside=beside_video(session, study.id, item.video),
        problem=problem,
        typed=flask.request.form,
        longest=LONGEST_REMARK,
        uuid=str(uuid4()),
    )


@blueprint.get("/<study_name>/queue/<item_id>")
def dispute(study_name: str, item_id: str) -> str:
    """Show the answers to an item, side by side."""
    with seen_by("adjudicator") as (session, person):
        return _comparison(session, person, study_name, item_id)


@blueprint.post("/<study_name>/queue/<item_id>")
@refused_on(_comparison, "adjudicator")
def decide(study_name: str, item_id: str) -> ResponseReturnValue:
    """Adopt one of the answers, or request one more person's."""
    form = flask.request.form
    with changed_by("adjudicator") as (session, person):
        study = find_study(session, study_name)
        item, _ = _item(session, study, item_id)
        uuid, comment = _uuid(form.get("uuid", "")), form.get("comment", "")
        choice = form.get("choice", "")
        if choice == "ask":
            adjudicating.ask_one_more(
                session, study, item, person, comment=comment, uuid=uuid, now=now()
            )
        else:
            number = int(choice[:18]) if choice.isascii() and choice.isdigit() else 0
            adjudicating.choose(
                session, study, item, person, number, comment=comment, uuid=uuid, now=now()
            )
        return _following(session, study)


@blueprint.get("/<study_name>/queue/<item_id>/edit")
def edit(study_name: str, item_id: str) -> str:
    """Show the worker's editor, filled with one of the answers; the page sends a third one."""
    number = flask.request.args.get("answer", 0, type=int)
    salt = installation().salt
    with seen_by("adjudicator") as (session, person):
        study = find_study(session, study_name)
        item, adjudication = _item(session, study, item_id)
        answer = session.get(Answer, number) if 0 < number < 2**31 else None
        if answer is None or answer.item_id != item.id:
            raise Refusal(404, "There is no such answer.")
        task = task_of(item.task)
        sent = task.sent_form(session, item, answer.body, salt)
        data = adjudication.opened(page_data(session, item.id, person.id, salt), sent)
        config = restored(study.config)
        data |= {
            "who": person.id[:WHO_CHARACTERS],
            "draft": None,
            "from": answer.id,
            "to": "adjudicate",
            "next": flask.url_for("adjudication.following", study_name=study.name),
        }
        back = flask.url_for("adjudication.dispute", study_name=study.name, item_id=item.id)
        return render_task(
            task, config, data, study=study, title=config.title, person=person, adjudicating=back
        )


def _following(session: Session, study: Study) -> ResponseReturnValue:
    found = queue.disputes(session, study.id)
    address = (
        flask.url_for("adjudication.dispute", study_name=study.name, item_id=found[0].item)
        if found
        else flask.url_for("adjudication.disputes", study_name=study.name)
    )
    return flask.redirect(address, 303)


def _item(session: Session, study: Study, item_id: str) -> tuple[Item, Adjudication]:
    item = session.get(Item, item_id)
    adjudication = None if item is None else queue.adjudication_of(item)
    if item is None or item.study_id != study.id or adjudication is None:
        raise Refusal(404, "There is no such item.")
    return item, adjudication


def _uuid(value: str) -> str:
    try:
        return msgspec.convert(value, UUID)
    except msgspec.ValidationError:
        raise Refusal(400, "The request can't be read. Load the page again.") from None
