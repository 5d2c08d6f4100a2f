"""Collected data for programs: the answers, the reports, and their review."""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated, Literal

import flask
import msgspec
from flask import Blueprint, Response

from annotation_app.dashboard import answer_browsing as browsing
from annotation_app.dashboard.answer_pages import act, answer_of
from annotation_app.dashboard.dashboard_pages import export_response
from annotation_app.store.database import reading
from annotation_app.store.installation import installation
from annotation_app.web.api import json_reply, read_request
from annotation_app.web.limits import limited, reads, submissions
from annotation_app.web.who_asks import changed_by, required_reader
from annotation_app.work.handing_out import find_study

blueprint = Blueprint("answers_interface", __name__, url_prefix="/api/dashboard/studies")


class ReviewRequest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """An action on an answer, and its reason."""

    action: Literal["exclude", "redo", "restore", "comment"]
    text: Annotated[str, msgspec.Meta(max_length=2000)] = ""


REQUESTS: dict[str, type[msgspec.Struct]] = {"review_answer": ReviewRequest}
QUERIES = {
    "read_answers": ("task", "person", "video", "state", "flagged", "text", "order", "before"),
    "read_reports": ("before",),
}
"""Parameters that addresses may have, by view."""


@blueprint.get("/<study_name>/answers")
@limited(reads)
def read_answers(study_name: str) -> Response:
    """Return answers, newest first, a page at a time."""
    wanted = browsing.read_wanted(flask.request.args)
    with reading(installation().engine) as session:
        required_reader(session, "adjudicator")
        study = find_study(session, study_name)
        found, older = browsing.find_answers(session, study.id, wanted)
    return json_reply({"study": study_name, "data": found, "before": older})


@blueprint.get("/<study_name>/answers/<answer_id>")
@limited(reads)
def read_answer(study_name: str, answer_id: str) -> Response:
    """Return an answer, with reviewers' remarks about it."""
    with reading(installation().engine) as session:
        required_reader(session, "adjudicator")
        study = find_study(session, study_name)
        found = answer_of(session, study, _number(answer_id))
        (one,) = browsing.shown(session, study.id, [found.id])
        said = browsing.remarks(session, found.id)
    return json_reply({**asdict(one), "remarks": said})


@blueprint.post("/<study_name>/answers/<answer_id>/review")
@limited(submissions)
def review_answer(study_name: str, answer_id: str) -> Response:
    """Exclude an answer, have it redone, restore it, or comment on it."""
    request = read_request(ReviewRequest)
    with changed_by("adjudicator") as (session, person):
        study = find_study(session, study_name)
        found = answer_of(session, study, _number(answer_id))
        act(session, study, found, person, action=request.action, text=request.text)
        (one,) = browsing.shown(session, study.id, [found.id])
    return json_reply(one)


@blueprint.get("/<study_name>/reports")
@limited(reads)
def read_reports(study_name: str) -> Response:
    """Return reported problems and skipped items, newest first, a page at a time."""
    before = browsing.read_before(flask.request.args)
    with reading(installation().engine) as session:
        required_reader(session, "adjudicator")
        study = find_study(session, study_name)
        found, older = browsing.find_reports(session, study.id, before=before)
    return json_reply({"study": study_name, "data": found, "before": older})


@blueprint.get("/<study_name>/export/<form>")
@limited(reads)
def read_export(study_name: str, form: str) -> Response:
    """Return a file of all answers, or of the corpus made of them, as on the dashboard."""
    return export_response(study_name, form)


def _number(text: str) -> int:
    """Read the id that an address names; an id of nothing if it is no number."""
    return int(text) if text.isascii() and text.isdigit() and len(text) < 10 else 0
