"""The part of an answer that is counted and compared, kept beside it as JSON."""

from __future__ import annotations

import json

from annotation_app.store.models import LONGEST_GIST, Record, TaskName
from annotation_app.tasks.task_registry import find_task


def gist_of(task_name: TaskName, body: Record) -> str | None:
    """What :attr:`~annotation_app.tasks.task_record.Task.gist` says of an answer.

    Returns
    -------
    str or None
        JSON; None where the task has none, or it is too long for an index.
    """
    task = find_task(task_name)
    if task is None or task.gist is None:
        return None
    text = json.dumps(task.gist(body))
    return text if len(text) <= LONGEST_GIST else None
