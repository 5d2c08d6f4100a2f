"""The tasks of the app, in their order.

:func:`register` adds one. Modules that other distributions name in the entry point group
``ct.tasks`` do so when this one is imported.
"""

from __future__ import annotations

import re

from annotation_app.core.languages import gettext
from annotation_app.core.problems import Refusal
from annotation_app.store.models import TaskName
from annotation_app.tasks.check import CHECK
from annotation_app.tasks.correct import CORRECT
from annotation_app.tasks.describe import DESCRIBE
from annotation_app.tasks.ground import GROUND
from annotation_app.tasks.mark import MARK
from annotation_app.tasks.moments import MOMENTS
from annotation_app.tasks.rate import RATE
from annotation_app.tasks.segment import SEGMENT
from annotation_app.tasks.subtasks import SUBTASKS
from annotation_app.tasks.task_record import COMMAND, LONGEST_NAME, Task
from g3.registry import Registry

TASKS: Registry[Task] = Registry("task", "ct.tasks")
find_task = TASKS.get


def register(task: Task) -> None:
    """Add a task; its name must be new."""
    if not re.fullmatch(f"[a-z][a-z-]{{0,{LONGEST_NAME - 1}}}", task.name):
        raise ValueError(
            f"{task.name!r} is no name for a task: use at most {LONGEST_NAME} lower-case letters"
        )
    if task.gives == COMMAND and task.adjudication is not None:
        raise ValueError(f"{task.name}: answers that are commands are adopted at once")
    TASKS.add(task)


def tasks() -> tuple[Task, ...]:
    """Return all tasks: a study's people see them in this order."""
    return tuple(TASKS.values())


def task_names() -> tuple[TaskName, ...]:
    """Return the names of all tasks, in their order."""
    return tuple(TASKS)


def task_of(name: TaskName) -> Task:
    """Return the task of a name; raise Refusal if there is none."""
    task = TASKS.get(name)
    if task is None:
        raise Refusal(404, gettext("There is no such task here any more."))
    return task


def makers(gives: str) -> tuple[Task, ...]:
    """Return the tasks whose items are made of answers with some content."""
    return tuple(
        task
        for task in TASKS.values()
        if gives and any(source.made_of == gives for source in task.sources)
    )


for _task in (DESCRIBE, SUBTASKS, MOMENTS, MARK, CORRECT, SEGMENT, GROUND, CHECK, RATE):
    register(_task)
TASKS.load_others()
