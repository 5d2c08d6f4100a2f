"""The last step: changes, changes that alter earlier answers, and writing the file."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import flask
import msgspec
from flask import Blueprint
from flask.typing import ResponseReturnValue
from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.core.problems import Refusal
from annotation_app.making.step_pages import opened_draft, page_values
from annotation_app.making.steps import StepProblem, of_videos, parts_of, problems_of
from annotation_app.store.audit import name_of, note
from annotation_app.store.installation import installation
from annotation_app.store.models import Person, Study
from annotation_app.studies.study_file import StudyConfig
from annotation_app.study_setup.readiness import (
    Obstacle,
    obstacles,
    people_by_role,
    study_obstacles,
)
from annotation_app.study_setup.study_changes import Change, asked_so_far, changes
from annotation_app.study_setup.study_drafts import (
    StudyDraft,
    comments,
    drop_draft,
    in_order,
    sha256_of,
    write_study,
)
from annotation_app.study_setup.study_reading import read_study
from annotation_app.study_setup.study_starting import (
    StudyParts,
    changed_since_asked,
    prepare_parts,
    put_parts,
)
from annotation_app.tasks.task_registry import find_task
from annotation_app.web.public_links import public
from annotation_app.web.who_asks import cannot_be_done, changed_by, refused, seen_by
from annotation_app.work.assigning import group_sizes
from annotation_app.work.handing_out import find_study
from g3.errors import CorpusError

LONGEST_NOTE = 4000

blueprint = Blueprint("making_review", __name__, url_prefix="/admin/studies")
blueprint.register_error_handler(Refusal, refused)
blueprint.register_error_handler(CorpusError, cannot_be_done)


@dataclass(frozen=True, slots=True)
class Review:
    """Facts to review before a draft becomes a study's file."""

    parts: StudyParts | None
    """Parts of the study; None if the draft has faults."""
    problems: list[StepProblem]
    changes: list[Change]
    """Differences from the running study."""
    comments: list[str]
    """People's own comments in the file, which are not kept."""
    obstacles: list[str]
    """Obstacles to people's work."""

    @property
    def altering(self) -> list[Change]:
        """Changes that alter items or texts that people have already had."""
        return [change for change in self.changes if change.alters]


@blueprint.get("/<name>/review")
def review(name: str) -> str:
    """Show the draft's faults, changes, and obstacles to people's work."""
    with seen_by("admin") as (session, admin):
        draft = opened_draft(session, name)
        return _page(admin, draft, _review(session, draft))


@blueprint.post("/<name>/review")
def start(name: str) -> ResponseReturnValue:
    """Write the study's file, and start the study or bring it up to date."""
    setup = installation().config
    with seen_by("admin") as (session, admin):
        draft = opened_draft(session, name)
        found = _review(session, draft)
        refusal = _refusal(found)
        if refusal or found.parts is None:
            return _page(admin, draft, found, refusal), 422
    ready = prepare_parts(found.parts, setup)  # people go on with their work meanwhile
    with changed_by("admin") as (session, admin):
        if _clashes(draft, session.scalars(select(Study).where(Study.name == name)).first()):
            raise Refusal(409, "Somebody else has changed this study just now. Open it again.")
        put_parts(session, found.parts, ready, installation().salt)
        session.flush()
        kept = write_study(draft.file, in_order(draft.value) if draft.is_new else draft.value)
        details = {"file": str(draft.file)}
        if kept:
            details["before"] = kept
        if found.changes:
            details["changed"] = ", ".join(c.field for c in found.changes)[:LONGEST_NOTE]
        if found.altering:
            told = "; ".join(f"{c.field}: {c.alters}" for c in found.altering)
            details["confirmed"] = told[:LONGEST_NOTE]
        action = "made a study" if draft.is_new else "changed a study"
        note(session, name_of(admin), action, draft.name, **details)
    drop_draft(setup.studies_folder, draft.name)
    for task_name in found.parts.config.tasks:
        task = find_task(task_name)
        if task is not None and task.warm_up is not None:
            task.warm_up()
    return flask.redirect(flask.url_for(".started", name=name), 303)


@blueprint.get("/<name>/started")
def started(name: str) -> str:
    """Show the address to send to people, and the obstacles to their work."""
    with seen_by("admin") as (session, admin):
        study = find_study(session, name)
        config = msgspec.convert(study.config, StudyConfig)
        return flask.render_template(
            "making/started.html",
            person=admin,
            study=study,
            link=public("entrance.study_page", study_name=name),
            access=config.access,
            roles={task.role for task in config.tasks.values()},
            obstacles=_sentences(
                one for one in obstacles(session, of_installation=False) if one.study == name
            ),
        )


def _review(session: Session, draft: StudyDraft) -> Review:
    parts, problems = parts_of(installation().config.studies_folder, draft)
    problems = [*problems_of(draft), *problems]
    study = session.scalars(select(Study).where(Study.name == draft.name)).first()
    problems += _clashes(draft, study)
    if problems or parts is None:
        return Review(None, problems, [], [], [])
    config = msgspec.convert(draft.value, StudyConfig)
    parts = replace(parts, config=config)
    if replaced := changed_since_asked(session, parts):
        return Review(None, [of_videos(error) for error in replaced], [], [], [])
    changed, lost = [], []
    if study is not None and not draft.is_new:
        changed = changes(read_study(draft.file), config, asked_so_far(session, study))
        lost = comments(draft.file.read_bytes())
    logins = people_by_role(session)
    known, sizes = parts.things_known, group_sizes(session)
    stopping = study_obstacles(config, logins, {}, things_known=known, groups=sizes)
    return Review(parts, [], changed, lost, _sentences(stopping))


def _clashes(draft: StudyDraft, study: Study | None) -> list[StepProblem]:
    """Return a problem if somebody else has made or changed the study meanwhile."""
    if draft.value.get("name") != draft.name:
        what = "The study's name can't be changed any more."
    elif draft.is_new and (study is not None or draft.file.exists()):
        what = f"There is a study {draft.name} already."
    elif not draft.is_new and sha256_of(draft.file) != draft.base:
        what = (
            "Somebody has changed the study's file since you began. Discard these changes and "
            "begin again, so that theirs aren't lost."
        )
    else:
        return []
    return [StepProblem("videos", "", what)]


def _sentences(found: Iterable[Obstacle]) -> list[str]:
    return [f"{one.what[:1].upper()}{one.what[1:]}." for one in found]


def _refusal(found: Review) -> str:
    form = flask.request.form
    if found.problems:
        return "Put right what is listed first."
    if found.altering and "confirm" not in form:
        return "Confirm that you want to change what people were asked already."
    if found.comments and "comments" not in form:
        return "Confirm that the comments in the file go."
    return ""


def _page(admin: Person, draft: StudyDraft, found: Review, refusal: str = "") -> str:
    return flask.render_template(
        "making/review.html",
        person=admin,
        draft=draft,
        found=found,
        refusal=refusal,
        ticked=flask.request.form,
        **page_values(draft),
    )
