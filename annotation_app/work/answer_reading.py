"""Reading people's answers: the kept form, the faults, and the part that is counted."""

from __future__ import annotations

import json

import msgspec
from sqlalchemy.orm import Session

from annotation_app.core.languages import gettext
from annotation_app.core.problems import FieldProblem, Refusal
from annotation_app.items.assignment import AnyItem, Work
from annotation_app.items.item_scenes import watched_video
from annotation_app.items.submissions import held_s
from annotation_app.store.models import LONGEST_GIST, Record, TaskName
from annotation_app.tasks.task_registry import find_task, task_of
from annotation_app.work.answer_flags import watched_too_long

ENOUGH = 0.9
"""Share of a video that counts as all of it, as in `player.js`."""
ROUNDED_S = 0.1
"""Largest error of rounding on pages, in seconds."""


def read_answer(session: Session, item: AnyItem, body: Record, salt: bytes) -> Record:
    """Return an answer in its kept form; refuse it with all of its faults, in plain words."""
    task = task_of(item.task)
    try:
        answer = msgspec.convert(body, task.answer)
    except msgspec.ValidationError as error:
        what, _, field = str(error).rstrip("`").partition(" - at `$")
        message = gettext(
            "This part of the answer can't be read. Load the page again; your draft is kept."
        )
        problem = FieldProblem(field.strip("."), f"{message} ({what})")
        raise Refusal(422, gettext("The answer can't be read."), [problem]) from error
    kept, problems = task.check(session, item, answer, salt)
    if problems:
        raise Refusal(422, gettext("Something in the answer must be changed."), list(problems))
    return kept


def checked_watching(session: Session, item: Work, body: Record, now: float) -> Record:
    """Return an answer whose sender may have watched the videos; refuse another one.

    Enough of them must have been played, and since the item was handed out there must have been
    time for it. A study with ``watching: flagged`` keeps all; those with too little are
    ``"unwatched"``.
    """
    names = task_of(item.task).watches(item.payload)
    films = [watched_video(session, item.study_id, name) for name in names if name]
    lasts_s = sum(film["duration_s"] for film in films if film["video"])
    watched_s = body.get("watched_s", 0.0)
    is_flagged = item.config.get("watching") == "flagged"
    if watched_s < ENOUGH * lasts_s - ROUNDED_S:
        if is_flagged:
            return body | {"unwatched": True}
        why = gettext("Watch the video to its end first.")
    elif (
        lasts_s and not is_flagged and watched_too_long(body, held_s(session, item, item.who, now))
    ):
        why = gettext("This is sooner than the video can be watched. Watch it to its end first.")
    else:
        return body
    problem = FieldProblem("watched_s", why)
    raise Refusal(422, gettext("Something in the answer must be changed."), [problem])


def gist_of(task_name: TaskName, body: Record) -> str | None:
    """Return the :attr:`~annotation_app.tasks.task_record.Task.gist` of an answer.

    It is JSON; None where the task has none, or it is too long for an index.
    """
    task = find_task(task_name)
    if task is None or task.gist is None:
        return None
    text = json.dumps(task.gist(body))
    return text if len(text) <= LONGEST_GIST else None
