"""Whose work somebody should look at, and why."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from statistics import median
from typing import TypeAlias

from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.people.participants import subject_of
from annotation_app.store.models import Answer, Item, Person, Record, TaskName
from annotation_app.tasks.task_record import Task
from annotation_app.tasks.task_registry import find_task, tasks
from annotation_app.work.answer_flags import UNREAD, WATCHED_LONGER, answer_flags

FEWEST = 5
"""Answers of a task by which a person can be distinguished from others."""
FAST = 1 / 3
"""Of the others' median time."""
FAILED_CHECKS, FAILED_SHARE = 2, 1 / 3
FEWEST_FLAGS = {UNREAD: 3, WATCHED_LONGER: 2}
"""How often an answer must be odd for its author to be."""


@dataclass(frozen=True, slots=True)
class Worker:
    """What somebody has done, and what is odd about it.

    Parameters
    ----------
    subject
        What exports call them.
    checks, failed
        Attention checks that they had, and that they failed.
    reasons
        What is odd, in plain words; empty for most people.
    """

    person_id: str
    subject: str
    provider: str
    is_blocked: bool
    answers: int
    median_s: dict[TaskName, float]
    checks: int
    failed: int
    reasons: tuple[str, ...]


_Medians: TypeAlias = dict[str, dict[TaskName, float]]
"""Seconds for an item, by person and task."""


@dataclass(slots=True)
class _Work:
    answers: int = 0
    seconds: dict[TaskName, list[float]] = field(default_factory=dict)
    checks: list[bool] = field(default_factory=list)
    bodies: dict[TaskName, list[Record]] = field(default_factory=dict)
    flags: Counter[str] = field(default_factory=Counter)


def workers(session: Session, study_id: str) -> list[Worker]:
    """Everybody who has answered, those to look at first."""
    work: dict[str, _Work] = {}
    rows = session.execute(
        select(
            Answer.person_id,
            Answer.task,
            Answer.seconds,
            Answer.body,
            Answer.provenance,
            Item.attention,
            Item.payload,
        )
        .join(Item, Item.id == Answer.item_id)
        .where(Item.study_id == study_id)
        .order_by(Answer.id)
    )
    for person_id, task, seconds, body, provenance, attention, payload in rows:
        check = payload if attention else None
        mine = work.setdefault(person_id, _Work())
        mine.flags.update(answer_flags(payload, body, provenance, seconds))
        _add(mine, find_task(task), seconds, body, check)
    medians = {
        person_id: {task: median(seconds) for task, seconds in mine.seconds.items()}
        for person_id, mine in work.items()
    }
    people = session.scalars(select(Person).where(Person.id.in_(work)))
    found = [_worker(person, work[person.id], medians) for person in people]
    return sorted(found, key=lambda worker: (-len(worker.reasons), -worker.answers, worker.subject))


def flagged_people(session: Session, study_id: str) -> Iterator[str]:
    """The ids of people with something odd about their work."""
    return (worker.person_id for worker in workers(session, study_id) if worker.reasons)


def _add(
    mine: _Work, task: Task | None, seconds: float | None, body: Record, check: Record | None
) -> None:
    mine.answers += 1
    if task is None:
        return
    if seconds is not None:
        mine.seconds.setdefault(task.name, []).append(seconds)
    if check is not None and task.passes is not None:
        mine.checks.append(task.passes(check, body))
    elif task.oddities is not None:
        mine.bodies.setdefault(task.name, []).append(body)


def _worker(person: Person, mine: _Work, medians: _Medians) -> Worker:
    failed = mine.checks.count(False)
    return Worker(
        person_id=person.id,
        subject=subject_of(person),
        provider=person.provider,
        is_blocked=person.blocked_at is not None,
        answers=mine.answers,
        median_s=medians[person.id],
        checks=len(mine.checks),
        failed=failed,
        reasons=tuple(_reasons(person.id, mine, failed, medians)),
    )


def _reasons(person_id: str, mine: _Work, failed: int, medians: _Medians) -> Iterator[str]:
    if failed >= FAILED_CHECKS and failed > FAILED_SHARE * len(mine.checks):
        yield f"failed {failed} of {len(mine.checks)} attention checks"
    for name, own in medians[person_id].items():
        others = [
            theirs[name]
            for other, theirs in medians.items()
            if other != person_id and name in theirs
        ]
        if len(mine.seconds[name]) >= FEWEST and others and own < FAST * median(others):
            usual = median(others)
            yield f"too fast: {own:.0f} s for an item of {name}, others take {usual:.0f} s"
    yield from (f"{flag}: {_times(n)}" for flag, n in mine.flags.items() if n >= FEWEST_FLAGS[flag])
    for task in tasks():
        if task.oddities is not None:
            yield from task.oddities(mine.bodies.get(task.name, []))


def _times(count: int) -> str:
    return "once" if count == 1 else f"{count} times"
