"""The pages on which admins make and change studies, step by step."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import flask
import msgspec
from flask import Blueprint
from flask.typing import ResponseReturnValue
from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.core.languages import language_name, languages
from annotation_app.core.problems import Refusal
from annotation_app.making.added_files import added_files
from annotation_app.making.step_forms import AS_BEFORE, read_form, text_of
from annotation_app.making.steps import (
    REVIEW,
    STEPS,
    Step,
    StepProblem,
    defaults,
    page_after,
    parts_of,
    problems_of,
    target,
    task_defaults,
)
from annotation_app.store.installation import installation
from annotation_app.store.models import Person, Study
from annotation_app.studies.study_file import StudyConfig
from annotation_app.studies.study_template import slug
from annotation_app.study_setup.own_videos import OwnVideo
from annotation_app.study_setup.readiness import people_by_role
from annotation_app.study_setup.rendered_study import Rendered
from annotation_app.study_setup.server_folders import command_tables, files_ending, video_choices
from annotation_app.study_setup.study_drafts import (
    StudyDraft,
    begun,
    drafts,
    drop_draft,
    find_draft,
    is_name,
    keep_draft,
)
from annotation_app.study_setup.study_reading import study_problems
from annotation_app.study_setup.study_starting import StudyParts
from annotation_app.tasks.task_registry import tasks
from annotation_app.web.public_links import here
from annotation_app.web.who_asks import cannot_be_done, refused, seen_by
from annotation_app.work.assigning import group_sizes
from g3.errors import CorpusError

ADOPTIONS = {
    "all": "all agree",
    "majority": "more than half agree",
    "0.66": "two thirds agree",
    "0.75": "three quarters agree",
    "adjudicator": "an adjudicator adopts it",
}
"""Rules of adoption as the study's file has them, and as people read them."""

blueprint = Blueprint(
    "making",
    __name__,
    url_prefix="/admin/studies",
    template_folder="templates",
    static_folder="static",
)
blueprint.register_error_handler(Refusal, refused)
blueprint.register_error_handler(CorpusError, cannot_be_done)


@blueprint.get("/new")
def new() -> str:
    """Show the form for a new study's title and name."""
    with seen_by("admin") as (_, admin):
        return _new_page(admin)


@blueprint.post("/new")
def begin() -> ResponseReturnValue:
    """Begin a draft of a new study."""
    folder, form = installation().config.studies_folder, flask.request.form
    title, robot = text_of(form, "title")[:1000], text_of(form, "robot")[:1000]
    with seen_by("admin") as (session, admin):
        name = text_of(form, "name") or slug(title)
        problem = _name_problem(session, title, name)
    if problem:
        return _new_page(admin, problem), 422
    value = {
        "name": name,
        "title": title,
        "robot": robot or "robot",
        "tasks": {
            task.name: {}
            for task in tasks()
            if not task.needs_scenes and (task.gives or task.sources)
        },
    }
    keep_draft(folder, StudyDraft(name, folder / f"{name}.yaml"), value)
    return flask.redirect(flask.url_for(".step", name=name, step_name=STEPS[0].name), 303)


@blueprint.get("/<name>/<step_name>")
def step(name: str, step_name: str) -> str:
    """Show a step's form."""
    with seen_by("admin") as (session, admin):
        draft = opened_draft(session, name)
        return _step_page(session, admin, draft, _step(step_name).name)


@blueprint.post("/<name>/<step_name>")
def save(name: str, step_name: str) -> ResponseReturnValue:
    """Keep what was typed; go on to the next step if all is well in this one."""
    config, form = installation().config, flask.request.form
    with seen_by("admin") as (session, admin):
        draft = opened_draft(session, name)
        value = read_form(_step(step_name).name, draft, form, config.studies_folder)
        draft = keep_draft(config.studies_folder, draft, value)
        wanted = form.get("then", "")
        if wanted == "stay":
            return flask.redirect(here(flask.request.path), 303)
        if wanted.startswith("preview"):
            return flask.redirect(
                flask.url_for("making_previews.preview", name=name, page=wanted[8:] or "-"), 303
            )
        problems = step_problems(draft, step_name)
        if problems:
            return _step_page(session, admin, draft, step_name, problems), 422
    following = page_after(step_name)
    if following == REVIEW:
        return flask.redirect(flask.url_for("making_review.review", name=name), 303)
    return flask.redirect(flask.url_for(".step", name=name, step_name=following), 303)


@blueprint.post("/<name>/discard")
def discard(name: str) -> ResponseReturnValue:
    """Forget a draft: a running study stays as it is."""
    with seen_by("admin") as (session, _):
        draft = opened_draft(session, name)
    drop_draft(installation().config.studies_folder, draft.name)
    return flask.redirect(flask.url_for("dashboard.studies"), 303)


@blueprint.app_template_global("study_drafts")
def unfinished() -> list[str]:
    """Return the names of the unfinished studies."""
    return drafts(installation().config.studies_folder)


def opened_video(name: str, number: int) -> tuple[StudyDraft, Rendered | OwnVideo]:
    """Return a study's draft and one of its videos for an admin; refuse if there is none."""
    with seen_by("admin") as (session, _):
        draft = opened_draft(session, name)
    parts, _ = parts_of(installation().config.studies_folder, draft, are_played=False)
    if parts is None or number >= len(parts.videos):
        raise Refusal(404, "There is no such video.")
    return draft, parts.videos[number]


def opened_draft(session: Session, name: str) -> StudyDraft:
    """Return a study's draft, or a new one of a running study's file; refuse if there is none."""
    folder = installation().config.studies_folder
    draft = find_draft(folder, name) if is_name(name) else None
    if draft is not None:
        return draft
    study = session.scalars(select(Study).where(Study.name == name)).first()
    if study is None or not is_name(name):
        raise Refusal(404, "There is no such study.")
    if study.file is None:
        raise Refusal(
            422,
            "This study has no file, so it can't be changed here. Only studies that were made "
            "of a study's file can.",
        )
    draft = begun(Path(study.file), study.name)
    if study_problems(draft.value):
        raise Refusal(422, "The study's file has errors. Correct it on the server first.")
    return draft


def _step(name: str) -> Step:
    for one in STEPS:
        if one.name == name:
            return one
    raise Refusal(404, "There is no such step.")


def step_problems(draft: StudyDraft, step_name: str) -> list[StepProblem]:
    """Return the faults of a step."""
    are_played = step_name == STEPS[0].name
    root = installation().config.studies_folder
    found = [*problems_of(draft), *parts_of(root, draft, are_played=are_played)[1]]
    return [problem for problem in found if problem.step == step_name]


def _step_page(
    session: Session,
    admin: Person,
    draft: StudyDraft,
    step_name: str,
    problems: list[StepProblem] | None = None,
) -> str:
    more = _ABOUT[step_name](session, draft) if step_name in _ABOUT else {}
    return flask.render_template(
        f"making/{step_name}.html",
        person=admin,
        draft=draft,
        step=_step(step_name),
        problems=problems or [],
        wrong={problem.target for problem in problems or []},
        target=target,
        **page_values(draft),
        **more,
    )


def page_values(draft: StudyDraft) -> dict[str, Any]:
    """Return a draft's values for pages, with defaults for those that its file leaves out."""
    usual = task_defaults()
    value = {**defaults(), **draft.value}
    value["labels"] = {**defaults()["labels"], **(value["labels"] or {})}
    named = value["tasks"]
    return {
        "value": value,
        "steps": STEPS,
        "of_tasks": {task.name: {**usual, **named.get(task.name, {})} for task in tasks()},
        "tasks": tasks(),
        "chosen": [task for task in tasks() if task.name in named],
    }


def _about_videos(_session: Session, draft: StudyDraft) -> dict[str, Any]:
    root = installation().config.studies_folder
    parts, wrong = parts_of(root, draft)
    return {
        "root": root,
        "choices": video_choices(root) if root.is_dir() else [],
        "tables": command_tables(root) if root.is_dir() else [],
        "coco_files": files_ending(root, ".json") if root.is_dir() else [],
        "named": {name: _from_root(draft, name) for name in ("videos", "commands", "things")},
        "as_before": AS_BEFORE,
        "found": [] if wrong or parts is None else [item.video for item in parts.videos],
        **_about_things(draft, parts),
        "command_count": 0 if parts is None else len(parts.commands),
        "notes": [] if parts is None else parts.notes,
        "uploads": added_files(draft, parts),
    }


@dataclass(frozen=True, slots=True)
class PicturedVideo:
    """A video of a draft, with a small picture of it and the page on which one draws in it."""

    video: str
    picture: str
    draw: str
    """Empty where what is in it is known already."""
    things: int


def pictured(draft: StudyDraft, parts: StudyParts | None) -> list[PicturedVideo]:
    """Return a draft's videos, in their order."""
    return [
        PicturedVideo(
            item.video,
            flask.url_for("making_uploads.video_picture", name=draft.name, number=n),
            flask.url_for("making_drawing.draw", name=draft.name, number=n)
            if isinstance(item, OwnVideo)
            else "",
            len(item.things.things) if isinstance(item, OwnVideo) and item.things else 0,
        )
        for n, item in enumerate(() if parts is None else parts.videos)
    ]


def _about_things(draft: StudyDraft, parts: StudyParts | None) -> dict[str, Any]:
    """Return how many things are marked, in how many videos, and the videos without any."""
    bare = [] if parts is None else parts.without_things
    videos = pictured(draft, parts)
    return {
        "thing_count": sum(one.things for one in videos),
        "video_count": len(videos),
        "without_things": [one for one in videos if one.video in bare],
        "with_things": [one for one in videos if one.draw and one.video not in bare],
    }


def _about_texts(_session: Session, draft: StudyDraft) -> dict[str, Any]:
    named = [(language, language_name(language)) for language in languages()]
    return {"videos": videos_of(draft), "languages": named}


def _about_tasks(_session: Session, draft: StudyDraft) -> dict[str, Any]:
    parts, _ = parts_of(installation().config.studies_folder, draft, are_played=False)
    videos = [] if parts is None else [item.video for item in parts.videos]
    return {"videos": videos, "adoptions": ADOPTIONS, **_about_things(draft, parts)}


def videos_of(draft: StudyDraft) -> list[str]:
    """Return the names of a draft's videos; none if they have faults."""
    parts, _ = parts_of(installation().config.studies_folder, draft, are_played=False)
    return [] if parts is None else [item.video for item in parts.videos]


_ABOUT: dict[str, Callable[[Session, StudyDraft], dict[str, Any]]] = {
    "videos": _about_videos,
    "tasks": _about_tasks,
    "people": lambda session, _draft: {
        "logins": people_by_role(session),
        "groups": group_sizes(session),
    },
    "texts": _about_texts,
}


def _from_root(draft: StudyDraft, name: str) -> str:
    """Return a path of the draft as the lists have it; empty if it names none."""
    named = draft.value.get(name)
    root = installation().config.studies_folder
    if not named:
        return ""
    found = (draft.file.parent / str(named)).resolve()
    return found.relative_to(root).as_posix() if found.is_relative_to(root) else AS_BEFORE


def _new_page(admin: Person, problem: str = "") -> str:
    return flask.render_template(
        "making/new.html", person=admin, problem=problem, form=flask.request.form, steps=STEPS
    )


def _name_problem(session: Session, title: str, name: str) -> str:
    if not title:
        return "Type a title. People read it on their pages."
    if not is_name(name):
        return "The name in addresses has at most 60 of these: a to z, 0 to 9 and -."
    folder = installation().config.studies_folder
    known = session.scalar(select(Study.id).where(Study.name == name))
    if known is not None or (folder / f"{name}.yaml").exists():
        return f"There is a study {name} already. Choose another name."
    if find_draft(folder, name) is not None:
        return f"Somebody is at work on a study {name} already. Choose another name."
    return ""


def config_of(draft: StudyDraft) -> StudyConfig | None:
    """Return a draft as a study, or None if it has faults."""
    return None if study_problems(draft.value) else msgspec.convert(draft.value, StudyConfig)
