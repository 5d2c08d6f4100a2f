"""The dashboard's numbers for programs. Nothing can be changed here."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import msgspec
from flask import Blueprint, Response
from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.dashboard.adjudication_queue import Dispute, disputes
from annotation_app.dashboard.consensus import Disagreement, agreement, disagreements
from annotation_app.dashboard.study_statistics import (
    Duration,
    History,
    Progress,
    SuggestionUse,
    collected,
    collected_type,
    durations,
    histories,
    model_errors,
    progress_by_task,
    progress_by_video,
    suggestion_uses,
)
from annotation_app.dashboard.workers import Worker, workers
from annotation_app.store.database import reading
from annotation_app.store.installation import installation, now
from annotation_app.store.models import Role, Study
from annotation_app.tasks.agreement import Measured, ModelErrors
from annotation_app.tasks.task_registry import task_names
from annotation_app.web.api import json_reply
from annotation_app.web.limits import limited, reads
from annotation_app.web.who_asks import required_reader
from annotation_app.work.handing_out import find_study

READERS: list[dict[str, list[str]]] = [{"session": []}, {"token": []}]
"""Readers in OpenAPI's form: people with a login, and programs."""

blueprint = Blueprint("dashboard_interface", __name__, url_prefix="/api/dashboard")


@blueprint.get("/studies")
@limited(reads)
def studies() -> Response:
    """Return the names of all studies."""
    with reading(installation().engine) as session:
        required_reader(session, "annotator")
        return json_reply(
            {"studies": list(session.scalars(select(Study.name).order_by(Study.name)))}
        )


class _View(NamedTuple):
    """A path about a study: who may read it, its data, their type, and what they are."""

    role: Role
    compute: Callable[[Session, str], Any]
    type: Any
    summary: str


def _progress(session: Session, study_id: str) -> list[Progress]:
    return progress_by_task(_by_video(session, study_id))


def _by_video(session: Session, study_id: str) -> list[Progress]:
    return progress_by_video(session, study_id, now=now())


def _history(session: Session, study_id: str) -> list[History]:
    return histories(session, study_id, now=now())


_GIVEN = "Answers wanted, given and being given, by task"
_VIEWS = {
    "progress": _View("annotator", _progress, list[Progress], _GIVEN),
    "videos": _View("adjudicator", _by_video, list[Progress], f"{_GIVEN} and video"),
    "times": _View("annotator", durations, list[Duration], "Quartiles of the time that items take"),
    "history": _View("annotator", _history, list[History], "How the answers to each task came"),
    "suggestions": _View(
        "annotator", suggestion_uses, list[SuggestionUse], "How often suggestions were changed"
    ),
    "model-errors": _View(
        "adjudicator",
        model_errors,
        list[ModelErrors],
        "Errors of models that people corrected",
    ),
    "corpus": _View("annotator", collected, collected_type(), "What has been collected"),
    "agreement": _View("adjudicator", agreement, list[Measured], "How much people agree"),
    "disagreements": _View(
        "adjudicator", disagreements, list[Disagreement], "What people disagree about most"
    ),
    "people": _View(
        "adjudicator",
        partial(workers, weighed=True),
        list[Worker],
        "Who has answered, and what is odd",
    ),
    "queue": _View("adjudicator", disputes, list[Dispute], "What people disagree about"),
}


def _answering(view: _View) -> Callable[..., Response]:
    @limited(reads)
    def answer(study_name: str) -> Response:
        with reading(installation().engine, one_state=True) as session:
            required_reader(session, view.role)
            study = find_study(session, study_name)
            data = view.compute(session, study.id)
            return json_reply({"study": study.name, "at": now(), "data": data})

    answer.__doc__ = view.summary
    return answer


for _name, _view in _VIEWS.items():
    blueprint.add_url_rule(f"/studies/<study_name>/{_name}", _name, _answering(_view))


def replies() -> dict[str, Any]:
    """Return the type of each view's reply, by the view's name, for the OpenAPI description."""
    found = {"studies": _object(studies={"type": "array", "items": {"type": "string"}})}
    for name, data in zip(_VIEWS, _described()[0], strict=True):
        found[name] = _object(study={"type": "string"}, at={"type": "number"}, data=data)
    return found


def schemas() -> dict[str, Any]:
    """Return the schemas named in :func:`replies`. The types of records don't list the tasks."""
    found = _described()[1]
    names = sorted(task_names())
    for schema in found.values():
        if "task" in schema["properties"]:
            schema["properties"]["task"] = {"enum": names}
    return found


def _described() -> tuple[Any, dict[str, Any]]:
    return msgspec.json.schema_components(
        (view.type for view in _VIEWS.values()), ref_template="#/components/schemas/{name}"
    )


def _object(**properties: Any) -> dict[str, Any]:
    return {"type": "object", "required": [*properties], "properties": properties}
