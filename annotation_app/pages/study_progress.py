"""A person's progress in a study."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from annotation_app.items.assignment import still_open
from annotation_app.people.participants import RANKS
from annotation_app.store.models import Answer, Draft, Item, Person, Study, TaskName
from annotation_app.studies.study_file import restored
from annotation_app.tasks.task_record import TaskWords
from annotation_app.tasks.task_registry import tasks
from annotation_app.tasks.task_texts import task_words
from annotation_app.work.handing_out import must_practise


@dataclass(frozen=True, slots=True)
class TaskProgress:
    """A task of a study, as somebody sees it."""

    task: TaskName
    words: TaskWords
    done: int
    """Number of items that the person has answered."""
    items: int
    """Number of those and of items that the person may still do; more may come as others answer."""
    is_begun: bool
    """True if there is a draft to continue."""
    wants_login: bool
    wants_practice: bool
    """True if the practice example must come first."""
    has_practice: bool
    """True if there is a practice example."""


def progress(session: Session, study: Study, person: Person) -> list[TaskProgress]:
    """Return the progress in a study's tasks, in their order."""
    config = restored(study.config)
    done = _answered(session, study, person)
    left = still_open(session, study.id, person.id, config.tasks)
    begun = _begun(session, study, person)
    return [
        TaskProgress(
            task.name,
            task_words(config, task),
            done.get(task.name, 0),
            done.get(task.name, 0) + left.get(task.name, 0),
            task.name in begun,
            RANKS[person.role] < RANKS[config.tasks[task.name].role],
            must_practise(config, task.name, person),
            task.example is not None,
        )
        for task in tasks()
        if task.name in config.tasks
    ]


def _answered(session: Session, study: Study, person: Person) -> Mapping[TaskName, int]:
    rows = session.execute(
        select(Item.task, func.count())
        .join(Answer, Answer.item_id == Item.id)
        .where(Item.study_id == study.id, Answer.person_id == person.id)
        .group_by(Item.task)
    )
    return dict(rows.all())


def _begun(session: Session, study: Study, person: Person) -> set[TaskName]:
    answered = select(Answer.item_id).where(Answer.person_id == person.id)
    rows = session.scalars(
        select(Item.task)
        .join(Draft, Draft.item_id == Item.id)
        .where(
            Item.study_id == study.id,
            Draft.person_id == person.id,
            Item.id.not_in(answered),
        )
    )
    return set(rows)
