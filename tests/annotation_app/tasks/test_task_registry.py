"""What tasks are registered, and that nothing but their own files knows them by name."""

from __future__ import annotations

import ast
import dataclasses
from pathlib import Path

import pytest

import annotation_app
from annotation_app.tasks.describe import DESCRIBE
from annotation_app.tasks.ground import GROUND
from annotation_app.tasks.practice_example import practice_example
from annotation_app.tasks.task_record import CLAUSES, COMMAND, GROUNDINGS
from annotation_app.tasks.task_registry import makers, register, task_names, tasks

APP = Path(annotation_app.__file__).parent
STUDIES = {"study_setup/demo_study.py", "study_setup/corpus_study.py"}
"""They make studies of certain tasks."""


def test_tasks_are_in_the_order_in_which_people_do_them() -> None:
    named = (
        "describe",
        "subtasks",
        "moments",
        "mark",
        "correct",
        "segment",
        "ground",
        "check",
        "rate",
    )
    assert task_names() == named


def test_what_is_made_of_what() -> None:
    made = {gives: [task.name for task in makers(gives)] for gives in (COMMAND, CLAUSES)}
    assert made == {COMMAND: ["correct", "segment", "rate"], CLAUSES: ["ground", "check"]}
    assert [task.name for task in makers(GROUNDINGS)] == ["check"]
    assert makers("") == ()


FIELDS = {"subtasks", "moments"}
"""Names of tasks that are also names of fields, of studies' files and of drawn outlines."""


def test_no_other_module_knows_a_task_by_its_name() -> None:
    found = [
        f"{path.relative_to(APP)}:{node.lineno}"
        for path in APP.rglob("*.py")
        if path.parent != APP / "tasks" and path.relative_to(APP).as_posix() not in STUDIES
        if "migrations" not in path.parts  # they are about the tasks that there were
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Constant) and node.value in {*task_names()} - FIELDS
    ]
    assert found == []


@pytest.mark.parametrize("name", ["Describe", "", "a b", "x" * 21, "1st", "describe"])
def test_names_are_new_and_fit_into_the_database(name: str) -> None:
    with pytest.raises(ValueError, match=r"name|already"):
        register(dataclasses.replace(DESCRIBE, name=name))


def test_commands_are_adopted_at_once() -> None:
    with pytest.raises(ValueError, match="adopted at once"):
        register(dataclasses.replace(GROUND, name="other", gives=COMMAND))


def test_all_have_a_page_and_a_practice_example() -> None:
    for task in tasks():
        assert (APP / "templates" / task.template).exists()
        assert (APP / "static" / "js" / f"{task.name}.js").exists()
        assert task.example is not None
        assert task.example(practice_example())


def test_what_is_counted_has_a_name_of_its_own() -> None:
    types = [task.counts.type for task in tasks() if task.counts is not None]
    names = [field.name for found in types for field in dataclasses.fields(found)]
    assert len(names) == len(set(names))
