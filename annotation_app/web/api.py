"""The JSON interface that the pages' scripts, and programs, talk to."""

from __future__ import annotations

from typing import Annotated, Any, TypeAlias, TypeVar

import flask
import msgspec
from flask import Blueprint, Response
from flask_wtf.csrf import generate_csrf
from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.core.languages import gettext
from annotation_app.core.problems import Refusal
from annotation_app.core.sent_text import check_json
from annotation_app.items.assignment import Lease, Work, extend, skip
from annotation_app.items.submissions import add_event, save_draft, submit, was_received
from annotation_app.people.browser_sessions import current_person, required_person, unknown
from annotation_app.people.participants import keep_practice
from annotation_app.store.database import reading, transaction
from annotation_app.store.installation import installation, now
from annotation_app.store.models import Answer, Item, Study, TaskName
from annotation_app.studies.study_file import restored
from annotation_app.tasks.task_registry import find_task, task_of
from annotation_app.web.limits import limited, submissions
from annotation_app.web.public_links import here
from annotation_app.work import adjudicating, adoption
from annotation_app.work.answer_flags import odd_below
from annotation_app.work.answer_reading import checked_watching, gist_of, read_answer
from annotation_app.work.handing_out import EXPLANATIONS, item_of, lease_s, take_work, visit
from annotation_app.work.page_data import opened_page, page_data, provenance

blueprint = Blueprint("api", __name__, url_prefix="/api")

UUID: TypeAlias = Annotated[
    str,
    msgspec.Meta(
        pattern=r"^[0-9a-fA-F]{8}-[0-9a-fA-F]{4}-[0-9a-fA-F]{4}-[0-9a-fA-F]{4}-[0-9a-fA-F]{12}$"
    ),
]


class DraftRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A person's work so far."""

    revision: Annotated[int, msgspec.Meta(ge=0, le=2**31 - 1)]
    body: dict[str, Any]


class AnswerRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """An answer; sent again with the same uuid it is the same answer."""

    uuid: UUID
    body: dict[str, Any]


class AdjudicationRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """An adjudicator's own answer, and their comment on it."""

    uuid: UUID
    body: dict[str, Any]
    comment: Annotated[str, msgspec.Meta(max_length=2000)] = ""


class NoteRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A person's reason for skipping or flagging an item."""

    uuid: UUID
    reason: Annotated[str, msgspec.Meta(max_length=2000)] = ""


REQUESTS: dict[str, type[msgspec.Struct]] = {
    "draft": DraftRequest,
    "answer": AnswerRequest,
    "skip": NoteRequest,
    "flag": NoteRequest,
    "adjudicate": AdjudicationRequest,
}
T = TypeVar("T", bound=msgspec.Struct)


@blueprint.get("/session")
def session_() -> Response:
    """Return the person's role, and the token that each changing request must send."""
    with reading(installation().engine) as session:
        person = current_person(session)
    role = None if person is None else person.role
    return flask.jsonify({"signed_in": person is not None, "role": role, "csrf": generate_csrf()})


@blueprint.post("/studies/<study_name>/tasks/<task_name>/lease")
@limited(submissions)
def lease(study_name: str, task_name: str) -> Response:
    """Take an item, or keep the item that this person has."""
    task = read_task(task_name)
    # What only reads is done beside whoever writes.
    engine = installation().engine
    with reading(engine) as session:
        person, study = visit(session, study_name)
    if person is None:
        raise unknown()
    with transaction(engine) as session:
        taken = take_work(session, study, task, person, now=now())
    if not isinstance(taken, Lease):
        return json_reply({"reason": taken, "error": gettext(EXPLANATIONS[taken])}, 409)
    return json_reply(opened_page(engine, taken.item_id, person.id, installation().salt))


@blueprint.get("/items/<item_id>")
def item(item_id: str) -> Response:
    """Return an item that is or was this person's, with their draft."""
    who = _own_item(item_id).who
    return json_reply(opened_page(installation().engine, item_id, who, installation().salt))


@blueprint.post("/items/<item_id>/begin")
@limited(submissions)
def begin(item_id: str) -> Response:
    """Keep an item for somebody who has begun to work on it."""
    found = _own_item(item_id)
    with transaction(installation().engine) as session:
        return json_reply({"leased": _extended(session, found)})


@blueprint.put("/items/<item_id>/draft")
@limited(submissions)
def draft(item_id: str) -> Response:
    """Keep what somebody has done so far, and the item for them."""
    request = read_request(DraftRequest)
    found = _own_item(item_id)
    with transaction(installation().engine) as session:
        kept = save_draft(
            session, found, found.who, revision=request.revision, body=request.body, now=now()
        )
        held = kept and _extended(session, found)
    return json_reply({"kept": kept, "leased": held})


@blueprint.post("/items/<item_id>/answer")
@limited(submissions)
def answer(item_id: str) -> Response:
    """Keep an answer. The reply comes after it is safe on the disk."""
    request = read_request(AnswerRequest)
    engine = installation().engine
    with reading(engine) as session:
        found = item_of(session, item_id)
        kept = read_answer(session, found, request.body, installation().salt)
        kept = checked_watching(session, found, kept, now())
        origin = provenance(session, found, found.who, kept)
    with transaction(engine) as session:
        receipt = submit(
            session,
            found,
            found.who,
            uuid=request.uuid,
            sent=request.body,
            body=kept,
            provenance=origin,
            gist=gist_of(found.task, kept),
            odd_below_s=odd_below(found.payload, kept, origin),
            now=now(),
            adopted=task_of(found.task).adjudication is None,
        )
        if receipt.answer is not None:
            adoption.answered(session, found.task, receipt.answer)
    return json_reply({"state": receipt.state, "next": here(f"/s/{found.study_name}/{found.task}")})


@blueprint.post("/items/<item_id>/skip")
@limited(submissions)
def skip_(item_id: str) -> Response:
    """Give an item back, not to get it again."""
    request = read_request(NoteRequest)
    with transaction(installation().engine) as session:
        found = item_of(session, item_id)
        skip(session, found.id, found.who, now=now())
        _note(session, found, "skip", request)
    return json_reply({"next": here(f"/s/{found.study_name}/{found.task}")})


@blueprint.post("/items/<item_id>/flag")
@limited(submissions)
def flag(item_id: str) -> Response:
    """Report an item's fault to the people who run the study."""
    request = read_request(NoteRequest)
    with transaction(installation().engine) as session:
        found = item_of(session, item_id)
        _note(session, found, "flag", request)
    return json_reply({"kept": True})


@blueprint.get("/items/<item_id>/answers")
def answers(item_id: str) -> Response:
    """Return an item with all its answers, for those who decide between them."""
    salt = installation().salt
    with reading(installation().engine) as session:
        person = required_person(session, "adjudicator")
        found = any_item(session, item_id)
        given = select(Answer).where(Answer.item_id == item_id).order_by(Answer.id)
        listed = [
            {
                "answer": a.id,
                "adopted": a.adopted,
                "surplus": a.surplus,
                "body": task_of(found.task).sent_form(session, found, a.body, salt),
            }
            for a in session.scalars(given)
        ]
        return json_reply({**page_data(session, item_id, person.id, salt), "answers": listed})


@blueprint.post("/items/<item_id>/adjudicate")
@limited(submissions)
def adjudicate(item_id: str) -> Response:
    """Keep an adjudicator's answer to any item, and adopt it where that is due."""
    request = read_request(AdjudicationRequest)
    salt = installation().salt
    with transaction(installation().engine) as session:
        person = required_person(session, "adjudicator")
        found = any_item(session, item_id)
        kept = read_answer(session, found, request.body, salt)
        adjudicating.answer_instead(
            session,
            session.get_one(Study, found.study_id),
            found,
            person,
            sent=request.body,
            body=kept,
            comment=request.comment,
            uuid=request.uuid,
            now=now(),
        )
    return json_reply({"kept": True})


@blueprint.post("/practice/<task_name>")
@limited(submissions)
def practice(task_name: str) -> Response:
    """Keep that this person has done a practice example."""
    task = read_task(task_name)
    with transaction(installation().engine) as session:
        keep_practice(required_person(session), task)
    return json_reply({"kept": True})


def read_task(name: str) -> TaskName:
    """Return a task by its name; refuse if there is none."""
    if find_task(name) is None:
        raise Refusal(404, gettext("There is no such task."))
    return name


def read_request(record_type: type[T]) -> T:
    """Return the JSON that was sent; refuse it if it has another form."""
    try:
        request = msgspec.json.decode(flask.request.get_data(), type=record_type)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise Refusal(400, gettext("The request can't be read: %(why)s", why=error)) from error
    check_json(msgspec.to_builtins(request))
    return request


def any_item(session: Session, item_id: str) -> Item:
    """Return an item, regardless of its holder; refuse if there is none."""
    found = session.get(Item, item_id)
    if found is None:
        raise Refusal(404, gettext("There is no such item."))
    return found


def _own_item(item_id: str) -> Work:
    """Return an item of the requesting person, read without waiting for writers."""
    with reading(installation().engine) as session:
        return item_of(session, item_id)


def _extended(session: Session, item: Work) -> bool:
    """Lease an item on to its holder; return True if they still had it."""
    until = lease_s(restored(item.config), item.task)
    return extend(session, item.id, item.who, now=now(), lease_s=until)


def _note(session: Session, item: Work, name: Any, request: NoteRequest) -> None:
    if not was_received(session, item.who, request.uuid):
        body = {"reason": request.reason}
        add_event(session, item, item.who, name=name, uuid=request.uuid, body=body, now=now())


def json_reply(value: object, status: int = 200) -> Response:
    """Return an answer in JSON, of records too."""
    return Response(msgspec.json.encode(value), status, mimetype="application/json")
