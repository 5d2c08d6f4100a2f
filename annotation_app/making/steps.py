"""The steps in which a study is made, and the faults in each."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from annotation_app.studies.study_file import StudyConfig, TaskConfig
from annotation_app.study_setup.every_problem import apart
from annotation_app.study_setup.own_videos import OwnVideo
from annotation_app.study_setup.rendered_study import SettingError
from annotation_app.study_setup.server_folders import inside
from annotation_app.study_setup.study_drafts import StudyDraft
from annotation_app.study_setup.study_reading import study_problems
from annotation_app.study_setup.study_starting import StudyParts, find_parts
from annotation_app.tasks.task_registry import find_task
from corpus_tools.world.scenarios.documents import Field, Problem, read_document
from g3.errors import CorpusError, FormatError


@dataclass(frozen=True, slots=True)
class Step:
    """A page of the way, with its name in addresses and the title that people read.

    It fills in these `fields` of the study's file, and those `of_tasks` in each task's part of it.
    """

    name: str
    title: str
    fields: tuple[str, ...]
    of_tasks: tuple[str, ...] = ()


STEPS = (
    Step("videos", "Videos", ("name", "videos", "only", "commands", "subtasks", "things")),
    Step(
        "tasks",
        "Tasks",
        (
            "tasks",
            "watching",
            "attention_checks",
            "known_commands",
            "pairs",
            "seed",
            "vocabulary",
            "vocabulary_grows",
        ),
        (
            "answers",
            "overlap",
            "adoption",
            "lease_minutes",
            "practice",
            "suggestions",
            "suggestions_from",
            "styles",
            "drawing",
        ),
    ),
    Step("people", "People", ("access", "groups", "qualification", "payment"), ("role",)),
    Step(
        "texts",
        "Texts",
        ("title", "locale", "robot", "statement", "scale", "reasons", "labels"),
        ("title", "summary", "prompt", "instructions", "practice_items"),
    ),
    Step("consent", "Consent", ("consent", "questions", "retention_days")),
)
PATHS = ("videos", "commands", "subtasks", "things")
"""Fields of a study's file that name files."""
REVIEW = "review"
"""The last page."""


@dataclass(frozen=True, slots=True)
class StepProblem:
    """Something that is wrong, and what to do about it, in the words of the page.

    It can be put right in the `step`, by the control whose id is `target`; empty if there is none.
    """

    step: str
    target: str
    message: str


def problems_of(draft: StudyDraft) -> list[StepProblem]:
    """Return the faults of a draft's content, without looking at its videos."""
    return [
        StepProblem(_step_of(problem.field), target(problem.field), _message(problem))
        for problem in study_problems(draft.value)
    ]


def parts_of(
    root: Path, draft: StudyDraft, *, are_played: bool = True
) -> tuple[StudyParts | None, list[StepProblem]]:
    """Return a draft's videos and commands, and their faults.

    New paths may not lead out of `root`, the folder of studies. The videos are looked into if they
    `are_played`.
    """
    if not draft.value.get("videos"):
        return None, [StepProblem("videos", "f-videos", "Choose the videos.")]
    try:
        config = msgspec.convert(
            {"tasks": {}, **draft.value, "name": draft.name, "title": "-"}, StudyConfig
        )
    except msgspec.ValidationError:  # what is wrong with its form is told by problems_of
        config = StudyConfig(
            name=draft.name, title="-", videos=str(draft.value["videos"]), tasks={}
        )
    try:
        _check_inside(root, draft)
        parts, errors = find_parts(config, draft.file, are_played=are_played)
        if not _is_as_before(draft):
            for item in parts.videos:
                inside(root, item.file if item.file is not None else item.folder)
                for path in item.other_files if isinstance(item, OwnVideo) else ():
                    inside(root, path)
    except CorpusError as error:
        return None, [of_videos(one) for one in apart(error)]
    return parts, [of_videos(error) for error in errors]


def target(field: Field) -> str:
    """Return the id of the control for a field of the study's file."""
    return "-".join(("f", *map(str, field))).replace(" ", "-")


def _check_inside(root: Path, draft: StudyDraft) -> None:
    if not _is_as_before(draft):
        for name in PATHS:
            named = draft.value.get(name)
            for path in named.values() if isinstance(named, dict) else [named]:
                if path:
                    inside(root, draft.file.parent / str(path))


def _is_as_before(draft: StudyDraft) -> bool:
    """Check that the study's file names the same paths: its author may name any folder."""
    if draft.is_new:
        return False
    try:
        before = read_document(draft.file).value
    except FormatError:
        return False
    return all(before.get(name) == draft.value.get(name) for name in PATHS)


def of_videos(error: CorpusError) -> StepProblem:
    """Return an error about videos as a problem of the step in which it is corrected."""
    if isinstance(error, SettingError):
        message = f"{_sentence(error.what)} {_sentence(error.fix)}"
        return StepProblem(_step_of(error.field), target(error.field), message)
    where = f"{error.where}: " if error.where else ""
    return StepProblem("videos", "", f"{where}{error.what}. {_sentence(error.fix)}".strip())


def _step_of(field: Field) -> str:
    of_task = field[0] == "tasks" and len(field) > 2
    name = field[2] if of_task else field[0] if field else ""
    for step in STEPS:
        if name in (step.of_tasks if of_task else step.fields):
            return step.name
    return STEPS[0].name


def _message(problem: Problem) -> str:
    what = _PLAIN.get(problem.code, "").format(limit=problem.limit)
    if not what:
        fix = "" if problem.fix.startswith("see docs/") else _sentence(problem.fix)
        what = f"{_sentence(problem.what)} {fix}".strip()
    return f"{_label(problem.field)}: {what}"


def _label(field: Field) -> str:
    """Return the pages' label of a field."""
    names = [LABELS.get(str(key), str(key)) for key in field if not isinstance(key, int)]
    task = find_task(str(field[1])) if field[0] == "tasks" and len(field) > 1 else None
    if task is not None:
        names = [task.words.title, *(LABELS.get(str(key), str(key)) for key in field[2:3])]
    numbers = [str(key + 1) for key in field if isinstance(key, int)]
    label = ", ".join((names[0], *(name.lower() for name in names[1:])))
    return f"{label} {numbers[0]}" if numbers else label


def _sentence(text: str) -> str:
    return f"{text[:1].upper()}{text[1:].rstrip('.')}." if text else ""


LABELS = {
    "title": "Title",
    "locale": "Language",
    "name": "Name",
    "videos": "Videos",
    "commands": "Commands",
    "tasks": "Tasks",
    "answers": "Answers",
    "overlap": "Overlap",
    "lease_minutes": "Minutes",
    "adoption": "Adopted if",
    "suggestions_from": "Suggest from",
    "attention_checks": "Attention checks",
    "known_commands": "Command",
    "wrong_video": "another video",
    "robot": "Robot",
    "statement": "Statement",
    "scale": "Scale",
    "reasons": "Reasons",
    "labels": "Labels",
    "thing": "a thing",
    "place": "a place",
    "consent": "Consent",
    "questions": "Question",
    "groups": "Group",
    "qualification": "Condition",
    "payment": "Payment",
    "practice_items": "Practice item",
    "summary": "Summary",
    "prompt": "Prompt",
    "styles": "Styles of text",
    "instructions": "Instructions",
    "retention_days": "Days",
}
"""Pages' labels of fields."""

_PLAIN = {
    "too-short": "This is empty.",
    "too-long": "Use at most {limit} characters.",
    "no-integer": "Type a whole number.",
    "below": "Type a number of {limit} or more.",
    "not-above": "Type a number above {limit}.",
    "above": "Type a number of {limit} or less.",
    "no-number": "Type a number.",
    "no-tasks": "Choose a task.",
}
"""Pages' messages of problems, by their codes."""


def defaults() -> dict[str, Any]:
    """Return a study's defaults for fields that its file leaves out."""
    found = _plain(StudyConfig(name="-", title="-", tasks={}))
    return {**found, "name": "", "title": "", "videos": "", "tasks": {}}


def task_defaults() -> dict[str, Any]:
    """Return the defaults of a task's settings."""
    return _plain(TaskConfig())


def _plain(record: Any) -> dict[str, Any]:
    """Return a record as files have it, with lists."""
    found: dict[str, Any] = msgspec.json.decode(msgspec.json.encode(record))
    return found


def page_after(name: str) -> str:
    """Return the name of the page that comes after a step."""
    names = [*(step.name for step in STEPS), REVIEW]
    return names[names.index(name) + 1]
