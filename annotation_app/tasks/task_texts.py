"""Texts of a task's page: the study's words, else the task's own."""

from __future__ import annotations

from dataclasses import dataclass

import msgspec
from markupsafe import Markup

from annotation_app.core.languages import N_, gettext
from annotation_app.studies.safe_markdown import to_html
from annotation_app.studies.study_file import (
    REASONS,
    Labels,
    StudyConfig,
    TaskConfig,
    in_its_language,
    told,
)
from annotation_app.tasks.task_record import StyleWords, Task, TaskWords, asked_styles

BOAT, THE_BOAT = N_("boat"), N_("the boat")
"""Subject of the app's own practice examples."""


@dataclass(frozen=True, slots=True)
class PageTexts:
    """The texts of a task's page that aren't the task's words."""

    instructions: Markup
    """The study's own as HTML; empty if the task's words are to be shown."""
    statement: str
    scale: tuple[str, ...]
    """Subject of the rating, and the five levels."""
    labels: Labels
    """Names of things."""
    reasons: tuple[tuple[str, str], ...] = ()
    """Reasons against an episode: as they are kept, and as people read them."""


def task_words(config: StudyConfig | None, task: Task) -> TaskWords:
    """Return a task's words in the language of the page, with the study's own if it has some."""
    own, words = _own(config, task), task.words
    return TaskWords(
        title=own.title or gettext(words.title),
        summary=own.summary or gettext(words.summary),
        offer=own.summary or gettext(words.offer),
        instructions=tuple(map(gettext, words.instructions)),
        keys=tuple((gettext(key), gettext(does)) for key, does in words.keys),
        prompt=own.prompt or gettext(words.prompt),
        styles=_styles(own, words),
    )


def _styles(own: TaskConfig, words: TaskWords) -> dict[str, StyleWords]:
    prompts = own.styles if isinstance(own.styles, dict) else {}
    return {
        name: StyleWords(gettext(usual.title), prompts.get(name) or gettext(usual.prompt))
        for name, usual in asked_styles(own, words).items()
    }


def page_texts(config: StudyConfig | None, task: Task, *, with_boat: bool = False) -> PageTexts:
    """Return the texts of a task's page in a study, if it is in one.

    A page that is about the app's own practice example is `with_boat`.
    """
    study = in_its_language(config or StudyConfig(name="-", title="-", tasks={}))
    robot, labels = study.robot, study.labels
    if with_boat or config is None:
        robot, labels = gettext(BOAT), msgspec.structs.replace(labels, robot=gettext(THE_BOAT))
    own = _own(config, task).instructions
    shown = tuple(map(gettext, REASONS)) if study.reasons == REASONS else study.reasons
    return PageTexts(
        to_html(own) if own.strip() else Markup(),
        told(study.statement, robot),
        study.scale,
        labels,
        tuple(zip(study.reasons, shown, strict=True)),
    )


def _own(config: StudyConfig | None, task: Task) -> TaskConfig:
    return config.tasks.get(task.name, TaskConfig()) if config is not None else TaskConfig()
