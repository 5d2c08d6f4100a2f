"""The pages of workers as they would be with a draft's words. Nothing is kept there."""

from __future__ import annotations

import copy
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Annotated, Any

import flask
import msgspec
from flask import Blueprint, Response
from flask.typing import ResponseReturnValue

from annotation_app.core.languages import speak
from annotation_app.core.problems import Refusal
from annotation_app.items.clips import ensure
from annotation_app.items.media import TYPES, WEBM
from annotation_app.making.step_pages import config_of, opened_draft, opened_video
from annotation_app.making.steps import parts_of
from annotation_app.pages.study_progress import TaskProgress
from annotation_app.store.installation import installation
from annotation_app.store.models import Record
from annotation_app.studies.study_file import PracticeItem, StudyConfig, in_its_language
from annotation_app.study_setup.own_videos import OwnVideo
from annotation_app.study_setup.prepared_videos import played_file, prepare
from annotation_app.study_setup.rendered_study import FILES, Rendered
from annotation_app.study_setup.study_drafts import StudyDraft, keep_draft
from annotation_app.tasks.practice_example import OwnPractice, practice_example
from annotation_app.tasks.task_record import Task
from annotation_app.tasks.task_registry import find_task, tasks
from annotation_app.tasks.task_texts import task_words
from annotation_app.web.api import json_reply, read_request
from annotation_app.web.public_links import here
from annotation_app.web.task_page import render_practice
from annotation_app.web.who_asks import refused, seen_by
from g3.errors import CorpusError
from g3.sdc.sdc_notation import format_brackets, from_json

WELCOME, OVERVIEW = "welcome", "tasks"
MOST_WRONG = 50

blueprint = Blueprint("making_previews", __name__, url_prefix="/admin/studies")
blueprint.register_error_handler(Refusal, refused)


@blueprint.get("/<name>/preview/<page>")
def preview(name: str, page: str) -> ResponseReturnValue:
    """Show a page of the study as it would be."""
    with seen_by("admin") as (session, admin):
        draft = opened_draft(session, name)
    config = config_of(draft)
    if config is None:
        raise Refusal(422, "Something in this study is wrong. Put it right, then look again.")
    speak(config.locale)
    config = in_its_language(config)
    shown = {"config": config, "person": admin, "preview": draft.name}
    if page == WELCOME:
        study = SimpleNamespace(name=name)
        about = {"study": study, "answers": {}, "problems": {}, "ticked": {}, "onwards": ""}
        return flask.render_template("welcome.html", **shown, **about)
    if page == OVERVIEW:
        return flask.render_template("study.html", **shown, study=None, tasks=_cards(config))
    task = find_task(page)
    if task is None or task.name not in config.tasks or task.example is None:
        raise Refusal(404, "There is no such page.")
    return _task_page(draft, config, task, shown)


@blueprint.get("/<name>/video/<int:number>")
def video(name: str, number: int) -> Response:
    """Send one of a draft's videos."""
    draft, item = opened_video(name, number)
    try:
        file = _played(draft, item)
        ensure(file)
    except CorpusError as error:
        raise Refusal(404, str(error)) from error
    if not file.is_file():
        raise Refusal(404, "There is no such video.")
    kind = WEBM if file.suffix.lower() == ".webm" else TYPES["video"]
    return flask.send_file(file, mimetype=kind, conditional=True)


def _prepared(draft: StudyDraft, item: OwnVideo) -> Path:
    return prepare(item, installation().config.instance / "own-videos" / draft.name)


def _played(draft: StudyDraft, item: Rendered | OwnVideo) -> Path:
    """Return the file that people would watch."""
    if isinstance(item, OwnVideo):
        return played_file(item, _prepared(draft, replace(item, things=None)))
    return item.folder / FILES["video"]


def _cards(config: StudyConfig) -> list[TaskProgress]:
    return [
        TaskProgress(
            task.name,
            task_words(config, task),
            done=0,
            items=0,
            is_begun=False,
            wants_login=config.tasks[task.name].role != "worker",
            wants_practice=config.tasks[task.name].practice,
            has_practice=task.example is not None,
        )
        for task in tasks()
        if task.name in config.tasks
    ]


def _task_page(
    draft: StudyDraft, config: StudyConfig, task: Task, shown: Record
) -> ResponseReturnValue:
    own = config.tasks[task.name].practice_items
    number = flask.request.args.get("item", 0, type=int)
    item = own[number] if 0 <= number < len(own) else None
    assert task.example is not None  # noqa: S101 - the page was asked for such a task
    payload = _payload(draft, task, item) if item is not None else task.example(practice_example())
    onwards = flask.url_for(".preview", name=draft.name, page=task.name)
    data = {
        "item": f"preview-{draft.name}-{task.name}-{number}",
        "signed_in": False,
        "next": f"{onwards}?item={number + 1}" if number + 1 < len(own) else onwards,
        "who": "preview",
    }
    if item is not None:
        address = flask.url_for(".keep_answer", name=draft.name, page=task.name, number=number)
        data["keep"] = address.removeprefix(here(""))
    title = None if task.hides_title else config.title
    return render_practice(task, config, payload, item, data, study=None, title=title, **shown)


def _payload(draft: StudyDraft, task: Task, item: PracticeItem) -> Record:
    parts, _ = parts_of(installation().config.studies_folder, draft, are_played=False)
    videos = () if parts is None else parts.videos
    number = next((n for n, known in enumerate(videos) if known.video == item.video), None)
    if number is None:
        raise Refusal(422, f"There is no video {item.video}. Choose another to practise with.")
    shown = videos[number]
    address = flask.url_for(".video", name=draft.name, number=number)
    public = {"video": address.removeprefix(here(""))}
    try:
        folder = _prepared(draft, shown) if isinstance(shown, OwnVideo) else shown.folder
        return task.own_example(OwnPractice(item, folder, public))
    except CorpusError as error:
        raise Refusal(422, str(error)) from error


class KeptAnswer(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """An answer to a practice item: the right one, or a wrong one with the reason why it is."""

    body: dict[str, Any]
    why: Annotated[str, msgspec.Meta(max_length=1000)] = ""


@blueprint.post("/<name>/preview/<page>/<int:number>")
def keep_answer(name: str, page: str, number: int) -> Response:
    """Keep an answer to a draft's practice item with the draft."""
    with seen_by("admin") as (session, _):
        draft = opened_draft(session, name)
    kept = read_request(KeptAnswer)
    task, value = find_task(page), copy.deepcopy(dict(draft.value))
    items = value.get("tasks", {}).get(page, {}).get("practice_items", [])
    if task is None or not 0 <= number < len(items):
        raise Refusal(404, "There is no such practice item.")
    item = items[number]
    if kept.why.strip():
        wrong = {"answer": kept.body, "why": kept.why.strip()}
        item["wrong"] = [*item.get("wrong", []), wrong][-MOST_WRONG:]
    else:
        item["answer"] = kept.body
    if "sdcs" in (example := _payload(draft, task, msgspec.convert(item, PracticeItem))):
        item["clauses"] = format_brackets(from_json(example["sdcs"]))  # nodes keep their numbers
    keep_draft(installation().config.studies_folder, draft, value)
    return json_reply({"kept": True})
