"""Reading a study's file: each error names the line, and all come at once."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import msgspec

from annotation_app.core.languages import languages
from annotation_app.studies.study_file import StudyConfig, TaskConfig
from annotation_app.study_setup.every_problem import every_problem, together
from annotation_app.tasks.task_record import Task
from annotation_app.tasks.task_registry import find_task, task_names, tasks
from corpus_tools.world.scenarios.documents import Problem, read_document
from g3.errors import CorpusError, unknown_name
from g3.sdc.sdc_notation import parse_brackets

MANUAL = "docs/annotation.md"


def read_study(path: Path) -> StudyConfig:
    """Read a study's file; an error lists all that is wrong, each with its line."""
    document = read_document(path)
    problems = study_problems(document.value)
    if problems:
        errors = {document.error(problem): None for problem in problems}
        raise together(sorted(errors, key=lambda error: _line(error.where, document.name)))
    return msgspec.convert(document.value, StudyConfig)


def study_problems(value: Any) -> list[Problem]:
    """Return all faults in a study's file."""
    problems = [
        Problem(("tasks", name), *unknown_name("task", name, task_names()))
        for name in _tasks(value)
        if find_task(name) is None
    ]
    problems += every_problem(value, StudyConfig, (), MANUAL)
    if not problems:
        problems += _problems(msgspec.convert(value, StudyConfig))
    return problems


def _line(where: str, name: str) -> tuple[int, ...]:
    place = where.removeprefix(name).split(": ")[0]
    return tuple(int(number) for number in place.split(":") if number)


def _tasks(value: Any) -> Iterable[str]:
    named = value.get("tasks") if isinstance(value, dict) else None
    return named if isinstance(named, dict) else ()


def _problems(study: StudyConfig) -> Iterator[Problem]:
    if not study.tasks:
        fix = f"name some of {', '.join(task_names())}"
        yield Problem(("tasks",), "there are no tasks", fix, "no-tasks")
    if study.locale not in languages():
        there = ", ".join(languages())
        fix = f"use one of {there}, or translate the pages: docs/how-to/translate.md"
        yield Problem(("locale",), f"the pages don't speak {study.locale}", fix)
    for task in tasks():
        problem = task.study_problem(study)
        if problem is not None:
            yield problem
        of_task = study.tasks.get(task.name)
        for style in of_task.styles if of_task is not None else ():
            if style not in task.words.styles:
                named = ", ".join(task.words.styles)
                fix = f"use {named}" if named else "leave it out: this task has no styles"
                field = ("tasks", task.name, "styles")
                yield Problem(field, f"there is no style {style}", fix)
        if of_task is not None and of_task.practice_items:
            yield from _practice_problems(of_task, task)
    ids = [question.id for question in study.questions]
    for i, name in enumerate(ids):
        if name in ids[:i]:
            yield Problem(("questions", i, "id"), "two questions have this id", "change one")


def _practice_problems(of_task: TaskConfig, task: Task) -> Iterator[Problem]:
    field = ("tasks", task.name, "practice_items")
    if not task.practises:
        yield Problem(field, "this task has no practice items of a study's own", "leave them out")
    for i, item in enumerate(of_task.practice_items):
        for name in task.practises:
            if getattr(item, name) is None:
                yield Problem((*field, i), f"there is no {name} to practise with", f"add {name}")
        try:
            parse_brackets(item.clauses, command=item.command)
        except CorpusError as error:
            yield Problem((*field, i, "clauses"), error.what, error.fix)
