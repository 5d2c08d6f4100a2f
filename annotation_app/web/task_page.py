"""The page of a task: with an item, an answer that is edited, or something to practise with."""

from __future__ import annotations

from typing import Any

import flask
import msgspec

from annotation_app.store.models import Record
from annotation_app.studies.study_file import PracticeItem, StudyConfig
from annotation_app.tasks.task_record import Task
from annotation_app.tasks.task_texts import page_texts, task_words

WHO_CHARACTERS = 8


def render_task(
    task: Task,
    config: StudyConfig | None,
    data: Record,
    /,
    *,
    with_boat: bool = False,
    **shown: Any,
) -> str:
    """Render a task's page.

    Its script gets `data` and labels, its template the rest that is shown. If it is `with_boat`, it
    is about the app's own practice example.
    """
    texts = page_texts(config, task, with_boat=with_boat)
    labels = {name: getattr(texts.labels, name) for name in ("thing", "place", "robot")}
    return flask.render_template(
        task.template,
        task=task.name,
        words=task_words(config, task),
        texts=texts,
        data={**data, "labels": labels},
        is_practice=data.get("practice", False),
        **shown,
    )


def render_practice(
    task: Task,
    config: StudyConfig | None,
    payload: Record,
    own: PracticeItem | None,
    data: Record,
    /,
    **shown: Any,
) -> str:
    """Render a task's practice page: a study's own item, or the app's example."""
    kept = None if own is None else msgspec.to_builtins(own)
    data = {"task": task.name, "draft": None, "payload": payload, "own": kept, **data}
    data["practice"] = True
    return render_task(task, config, data, with_boat=own is None, progress=None, **shown)
