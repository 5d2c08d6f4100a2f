"""Reading people's answers: the kept form, the faults, and the part that is counted."""

from __future__ import annotations

import json

import msgspec
from sqlalchemy.orm import Session

from annotation_app.core.languages import gettext
from annotation_app.core.problems import FieldProblem, Refusal
from annotation_app.items.assignment import AnyItem
from annotation_app.store.models import LONGEST_GIST, Record, TaskName
from annotation_app.tasks.task_registry import find_task, task_of


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


def gist_of(task_name: TaskName, body: Record) -> str | None:
    """Return the :attr:`~annotation_app.tasks.task_record.Task.gist` of an answer.

    It is JSON; None where the task has none, or it is too long for an index.
    """
    task = find_task(task_name)
    if task is None or task.gist is None:
        return None
    text = json.dumps(task.gist(body))
    return text if len(text) <= LONGEST_GIST else None
