"""Conversion of the steps' forms to the content of a study's file.

What people type is kept also where it is wrong, so that nothing is lost and the page can say why.
What says the same as a field that is left out is left out.
"""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any, TypeAlias

from werkzeug.datastructures import MultiDict

from annotation_app.making.steps import defaults, task_defaults
from annotation_app.studies.study_file import TaskConfig
from annotation_app.studies.study_template import slug
from annotation_app.study_setup.study_drafts import StudyDraft
from annotation_app.tasks.task_record import Task, asked_styles
from annotation_app.tasks.task_registry import tasks

Form: TypeAlias = "MultiDict[str, str]"
Value: TypeAlias = dict[str, Any]

MOST_ROWS = 50
AS_BEFORE = "as-before"
"""Value that a form sends for a folder that the file names and the list hasn't."""
NUMBER = re.compile(r"[0-9]{1,6}(\.[0-9]{1,4})?")


def read_form(step: str, draft: StudyDraft, form: Form, root: Path) -> Value:
    """Return a draft's value after a step's form was sent."""
    value = {key: inner for key, inner in draft.value.items() if key != "tasks"}
    value["tasks"] = {name: dict(of) for name, of in draft.value.get("tasks", {}).items()}
    if step == "videos":
        _videos(value, form, draft, root)
    else:
        readers = {"tasks": _tasks, "people": _people, "texts": _texts, "consent": _consent}
        readers[step](value, form)
    return value


def text_of(form: Form, name: str) -> str:
    """Return the typed text, with the line ends of files."""
    text = form.get(name, "").replace("\r\n", "\n").replace("\r", "\n").replace("\0", "")
    return "\n".join(line.rstrip() for line in text.strip().split("\n"))


def _videos(value: Value, form: Form, draft: StudyDraft, root: Path) -> None:
    for name in ("videos", "commands", "things"):
        chosen = form.get(name, "")[:4000].replace("\0", "")
        if chosen == AS_BEFORE:
            continue
        use_file(value, name, root / chosen if chosen else None, draft)


def use_file(value: Value, name: str, file: Path | None, draft: StudyDraft) -> None:
    """Use a file for the videos, the commands or the things of a draft; None for no file.

    With the first file of things come the tasks that ask about them.
    """
    if name == "things" and file is not None and not value.get("things"):
        known: Value = value.get("tasks", {})
        value["tasks"] = {
            task.name: known.get(task.name, {})
            for task in tasks()
            if task.needs_scenes or task.name in known
        }
    _put(value, name, os.path.relpath(file, draft.file.parent) if file is not None else "", "")


def _tasks(value: Value, form: Form) -> None:
    known: Value = value["tasks"]
    usual = task_defaults()
    value["tasks"] = {}
    for task in tasks():
        if f"do-{task.name}" not in form:
            continue
        of_task = value["tasks"][task.name] = known.get(task.name, {})
        _put(of_task, "answers", number_of(form, f"answers-{task.name}"), None)
        _put(of_task, "overlap", number_of(form, f"overlap-{task.name}"), usual["overlap"])
        if task.adjudication is not None:
            rule = number_of(form, f"adoption-{task.name}")
            _put(of_task, "adoption", rule, usual["adoption"])
        minutes = number_of(form, f"lease-{task.name}")
        _put(of_task, "lease_minutes", minutes, usual["lease_minutes"])
        _put(of_task, "practice", f"practice-{task.name}" in form, usual["practice"])
        if task.words.styles:
            _put(of_task, "styles", _styles(task, of_task, form), [])
        if task.lets_draw:
            _put(of_task, "drawing", f"drawing-{task.name}" in form, usual["drawing"])
        if task.suggestion is not None:
            suggestions = form.get(f"suggestions-{task.name}", "")
            _put(of_task, "suggestions", suggestions, usual["suggestions"])
            _put(of_task, "suggestions_from", number_of(form, f"from-{task.name}"), None)
    _put(value, "watching", form.get("watching", ""), defaults()["watching"])
    if "attention" in form:
        _put(value, "attention_checks", number_of(form, "attention"), 0)
        names = ("text", "video", "wrong_video")
        rows = ({n: text_of(form, f"known-{i}-{n}") for n in names} for i in range(MOST_ROWS))
        _put(value, "known_commands", [row for row in rows if any(row.values())], [])


def _styles(task: Task, of_task: Value, form: Form) -> Value | list[str]:
    """Return the chosen styles, with the prompts that the file has; empty for the usual ones."""
    before = of_task.get("styles")
    prompts = before if isinstance(before, dict) else {}
    chosen = [name for name in task.words.styles if name in form.getlist(f"style-{task.name}")]
    if any(prompts.get(name) for name in chosen):
        return {name: prompts.get(name) for name in chosen}
    return [] if chosen == list(asked_styles(TaskConfig(), task.words)) else chosen


def _people(value: Value, form: Form) -> None:
    _put(value, "access", form.get("access", ""), defaults()["access"])
    for name, of_task in value["tasks"].items():
        _put(of_task, "role", form.get(f"role-{name}", ""), task_defaults()["role"])
    if "group-0-name" in form:
        rows = ((text_of(form, f"group-{i}-name"), f"group-{i}-share") for i in range(MOST_ROWS))
        groups = {name: number_of(form, share) for name, share in rows if name}
        _put(value, "groups", {name: share for name, share in groups.items() if share != ""}, {})
    lines = [line for line in text_of(form, "qualification").split("\n") if line.strip()]
    _put(value, "qualification", lines, [])
    amount = number_of(form, "amount")
    if amount == "":
        value.pop("payment", None)
        return
    payment = value["payment"] = dict(value.get("payment") or {})
    payment["amount"] = amount
    payment["currency"] = form.get("currency", "").strip().upper() or "USD"
    _put(payment, "bonus", number_of(form, "bonus"), 0.0)


def _texts(value: Value, form: Form) -> None:
    usual = defaults()
    value["title"] = text_of(form, "title")
    for name in ("locale", "robot", "statement"):
        if name in form:
            _put(value, name, text_of(form, name), usual[name])
    if "scale-0" in form:  # only tasks that rate have one
        _put(value, "scale", [text_of(form, f"scale-{i}") for i in range(5)], usual["scale"])
    if "reasons" in form:
        reasons = [line for line in text_of(form, "reasons").split("\n") if line.strip()]
        _put(value, "reasons", reasons, usual["reasons"])
    labels = {name: text_of(form, f"label-{name}") for name in usual["labels"]}
    _put(value, "labels", labels, usual["labels"])
    for task in tasks():
        if task.name not in value["tasks"]:
            continue
        of_task = value["tasks"][task.name]
        for name in ("title", "summary", "prompt", "instructions"):
            _put(of_task, name, text_of(form, f"{name}-{task.name}"), "")
        if task.practises:
            rows = (_practice_item(form, f"item-{task.name}-{i}") for i in range(MOST_ROWS))
            before = of_task.get("practice_items") or []
            items = [
                _with_answers(row, before[i] if i < len(before) else {})
                for i, row in enumerate(rows)
                if row.keys() - {"right"}
            ]
            _put(of_task, "practice_items", items, [])


def _practice_item(form: Form, prefix: str) -> Value:
    row: Value = {}
    for name in ("video", "command", "good", "again"):
        if text := text_of(form, f"{prefix}-{name}"):
            row[name] = text
    if f"{prefix}-good" in form and row:
        row.setdefault("good", "")
    right = [int(number) for number in form.getlist(f"{prefix}-right") if number in "12345"]
    if right and right != [4, 5]:
        row["right"] = right
    return row


def _with_answers(row: Value, before: Value) -> Value:
    """Return a practice item with the answers that were kept for the same video and command."""
    if any(row.get(name) != before.get(name) for name in ("video", "command")):
        return row
    return {**row, **{n: before[n] for n in ("clauses", "answer", "wrong") if n in before}}


def _consent(value: Value, form: Form) -> None:
    _put(value, "consent", text_of(form, "consent"), defaults()["consent"])
    questions: list[Value] = []
    for i in range(MOST_ROWS):
        text = text_of(form, f"question-{i}-text")
        choices = [c for c in text_of(form, f"question-{i}-choices").split("\n") if c.strip()]
        if not text and not choices:
            continue
        known = {question["id"] for question in questions}
        row: Value = {"id": _new_id(form.get(f"question-{i}-id", "") or text, known), "text": text}
        if choices:
            row["choices"] = choices
        if f"question-{i}-required" in form:
            row["required"] = True
        questions.append(row)
    _put(value, "questions", questions, [])
    _put(value, "retention_days", number_of(form, "retention_days"), "")


def _new_id(wish: str, known: set[str]) -> str:
    name = slug(wish)[:40].strip("-")
    names = (name, *(f"{name}-{i}" for i in range(2, MOST_ROWS + 2)))
    return next(one for one in names if one not in known)


def number_of(form: Form, name: str) -> int | float | str:
    """Return a number, or the typed text if it is none."""
    text = form.get(name, "").strip().replace(",", ".")[:40].replace("\0", "")
    if not NUMBER.fullmatch(text):
        return text
    return float(text) if "." in text else int(text)


def _put(value: Value, name: str, found: Any, usual: Any) -> None:
    """Keep a value that differs from the default; one that the file already has stays there."""
    if found in ("", None) or (found == usual and (name not in value or not found)):
        value.pop(name, None)
    else:
        value[name] = found
