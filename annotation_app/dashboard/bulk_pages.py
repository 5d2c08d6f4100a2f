"""Acts on many answers at once: those that are ticked, or all that a filter lets through."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any
from uuid import uuid4

import flask
from flask import Blueprint, Response
from flask.typing import ResponseReturnValue
from sqlalchemy.orm import Session

from annotation_app.core.problems import Refusal
from annotation_app.dashboard import answer_browsing as browsing
from annotation_app.dashboard.answer_pages import ACTS, DONE, EXPORT, act, answer_of
from annotation_app.export.answer_tables import chosen_to_csv
from annotation_app.store.audit import name_of, note
from annotation_app.store.installation import now
from annotation_app.store.models import Item, Person, Study
from annotation_app.tasks.task_registry import task_of
from annotation_app.web.who_asks import changed_by, refused
from annotation_app.work import adjudicating
from annotation_app.work.handing_out import find_study

MOST = 1000
"""Largest number of answers that one request changes or exports."""
blueprint = Blueprint("bulk_pages", __name__, url_prefix="/dashboard")
blueprint.register_error_handler(Refusal, refused)


@blueprint.post("/<study_name>/answers")
def act_on_many(study_name: str) -> ResponseReturnValue:
    """Carry out an act on many answers, and count those that it was refused for."""
    form = flask.request.form
    action, wanted = form.get("action", ""), browsing.read_wanted(form)
    done, problems = 0, list[str]()
    with changed_by("adjudicator") as (session, person):
        if action not in ACTS:
            raise Refusal(404, "There is no such action.")
        study = find_study(session, study_name)
        chosen = _chosen(session, study, wanted)
        if action == EXPORT:
            return _exported(session, study, person, chosen)
        for answer_id in chosen:
            try:
                with session.begin_nested():
                    _act(session, study, person, answer_id, action)
                done += 1
            except Refusal as refusal:
                problems.append(refusal.message)
    told = f"{done} {DONE[action]}."
    if problems:
        told += f" {len(problems)} not: {problems[0]}"
    flask.flash(told)
    asked: dict[str, Any] = {"study_name": study_name, **wanted.parameters()}
    return flask.redirect(flask.url_for("answer_pages.answers", **asked), 303)


def _chosen(session: Session, study: Study, wanted: browsing.Wanted) -> Sequence[int]:
    form = flask.request.form
    if form.get("all") == "yes":
        chosen = browsing.ids_of_all(session, study.id, wanted, MOST + 1)
    else:
        ticked = [one for one in form.getlist("answer") if one.isascii() and one.isdigit()]
        chosen = sorted({int(one[:10]) for one in ticked})
    if not chosen:
        raise Refusal(422, "Tick the answers first.")
    if len(chosen) > MOST:
        raise Refusal(422, f"Choose at most {MOST} answers at once: narrow the filter.")
    return chosen


def _act(session: Session, study: Study, person: Person, answer_id: int, action: str) -> None:
    found = answer_of(session, study, answer_id)
    if action != "adopt":
        act(session, study, found, person, action=action, text=flask.request.form.get("reason", ""))
        return
    item = session.get_one(Item, found.item_id)
    if task_of(item.task).adjudication is None:
        raise Refusal(409, "Answers to this task are adopted at once.")
    if browsing.adopted_now(session, item) == found.id:
        raise Refusal(409, "This answer is adopted already.")
    adjudicating.choose(
        session,
        study,
        item,
        person,
        found.id,
        comment=flask.request.form.get("reason", ""),
        uuid=str(uuid4()),
        now=now(),
    )


def _exported(session: Session, study: Study, person: Person, chosen: Sequence[int]) -> Response:
    file = io.BytesIO()
    chosen_to_csv(session, study, file, chosen)
    note(session, name_of(person), "exported", study.name, format="csv", answers=len(chosen))
    response = Response(file.getvalue(), mimetype="text/csv")
    name = f"{study.name}-answers-chosen.csv"
    response.headers["Content-Disposition"] = f'attachment; filename="{name}"'
    return response
