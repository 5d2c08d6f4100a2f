"""The page of what people disagree on most."""

from __future__ import annotations

from typing import Any

import flask
from flask import Blueprint

from annotation_app.core.problems import Refusal
from annotation_app.dashboard.disagreements import Disagreement, disagreements
from annotation_app.tasks.agreement import CLAUSE_TYPE, WORDS
from annotation_app.tasks.task_registry import task_of
from annotation_app.web.who_asks import refused, seen_by
from annotation_app.work.handing_out import find_study

blueprint = Blueprint("disagreement_pages", __name__, url_prefix="/dashboard")
blueprint.register_error_handler(Refusal, refused)


@blueprint.get("/<study_name>/disagreements", endpoint="disagreements")
def disagreements_page(study_name: str) -> str:
    """On what people disagree most, and where it can be looked at."""
    with seen_by("adjudicator") as (session, person):
        study = find_study(session, study_name)
        found = disagreements(session, study.id)
        return flask.render_template(
            "dashboard/disagreements.html",
            person=person,
            study=study,
            found=[(one, _link(study.name, one)) for one in found],
        )


def _link(study_name: str, one: Disagreement) -> str:
    if one.kind == "item" and task_of(one.task).adjudication is not None:
        return flask.url_for("adjudication.dispute", study_name=study_name, item_id=one.what)
    asked = {"task": one.task}
    if one.kind == WORDS:
        asked["text"] = one.what
    elif one.kind == "item":
        asked |= {"text": one.command, "video": one.video}
    elif one.kind not in ("task", CLAUSE_TYPE):
        asked["video"] = one.video
    values: dict[str, Any] = {"study_name": study_name, **asked}
    return flask.url_for("answer_pages.answers", **values)
