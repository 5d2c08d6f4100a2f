"""Reading what people answer, and telling them what can't be kept."""

from __future__ import annotations

import msgspec
from sqlalchemy.orm import Session

from annotation_app.core.languages import gettext
from annotation_app.core.problems import FieldProblem, Refusal
from annotation_app.items.assignment import AnyItem
from annotation_app.store.models import Record
from annotation_app.tasks.task_registry import task_of


def read_answer(session: Session, item: AnyItem, body: Record, salt: bytes) -> Record:
    """An answer as it is kept.

    Raises
    ------
    Refusal
        With all that is wrong with it, in plain words.
    """
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
