"""Pages on which researchers read what was collected, and review it, also many at once."""

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
from annotation_app.export.answer_tables import chosen_to_csv
from annotation_app.items.item_scenes import beside_video
from annotation_app.store.audit import name_of, note
from annotation_app.store.installation import installation, now
from annotation_app.store.models import Answer, Item, Person, Record, Study
from annotation_app.tasks.task_registry import find_task, task_names, task_of
from annotation_app.web.who_asks import changed_by, refused, refused_on, seen_by
from annotation_app.work import adjudicating, reviewing
from annotation_app.work.handing_out import find_study

EXPORT = "export"
ACTS = {
    "exclude": "Exclude",
    "redo": "Redo",
    "restore": "Restore",
    "adopt": "Adopt",
    EXPORT: "Export (CSV)",
}
"""Acts on several answers, and their names on the page."""
DONE = {
    "exclude": "excluded",
    "redo": "excluded, to be redone",
    "restore": "restored",
    "adopt": "adopted",
}

blueprint = Blueprint("answer_pages", __name__, url_prefix="/dashboard")
blueprint.register_error_handler(Refusal, refused)


@blueprint.get("/<study_name>/answers")
def answers(study_name: str) -> str:
    """Show people's answers, newest first."""
    wanted = browsing.read_wanted(flask.request.args)
    with seen_by("adjudicator") as (session, person):
        study = find_study(session, study_name)
        found, older = browsing.find_answers(session, study.id, wanted)
        return flask.render_template(
            "dashboard/answers.html",
            person=person,
            study=study,
            wanted=wanted,
            found=[(one, _summary(session, one)) for one in found],
            older=older,
            tasks=task_names(),
            states=browsing.STATES,
            videos=browsing.videos(session, study.id),
            people=browsing.people(session, study.id),
            orders=browsing.ORDERS,
            count=browsing.count_answers(session, study.id, wanted),
            acts=ACTS,
            longest=reviewing.LONGEST_REMARK,
            files=browsing.posters(session, study.id, [one.video for one in found]),
        )


def _answer_page(
    session: Session, person: Person, study_name: str, answer_id: int, problem: str = ""
) -> str:
    study = find_study(session, study_name)
    found = answer_of(session, study, answer_id)
    item = session.get_one(Item, found.item_id)
    (one,) = browsing.shown(session, study.id, [found.id])
    task = find_task(item.task)
    adjudication = None if task is None else task.adjudication
    return flask.render_template(
        "dashboard/answer.html",
        person=person,
        study=study,
        one=one,
        compared=adjudication
        and adjudication.compare(session, item, [found.body], installation().salt),
        facts=_facts(session, item, found.body),
        watched=_watched(found.body),
        files=browsing.posters(session, study.id, [one.video]).get(one.video, {}),
        beside=beside_video(session, study.id, one.video),
        remarks=browsing.remarks(session, found.id),
        reports=browsing.find_reports(session, study.id, item=item.id, most=None)[0],
        problem=problem,
        typed=flask.request.form.get("text", ""),
        longest=reviewing.LONGEST_REMARK,
    )


@blueprint.get("/<study_name>/answers/<int:answer_id>")
def answer(study_name: str, answer_id: int) -> str:
    """Show an answer, with all remarks about it."""
    with seen_by("adjudicator") as (session, person):
        return _answer_page(session, person, study_name, answer_id)


@blueprint.post("/<study_name>/answers/<int:answer_id>")
@refused_on(_answer_page, "adjudicator")
def review(study_name: str, answer_id: int) -> ResponseReturnValue:
    """Exclude an answer, have it redone, restore it, or comment on it."""
    form = flask.request.form
    with changed_by("adjudicator") as (session, person):
        study = find_study(session, study_name)
        found = answer_of(session, study, answer_id)
        action, text = form.get("action", ""), form.get("text", "")
        act(session, study, found, person, action=action, text=text)
    address = flask.url_for("answer_pages.answer", study_name=study_name, answer_id=answer_id)
    return flask.redirect(address, 303)


@blueprint.get("/<study_name>/reports")
def reports(study_name: str) -> str:
    """Show the problems that people reported, and their reasons for skipping items."""
    before = browsing.read_before(flask.request.args)
    with seen_by("adjudicator") as (session, person):
        study = find_study(session, study_name)
        found, older = browsing.find_reports(session, study.id, before=before)
        return flask.render_template(
            "dashboard/reports.html", person=person, study=study, found=found, older=older
        )


def act(
    session: Session, study: Study, found: Answer, person: Person, *, action: str, text: str
) -> None:
    """Carry out a reviewer's action; refused if it is unknown, or impossible."""
    if action in ("exclude", "redo"):
        again = action == "redo"
        reviewing.exclude(session, study, found, person, text, again=again, now=now())
    elif action == "restore":
        reviewing.restore(session, study, found, person, now=now())
    elif action == "comment":
        reviewing.comment(session, study, found, person, text, now=now())
    else:
        raise Refusal(404, "There is no such action.")


def answer_of(session: Session, study: Study, answer_id: int) -> Answer:
    """Return an answer of a study; refused if there is none."""
    found = session.get(Answer, answer_id) if answer_id < 2**31 else None
    if found is None or session.get_one(Item, found.item_id).study_id != study.id:
        raise Refusal(404, "There is no such answer.")
    return found


def _facts(session: Session, item: Item, body: Record) -> list[tuple[str, str]]:
    """Return what an answer says, in words."""
    task = find_task(item.task)
    return [] if task is None else list(task.facts(session, item, body))


def _summary(session: Session, found: browsing.FoundAnswer) -> str:
    """Return what an answer says in a line; nothing where the list shows it already."""
    facts = _facts(session, session.get_one(Item, found.item), found.body)
    return "; ".join(f"{name}: {value}" if name else value for name, value in facts)


def _watched(body: Record) -> str:
    """Return how long videos were played, and how fast; empty if that isn't known."""
    if not body.get("watched_s"):
        return ""
    speed = body.get("speed") or 1
    return f"{body['watched_s']:.0f} s" + (f", at up to {speed:g}×" if speed > 1 else "")


MOST = 1000
"""Largest number of answers that one request changes or exports."""


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
                    _act_on_one(session, study, person, answer_id, action)
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


def _act_on_one(
    session: Session, study: Study, person: Person, answer_id: int, action: str
) -> None:
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
