"""The dashboard's numbers for programs. Nothing can be changed here."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import msgspec
from flask import Blueprint, Response
from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.dashboard.adjudication_queue import Dispute, disputes
from annotation_app.dashboard.consensus import Agreement, agreement
from annotation_app.dashboard.study_statistics import (
    Duration,
    Progress,
    collected,
    collected_type,
    durations,
    progress_by_task,
    progress_by_video,
)
from annotation_app.dashboard.workers import Worker, workers
from annotation_app.people.browser_sessions import required_person
from annotation_app.store.database import reading
from annotation_app.store.installation import installation, now
from annotation_app.store.models import Role, Study
from annotation_app.tasks.task_registry import task_names
from annotation_app.work.handing_out import find_study

blueprint = Blueprint("dashboard_interface", __name__, url_prefix="/api/dashboard")


@blueprint.get("/studies")
def studies() -> Response:
    """The names of all studies."""
    with reading(installation().engine) as session:
        required_person(session, "annotator")
        return _reply({"studies": list(session.scalars(select(Study.name).order_by(Study.name)))})


@blueprint.get("/studies/<study_name>/progress")
def progress(study_name: str) -> Response:
    """Answers wanted, given and being given, by task."""
    return _of(
        study_name,
        "annotator",
        lambda session, study_id: progress_by_task(progress_by_video(session, study_id, now=now())),
    )


@blueprint.get("/studies/<study_name>/videos")
def videos(study_name: str) -> Response:
    """Answers wanted, given and being given, by task and video."""
    return _of(
        study_name,
        "adjudicator",
        lambda session, study_id: progress_by_video(session, study_id, now=now()),
    )


@blueprint.get("/studies/<study_name>/times")
def times(study_name: str) -> Response:
    """Quartiles of the time that items take."""
    return _of(study_name, "annotator", durations)


@blueprint.get("/studies/<study_name>/corpus")
def corpus(study_name: str) -> Response:
    """What has been collected."""
    return _of(study_name, "annotator", collected)


@blueprint.get("/studies/<study_name>/agreement")
def agreement_(study_name: str) -> Response:
    """How much people agree."""
    return _of(study_name, "adjudicator", agreement)


@blueprint.get("/studies/<study_name>/people")
def people(study_name: str) -> Response:
    """Everybody who has answered, and what is odd about it."""
    return _of(study_name, "adjudicator", workers)


@blueprint.get("/studies/<study_name>/queue")
def queue(study_name: str) -> Response:
    """What people disagree about."""
    return _of(study_name, "adjudicator", disputes)


_VIEWS: dict[str, tuple[Callable[..., Response], Any]] = {
    "progress": (progress, list[Progress]),
    "videos": (videos, list[Progress]),
    "times": (times, list[Duration]),
    "corpus": (corpus, collected_type()),
    "agreement": (agreement_, list[Agreement]),
    "people": (people, list[Worker]),
    "queue": (queue, list[Dispute]),
}
"""What answers each path, and the type of the ``data`` in its answer."""


def paths() -> dict[str, Any]:
    """The part of this interface in the OpenAPI description."""
    parameter = {
        "name": "study",
        "in": "path",
        "required": True,
        "schema": {"type": "string", "minLength": 1},
    }
    names = {"type": "array", "items": {"type": "string"}}
    found: dict[str, Any] = {
        "/api/dashboard/studies": {
            "get": _operation("studies", studies, _object(studies=names), ())
        }
    }
    for (name, (view, _)), data in zip(_VIEWS.items(), _described()[0], strict=True):
        reply = _object(study={"type": "string"}, at={"type": "number"}, data=data)
        found[f"/api/dashboard/studies/{{study}}/{name}"] = {
            "parameters": [parameter],
            "get": _operation(name, view, reply, (404,)),
        }
    return found


def schemas() -> dict[str, Any]:
    """What :func:`paths` refers to. The types of records can't tell which tasks there are."""
    found = _described()[1]
    names = sorted(task_names())
    for schema in found.values():
        if "task" in schema["properties"]:
            schema["properties"]["task"] = {"enum": names}
    return found


def _described() -> tuple[Any, dict[str, Any]]:
    return msgspec.json.schema_components(
        (data for _, data in _VIEWS.values()), ref_template="#/components/schemas/{name}"
    )


def _object(**properties: Any) -> dict[str, Any]:
    return {"type": "object", "required": [*properties], "properties": properties}


def _operation(
    name: str, view: Callable[..., Response], schema: dict[str, Any], refusals: tuple[int, ...]
) -> dict[str, Any]:
    json = "application/json"
    reply = {"description": "Done", "content": {json: {"schema": schema}}}
    error = {"$ref": "#/components/schemas/Error"}
    refused = {"description": "Refused, and why", "content": {json: {"schema": error}}}
    return {
        "operationId": f"dashboard_{name}",
        "summary": (view.__doc__ or "").rstrip("."),
        "responses": {
            "200": reply,
            **{str(status): refused for status in (401, 403, 429, *refusals)},
        },
    }


def _of(study_name: str, role: Role, compute: Callable[[Session, str], Any]) -> Response:
    with reading(installation().engine) as session:
        required_person(session, role)
        study = find_study(session, study_name)
        return _reply({"study": study.name, "at": now(), "data": compute(session, study.id)})


def _reply(value: Any) -> Response:
    return Response(msgspec.json.encode(value), mimetype="application/json")
