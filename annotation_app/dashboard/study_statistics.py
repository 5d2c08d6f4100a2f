"""How far a study is, how long its items take, and what has been collected."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, get_type_hints

import numpy as np
from sqlalchemy import and_, func, select
from sqlalchemy.orm import Session

from annotation_app.store.models import Answer, Event, Item, Record, Slot, TaskName
from annotation_app.tasks.task_registry import task_names, tasks


@dataclass(frozen=True, slots=True)
class Progress:
    """How many answers there are of those that are wanted. `video` is None for all videos."""

    task: TaskName
    video: str | None
    wanted: int
    answered: int
    in_work: int

    @property
    def percent(self) -> int:
        """Rounded down, so that 100 is all."""
        return 100 * self.answered // self.wanted if self.wanted else 0


@dataclass(frozen=True, slots=True)
class Duration:
    """How long a task's items were with people, in seconds: quartiles."""

    task: TaskName
    answers: int
    lower_s: float
    median_s: float
    upper_s: float


def progress_by_video(session: Session, study_id: str, *, now: float) -> list[Progress]:
    """Progress of each task for each video, in the order of tasks."""
    video = func.nullif(Item.video, "")
    leased = and_(Slot.answered.is_(False), Slot.person_id.is_not(None), Slot.expires_at >= now)
    rows = session.execute(
        select(
            Item.task,
            video,
            func.count(),
            func.count().filter(Slot.answered),
            func.count().filter(leased),
        )
        .select_from(Slot)
        .join(Item, Item.id == Slot.item_id)
        .where(Item.study_id == study_id, Item.attention.is_(False))
        .group_by(Item.task, video)
    )
    known = task_names()
    found = [Progress(*row) for row in rows if row[0] in known]
    return sorted(found, key=lambda p: (known.index(p.task), p.video or ""))


def progress_by_task(by_video: list[Progress]) -> list[Progress]:
    """Progress of each task over all videos."""
    totals: list[Progress] = []
    for task in task_names():
        mine = [p for p in by_video if p.task == task]
        if mine:
            totals.append(
                Progress(
                    task,
                    None,
                    sum(p.wanted for p in mine),
                    sum(p.answered for p in mine),
                    sum(p.in_work for p in mine),
                )
            )
    return totals


def durations(session: Session, study_id: str) -> list[Duration]:
    """How long items take, by task, as far as that is known."""
    rows = session.execute(
        select(Answer.task, Answer.seconds)
        .join(Item, Item.id == Answer.item_id)
        .where(Item.study_id == study_id, Answer.excluded.is_(False))
    )
    seconds: dict[TaskName, list[float]] = {}
    for task, taken in rows:
        if taken is not None:
            seconds.setdefault(task, []).append(taken)
    return [
        Duration(task, len(seconds[task]), *map(float, np.percentile(seconds[task], (25, 50, 75))))
        for task in task_names()
        if task in seconds
    ]


@dataclass(frozen=True, slots=True)
class History:
    """How many answers to a task there were by certain times, in seconds since 1970."""

    task: TaskName
    at: tuple[float, ...]
    answers: tuple[int, ...]


def histories(session: Session, study_id: str, *, now: float, moments: int = 40) -> list[History]:
    """How the answers to each task came, from the first to now, at times of equal distance.

    Answers that were left out don't count, nor do attention checks.
    """
    rows = session.execute(
        select(Answer.task, Answer.at)
        .join(Item, Item.id == Answer.item_id)
        .where(Item.study_id == study_id, Item.attention.is_(False), Answer.excluded.is_(False))
    )
    times: dict[TaskName, list[float]] = {}
    for task, came_at in rows:
        times.setdefault(task, []).append(came_at)
    if not times:
        return []
    every = [came_at for of_task in times.values() for came_at in of_task]
    # Clocks may have been set back since.
    at = np.linspace(min(every), max(now, *every), moments)
    return [
        History(
            task,
            tuple(at.tolist()),
            tuple(np.searchsorted(np.sort(times[task]), at, side="right").tolist()),
        )
        for task in task_names()
        if task in times
    ]


def collected(session: Session, study_id: str) -> Record:
    """What people have given so far: the counts of all tasks, ``annotators`` and ``surplus``."""
    rows = session.execute(
        select(
            Answer.task,
            Answer.body,
            Answer.adopted,
            and_(Answer.surplus, Event.name != "adjudicate"),
        )
        .join(Item, Item.id == Answer.item_id)
        .join(Event, Event.id == Answer.event_id)
        .where(Item.study_id == study_id, Item.attention.is_(False), Answer.excluded.is_(False))
    ).all()
    answers: dict[TaskName, list[tuple[Record, bool]]] = {}
    for task_name, body, adopted, _ in rows:
        answers.setdefault(task_name, []).append((body, adopted))
    found: Record = {}
    for task in tasks():
        if task.counts is not None:
            found |= dataclasses.asdict(task.counts.of(answers.get(task.name, [])))
    people = (
        select(func.count(Answer.person_id.distinct()))
        .join(Item, Item.id == Answer.item_id)
        .where(Item.study_id == study_id)
    )
    found["annotators"] = session.scalar(people) or 0
    found["surplus"] = sum(is_late for _, _, _, is_late in rows)
    return found


def collected_type() -> type[Any]:
    """The type of what :func:`collected` gives, for the interface's description."""
    counts = [task.counts.type for task in tasks() if task.counts is not None]
    of_tasks = [pair for found in counts for pair in get_type_hints(found).items()]
    fields = [*of_tasks, ("annotators", int), ("surplus", int)]
    return dataclasses.make_dataclass("Collected", fields, namespace={"__doc__": _COLLECTED})


_COLLECTED = "What there is for a corpus."
