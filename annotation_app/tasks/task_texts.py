"""What people read on a task's page: the study's words, else the task's own."""

from __future__ import annotations

from dataclasses import dataclass, replace

from markupsafe import Markup

from annotation_app.store.models import Record
from annotation_app.studies.safe_markdown import to_html
from annotation_app.studies.study_file import (
    SCALE,
    STATEMENT,
    Labels,
    StudyConfig,
    TaskConfig,
    told,
)
from annotation_app.tasks.task_record import Task, TaskWords

BOAT = "boat"
"""What the app's own practice examples are about."""


@dataclass(frozen=True, slots=True)
class PageTexts:
    """What a task's page says besides the task's words.

    Parameters
    ----------
    instructions
        The study's own as HTML; empty if the task's words are to be shown.
    statement, scale
        What is rated, and the five levels.
    labels
        What things are called.
    """

    instructions: Markup
    statement: str
    scale: tuple[str, ...]
    labels: Labels


def task_words(config: StudyConfig | None, task: Task) -> TaskWords:
    """A task's words, with the study's title and summary if it has some."""
    own = _own(config, task)
    return replace(
        task.words,
        title=own.title or task.words.title,
        summary=own.summary or task.words.summary,
        offer=own.summary or task.words.offer,
    )


def page_texts(config: StudyConfig | None, task: Task, *, with_boat: bool = False) -> PageTexts:
    """The texts of a task's page in a study, if it is in one.

    Parameters
    ----------
    with_boat
        Whether the page is about the app's own practice example.
    """
    statement, scale, labels = STATEMENT, SCALE, Labels()
    robot = BOAT
    if config is not None:
        statement, scale, labels, robot = (
            config.statement,
            config.scale,
            config.labels,
            config.robot,
        )
    if with_boat:
        robot, labels = BOAT, Labels(thing=labels.thing, place=labels.place, robot=f"the {BOAT}")
    own = _own(config, task).instructions
    return PageTexts(
        to_html(own) if own.strip() else Markup(), told(statement, robot), scale, labels
    )


def labels_of(texts: PageTexts) -> Record:
    """The labels as the page's program gets them."""
    return {name: getattr(texts.labels, name) for name in ("thing", "place", "robot")}


def _own(config: StudyConfig | None, task: Task) -> TaskConfig:
    return config.tasks.get(task.name, TaskConfig()) if config is not None else TaskConfig()
