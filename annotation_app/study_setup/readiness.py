"""Obstacles in a study: tasks that nobody may do, or that never get any items."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from annotation_app.items.clips import source_file
from annotation_app.items.item_scenes import films_of
from annotation_app.items.media import VIDEOS
from annotation_app.items.replaced_videos import replaced
from annotation_app.people.participants import RANKS
from annotation_app.store.models import Item, Media, Person, Role, Study, TaskName
from annotation_app.studies.study_file import StudyConfig, restored
from annotation_app.study_setup.prepared_videos import looked_at
from annotation_app.tasks.task_record import COMMAND, Source, Task
from annotation_app.tasks.task_registry import find_task, tasks
from annotation_app.work.assigning import group_sizes
from corpus_tools.runtime.progress import OnProgress
from corpus_tools.video.frame_reading import has_decoder
from g3.errors import CorpusError


@dataclass(frozen=True, slots=True)
class Obstacle:
    """An obstacle to people's work, and its fix, as in errors.

    The study's name is empty for what is so in the whole installation.
    """

    study: str
    what: str
    fix: str

    def __str__(self) -> str:
        where = f"study {self.study}: " if self.study else ""
        return f"{where}{self.what} ({self.fix})"


def obstacles(
    session: Session, *, of_installation: bool = True, on_progress: OnProgress | None = None
) -> list[Obstacle]:
    """Find the obstacles to people's work in an installation's open studies.

    Parameters
    ----------
    on_progress
        Called while videos are decoded. If it is left out, or PyAV isn't installed, only those are
        named that have gone or were replaced.
    """
    logins, sizes = people_by_role(session), group_sizes(session)
    found: list[Obstacle] = []
    if of_installation and not logins["admin"]:
        what = "there is no admin, so nobody sees the dashboard or makes logins on it"
        found.append(Obstacle("", what, "ct annotate people invite --role admin"))
    studies = session.scalars(select(Study).where(Study.closed_at.is_(None)).order_by(Study.name))
    for study in studies:
        counts = session.execute(
            select(Item.task, func.count()).where(Item.study_id == study.id).group_by(Item.task)
        )
        items: dict[TaskName, int] = dict(counts.all())
        films = films_of(session, study.id).values()
        known = {film.has_things for film in films} or {True}
        config = restored(study.config)
        found += study_obstacles(config, logins, items, things_known=known, groups=sizes)
        wrong: list[CorpusError] = list(replaced(session, study.id))
        if on_progress is not None and not wrong and has_decoder():
            wrong += _not_watchable(session, study.id, on_progress)
        for error in wrong:
            where = f"{error.where}: " if error.where else ""
            found.append(Obstacle(study.name, f"{where}{error.what}", error.fix))
    return found


def _not_watchable(
    session: Session, study_id: str, on_progress: OnProgress
) -> Iterator[CorpusError]:
    """Yield the errors of a study's videos that can't be watched to their end."""
    paths = session.scalars(
        select(Media.path).where(Media.study_id == study_id, Media.role.in_(VIDEOS))
    )
    for file in dict.fromkeys(source_file(Path(path)) for path in paths):
        try:
            looked_at(file, on_progress)
        except CorpusError as error:
            yield error


def people_by_role(session: Session) -> Mapping[Role, int]:
    """Count the people that can sign in and may do at least as much as each role."""
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
"""People by role in an installation that doesn't exist yet."""


def study_obstacles(
    config: StudyConfig,
    logins: Mapping[Role, int],
    items: Mapping[TaskName, int],
    *,
    things_known: Collection[bool] = (True,),
    groups: Mapping[str, int] | None = None,
) -> Iterator[Obstacle]:
    """Find the obstacles to people's work in a study.

    `logins` are as :func:`people_by_role` counts them, `items` how many there are already, by task.
    `things_known` has True if the things in some videos are known, False if those in some aren't.
    `groups` are the numbers of members of groups, if they are known.
    """
    answers = max((of_task.answers for of_task in config.tasks.values()), default=1)
    sizes = {name: groups.get(name, 0) for name in config.groups} if groups is not None else {}
    for name, size in sizes.items():
        if size < answers:
            has = f"the group {name} has {size or 'no'} member{'' if size == 1 else 's'}"
            what = f"{has}, and items want {answers} answers: anybody gets those that it can't do"
            fix = f'ct annotate people group "{name}" LOGIN..., or the page Assign items'
            yield Obstacle(config.name, what, fix)
    for task in tasks():
        if task.name in config.tasks:
            sources = [task.source if known else task.without_scenes for known in things_known]
            if task.without_scenes is None:
                sources = [task.source]
            found = [*_nobody_does(config, task, logins)]
            if not items.get(task.name):
                found += _nothing_comes(config, task, [one for one in sources if one is not None])
            yield from (Obstacle(config.name, what, fix) for what, fix in found)
    for name in config.tasks:
        if find_task(name) is None:
            fix = "pip install the distribution that has it, or close the study"
            yield Obstacle(config.name, f"the task {name} is not installed here", fix)


def _nobody_does(
    config: StudyConfig, task: Task, logins: Mapping[Role, int]
) -> Iterator[tuple[str, str]]:
    """Yield the shortages of people who may do a task or decide about it, and their fixes."""
    of_task = config.tasks[task.name]
    invite = "ct annotate people invite --role"
    if of_task.role != "worker":
        there = logins[of_task.role]
        if not there:
            what = f"nobody may do the task {task.name}, which asks for the role {of_task.role}"
            yield what, f"{invite} {of_task.role}, or give the task role: worker"
        elif there < of_task.answers:
            what = (
                f"the task {task.name} asks for {of_task.answers} answers to each item, "
                f"by different people with a login, and {there} may do it"
            )
            yield what, f"{invite} {of_task.role}, or ask for fewer answers"
    alone = of_task.answers == 1 and of_task.adoption == "all"
    decides = of_task.adoption in ("all", "adjudicator") and not alone
    if task.adjudication is not None and decides and not logins["adjudicator"]:
        yield f"nobody may decide where answers to {task.name} differ", f"{invite} adjudicator"


def _nothing_comes(
    config: StudyConfig, task: Task, sources: Sequence[Source]
) -> Iterator[tuple[str, str]]:
    made_of = [source.made_of for source in sources]
    before = [other.name for other in tasks() if other.gives in made_of]
    has_own = any(not new.attention for new in task.of_study(config))
    has_own |= COMMAND in made_of and config.commands is not None
    if before and not has_own and not set(before) & (set(config.tasks) - {task.name}):
        fix = f"add the task {before[0]}, whose answers it is about"
        yield f"nothing ever comes to the task {task.name}", fix
