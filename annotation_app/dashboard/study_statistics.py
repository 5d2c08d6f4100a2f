"""Progress of a study, durations of its items, and the collected amounts."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, get_type_hints

import numpy as np
from sqlalchemy import (
    ColumnElement,
    and_,
    case,
    func,
    select,
)
from sqlalchemy.orm import Session

from annotation_app.dashboard.workers import has_answered
from annotation_app.store.database import decoded
from annotation_app.store.models import (
    BODY_TEXT,
    Answer,
    Item,
    Person,
    Record,
    Slot,
    Study,
    TaskName,
    queue_of,
)
from annotation_app.tasks.agreement import ModelErrors
from annotation_app.tasks.task_registry import task_names, tasks

QUARTILES = 0.25, 0.5, 0.75
COUNTED = "usual", "adjudicated"
"""Kinds of answers that count: not those to attention checks."""


@dataclass(frozen=True, slots=True)
class Progress:
    """Number of answers, of the number wanted. `video` is None for all videos."""

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
    """Times for which a task's items were with people, in seconds: quartiles."""

    task: TaskName
    answers: int
    lower_s: float
    median_s: float
    upper_s: float


def progress_by_video(session: Session, study_id: str, *, now: float) -> list[Progress]:
    """Return the progress of each task for each video, in the order of tasks."""
    # By what an index has in this order, so that nothing is sorted.
    video = Item.video
    leased = and_(Slot.answered.is_(False), Slot.expires_at >= now)
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
    found = [Progress(task, name or None, *counts) for task, name, *counts in rows if task in known]
    return sorted(found, key=lambda p: (known.index(p.task), p.video or ""))


def progress_by_task(by_video: list[Progress]) -> list[Progress]:
    """Return the progress of each task over all videos."""
    totals: list[Progress] = []
    for task in task_names():
        mine = [p for p in by_video if p.task == task]
        if mine:
            counts = ((p.wanted, p.answered, p.in_work) for p in mine)
            totals.append(Progress(task, None, *map(sum, zip(*counts, strict=True))))
    return totals


def durations(session: Session, study_id: str) -> list[Duration]:
    """Return the durations of items, by task, as far as they are known."""
    found = []
    for task in task_names():
        timed = (
            Answer.study_id == study_id,
            Answer.task == task,
            Answer.excluded.is_(False),
            Answer.seconds.is_not(None),
        )
        count = session.scalars(select(func.count()).where(*timed)).one()
        if count:
            quartiles = (_quantile(session, timed, part * (count - 1), count) for part in QUARTILES)
            found.append(Duration(task, count, *quartiles))
    return found


def _quantile(
    session: Session, timed: tuple[ColumnElement[bool], ...], place: float, count: int
) -> float:
    """Return the seconds at a place in their order, or between the neighbours, as NumPy does.

    An index is read from its nearer end.
    """
    before = math.floor(place)
    is_near = before <= count // 2
    order = Answer.seconds if is_near else Answer.seconds.desc()
    in_order = select(Answer.seconds).where(*timed).order_by(order)
    offset = before if is_near else count - before - 2
    beside = np.array(session.scalars(in_order.offset(offset).limit(2)).all(), dtype=np.float64)
    return float(np.percentile(beside, 100 * (place - before)))


@dataclass(frozen=True, slots=True)
class SuggestionUse:
    """Answers to a task by the fate of a program's suggestion, and their mean likeness to it."""

    task: TaskName
    shown: int
    changed: int
    likeness: float | None
    unsure: int
    """Answers where the suggestion was too improbable to be shown."""
    unsure_likeness: float | None


def suggestion_uses(session: Session, study_id: str) -> list[SuggestionUse]:
    """Return how often suggestions were changed, for each task that has some."""
    state = Answer.provenance["suggestion"].as_string()
    unchanged = Answer.provenance["unchanged"].as_boolean()
    rows = session.execute(
        select(
            Answer.task,
            state,
            func.count(),
            func.count().filter(unchanged.is_(False)),
            func.avg(Answer.provenance["likeness"].as_float()),
        )
        .where(*_counting(study_id), state.in_(("shown", "unsure")))
        .group_by(Answer.task, state)
    )
    found = {(task, how): tuple(counts) for task, how, *counts in rows}
    uses = []
    for task in task_names():
        shown, changed, likeness = found.get((task, "shown"), (0, 0, None))
        unsure, _, unsure_likeness = found.get((task, "unsure"), (0, 0, None))
        if shown or unsure:
            uses.append(SuggestionUse(task, shown, changed, likeness, unsure, unsure_likeness))
    return uses


def model_errors(session: Session, study_id: str) -> list[ModelErrors]:
    """Return the errors of the models whose suggestions people corrected, task by task."""
    study = session.get_one(Study, study_id)
    return [
        errors
        for task in tasks()
        if task.name in study.config["tasks"]
        for errors in task.model_errors(session, study)
    ]


@dataclass(frozen=True, slots=True)
class History:
    """Number of answers to a task by certain times, in seconds since 1970."""

    task: TaskName
    at: tuple[float, ...]
    answers: tuple[int, ...]


def histories(session: Session, study_id: str, *, now: float, moments: int = 40) -> list[History]:
    """Return the growth of each task's answers, from the first to now, at equal distances of time.

    Excluded answers don't count, nor do attention checks.
    """
    counted = select(Answer.task, Answer.at).where(*_counting(study_id))
    came: dict[TaskName, list[float]] = {task: [] for task in task_names()}
    for task, time in session.execute(counted.where(Answer.task.in_(came))):
        came[task].append(time)
    times = {task: np.sort(found) for task, found in came.items() if found}
    if not times:
        return []
    # Clocks may have been set back since.
    last = max(now, *(found[-1] for found in times.values()))
    at = np.linspace(min(found[0] for found in times.values()), last, moments)
    return [
        History(task, tuple(at.tolist()), tuple(np.searchsorted(found, at, "right").tolist()))
        for task, found in times.items()
    ]


def _counting(study_id: str) -> tuple[ColumnElement[bool], ...]:
    """Return the condition that an answer counts: neither excluded nor to an attention check."""
    return (
        Answer.study_id == study_id,
        Answer.kind.in_(COUNTED),
        Answer.excluded.is_(False),
    )


def collected(session: Session, study_id: str) -> Record:
    """Return the amounts collected so far: the counts of all tasks, ``annotators``, ``surplus``."""
    answers: dict[TaskName, list[tuple[Record, bool]]] = {}
    late = case((Answer.surplus & (Answer.kind == "usual"), 1), else_=0)
    surplus = 0
    for text, condition in (
        (Answer.gist, Answer.gist.is_not(None)),
        (BODY_TEXT, Answer.gist.is_(None)),
    ):
        rows = (
            select(Answer.task, text, Answer.adopted, func.count(), func.sum(late))
            .where(*_counting(study_id), condition)
            .group_by(Answer.task, text, Answer.adopted)
        )
        for task_name, content, adopted, count, late_ones in session.execute(rows):
            answers.setdefault(task_name, []).extend([(decoded(content or ""), adopted)] * count)
            surplus += late_ones
    found: Record = {}
    for task in tasks():
        if task.counts is not None:
            found |= dataclasses.asdict(task.counts.of(answers.get(task.name, [])))
    people = select(func.count()).select_from(Person).where(has_answered(study_id))
    found["annotators"] = session.scalars(people).one()
    found["surplus"] = surplus
    return found


def collected_type() -> type[Any]:
    """Return the type of the result of :func:`collected`, for the interface's description."""
    counts = [task.counts.type for task in tasks() if task.counts is not None]
    of_tasks = [pair for found in counts for pair in get_type_hints(found).items()]
    fields = [*of_tasks, ("annotators", int), ("surplus", int)]
    return dataclasses.make_dataclass("Collected", fields, namespace={"__doc__": _COLLECTED})


_COLLECTED = "What there is for a corpus."


@dataclass(frozen=True, slots=True)
class Forecast:
    """Amount of work that is left for the items that exist now.

    Parameters
    ----------
    answers
        Number of wanted answers that nobody has given.
    work_s
        Time that people need for them, by the median of each task; None if no median is known.
    untimed
        Tasks whose times aren't known, which `work_s` leaves out.
    calendar_s
        Time until then, if answers come as they did in the last week; None without such a pace.
    """

    answers: int
    work_s: float | None
    untimed: tuple[TaskName, ...]
    calendar_s: float | None


PACE_S = 7 * 86_400.0
"""Time over which the pace of answers is measured, in seconds."""
FEWEST_FOR_PACE, SHORTEST_PACE_S = 10, 600.0


def forecast(
    session: Session,
    study_id: str,
    by_task: Sequence[Progress],
    times: Sequence[Duration],
    *,
    now: float,
) -> Forecast:
    """Estimate the work that is left, and when it is done at the pace of the last week."""
    left = {p.task: p.wanted - p.answered for p in by_task if p.wanted > p.answered}
    medians = {d.task: d.median_s for d in times}
    timed = [count * medians[task] for task, count in left.items() if task in medians]
    recent = Answer.at > now - PACE_S, Answer.task.in_(task_names())
    count, first = session.execute(
        select(func.count(), func.min(Answer.at)).where(*_counting(study_id), *recent)
    ).one()
    calendar_s = None
    if count >= FEWEST_FOR_PACE and now - first >= SHORTEST_PACE_S:
        calendar_s = sum(left.values()) * (now - first) / count
    return Forecast(
        sum(left.values()),
        sum(timed) if timed else None,
        tuple(task for task in left if task not in medians),
        calendar_s,
    )


@dataclass(frozen=True, slots=True)
class AtWork:
    """A person who has an item, or has lately answered one."""

    person: Person
    task: TaskName
    at: float
    """Time of the latest answer, in seconds since 1970; infinite for people who have an item."""
    answers: int
    """Number of the answers in the last `LATELY_S`."""


LATELY_S = 3600.0


def at_work(session: Session, study_id: str, *, now: float) -> list[AtWork]:
    """Return the people who have an item now, then those who answered in the last hour."""
    # By the columns at the beginning of an index, so that few rows are read.
    queues = {queue_of(study_id, task): task for task in task_names()}
    having = select(Slot.person_id, Slot.queue).where(
        Slot.queue.in_(queues), Slot.answered.is_(False), Slot.expires_at >= now
    )
    lately = select(Answer.person_id, Answer.task, Answer.at).where(
        Answer.study_id == study_id,
        Answer.task.in_(task_names()),
        Answer.kind.in_((*COUNTED, "attention")),
        Answer.excluded.in_((False, True)),
        Answer.at > now - LATELY_S,
    )
    found: dict[str, tuple[TaskName, float, int]] = {}
    for person_id, task, at in session.execute(lately):
        known = found.get(person_id, (task, -math.inf, 0))
        latest = (task, at) if at > known[1] else known[:2]
        found[person_id] = (*latest, known[2] + 1)
    for holder, queue in session.execute(having):
        if holder is not None:
            task = queues[queue]
            found[holder] = (task, math.inf, found.get(holder, (task, 0.0, 0))[2])
    people = session.scalars(select(Person).where(Person.id.in_(found)))
    rows = [AtWork(person, *found[person.id]) for person in people]
    return sorted(rows, key=lambda row: (-row.at, -row.answers, row.person.id))
