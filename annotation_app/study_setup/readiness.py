"""What would stop people in a study: tasks that nobody may do, or that nothing ever comes to."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from annotation_app.items.item_scenes import films_of
from annotation_app.people.participants import RANKS
from annotation_app.store.models import Item, Person, Role, Study, TaskName
from annotation_app.studies.study_file import StudyConfig, restored
from annotation_app.tasks.task_record import COMMAND, Source, Task
from annotation_app.tasks.task_registry import find_task, tasks


@dataclass(frozen=True, slots=True)
class Obstacle:
    """What would stop people.

    Parameters
    ----------
    study
        Its name; empty for what is so in the whole installation.
    what, fix
        As in errors.
    """

    study: str
    what: str
    fix: str

    def __str__(self) -> str:
        where = f"study {self.study}: " if self.study else ""
        return f"{where}{self.what} ({self.fix})"


def obstacles(session: Session, *, of_installation: bool = True) -> list[Obstacle]:
    """What would stop people in an installation's open studies."""
    logins = people_by_role(session)
    found: list[Obstacle] = []
    if of_installation and not logins["admin"]:
        found.append(
            Obstacle(
                "",
                "there is no admin, so nobody sees the dashboard or makes logins on it",
                "ct annotate people invite --role admin",
            )
        )
    studies = session.scalars(select(Study).where(Study.closed_at.is_(None)).order_by(Study.name))
    for study in studies:
        counts = session.execute(
            select(Item.task, func.count()).where(Item.study_id == study.id).group_by(Item.task)
        )
        items: dict[TaskName, int] = dict(counts.all())
        films = films_of(session, study.id).values()
        known = not films or any(film.has_things for film in films)
        found += study_obstacles(restored(study.config), logins, items, has_scenes=known)
    return found


def people_by_role(session: Session) -> Mapping[Role, int]:
    """How many people can sign in and may do at least what each role may."""
    roles = session.scalars(
        select(Person.role).where(
            Person.login.is_not(None),
            Person.password_hash.is_not(None),
            Person.blocked_at.is_(None),
        )
    )
    counts = Counter(RANKS[role] for role in roles)
    return {
        role: sum(count for other, count in counts.items() if other >= rank)
        for role, rank in RANKS.items()
    }


NOBODY: Mapping[Role, int] = dict.fromkeys(RANKS, 0)
"""Who there is in an installation that isn't there yet."""


def study_obstacles(
    config: StudyConfig,
    logins: Mapping[Role, int],
    items: Mapping[TaskName, int],
    *,
    has_scenes: bool = True,
) -> Iterator[Obstacle]:
    """What would stop people in a study.

    Parameters
    ----------
    logins
        As :func:`people_by_role` counts them.
    items
        How many there are already, by task.
    has_scenes
        Whether it is known what is where in the videos.
    """
    for task in tasks():
        if task.name in config.tasks:
            yield from _nobody_does(config, task, logins)
            source = task.source if has_scenes else task.without_scenes or task.source
            if source is not None and not items.get(task.name):
                yield from _nothing_comes(config, task, source)
    for name in config.tasks:
        if find_task(name) is None:
            yield Obstacle(
                config.name,
                f"the task {name} is not installed here",
                "pip install the distribution that has it, or close the study",
            )


def _nobody_does(config: StudyConfig, task: Task, logins: Mapping[Role, int]) -> Iterator[Obstacle]:
    of_task = config.tasks[task.name]
    if of_task.role != "worker":
        there = logins[of_task.role]
        if not there:
            yield Obstacle(
                config.name,
                f"nobody may do the task {task.name}, which asks for the role {of_task.role}",
                f"ct annotate people invite --role {of_task.role}, or give the task role: worker",
            )
        elif there < of_task.answers:
            yield Obstacle(
                config.name,
                f"the task {task.name} asks for {of_task.answers} answers to each item, "
                f"by different people with a login, and {there} may do it",
                f"ct annotate people invite --role {of_task.role}, or ask for fewer answers",
            )
    if task.adjudication is not None and of_task.answers > 1 and not logins["adjudicator"]:
        yield Obstacle(
            config.name,
            f"nobody may decide where answers to {task.name} differ",
            "ct annotate people invite --role adjudicator",
        )


def _nothing_comes(config: StudyConfig, task: Task, source: Source) -> Iterator[Obstacle]:
    before = [other.name for other in tasks() if other.gives == source.made_of]
    has_own = any(not new.attention for new in task.of_study(config))
    has_own |= source.made_of == COMMAND and config.commands is not None
    if before and not has_own and not set(before) & (set(config.tasks) - {task.name}):
        yield Obstacle(
            config.name,
            f"nothing ever comes to the task {task.name}",
            f"add the task {before[0]}, whose answers it is about",
        )
