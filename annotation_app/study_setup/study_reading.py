"""Reading a study's file: errors name the line."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from annotation_app.studies.study_file import StudyConfig, TaskConfig
from annotation_app.tasks.task_registry import find_task, task_names, tasks
from corpus_tools.world.scenarios.documents import Problem, convert, read_document

MANUAL = "docs/annotation.md"


def read_study(path: Path) -> StudyConfig:
    """Read a study's file.

    Raises
    ------
    FormatError
        If something in it is wrong, with its line.
    """
    document = read_document(path)
    for name, value in _tasks(document.value):
        wrong = convert(value, TaskConfig, ("tasks", name), MANUAL)
        if find_task(name) is None:
            fix = f"use {', '.join(task_names())}"
            wrong = Problem(("tasks", name), "there is no such task", fix)
        if isinstance(wrong, Problem):
            raise document.error(wrong)
    found = convert(document.value, StudyConfig, (), MANUAL)
    problem = found if isinstance(found, Problem) else _problem(found)
    if problem is not None:
        raise document.error(problem)
    assert isinstance(found, StudyConfig)  # noqa: S101 - else there is a problem
    return found


def _tasks(value: Any) -> Iterable[tuple[str, Any]]:
    named = value.get("tasks") if isinstance(value, dict) else None
    return named.items() if isinstance(named, dict) else ()


def _problem(study: StudyConfig) -> Problem | None:
    if not study.tasks:
        fix = f"name some of {', '.join(task_names())}"
        return Problem(("tasks",), "there are no tasks", fix)
    for task in tasks():
        problem = task.study_problem(study)
        if problem is not None:
            return problem
    ids = [question.id for question in study.questions]
    for i, name in enumerate(ids):
        if name in ids[:i]:
            return Problem(("questions", i, "id"), "two questions have this id", "change one")
    return None
