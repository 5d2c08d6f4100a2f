"""Whose work somebody should look at, and why."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from statistics import median
from typing import TypeAlias

from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.export.corpus_export import subject_of
from annotation_app.store.models import Answer, Item, Person, Record, Task

FEWEST = 5
"""Answers of a task by which a person can be told from others."""
FAST = 1 / 3
"""Of the others' median time."""
FEWEST_RATINGS = 8
FAILED_CHECKS, FAILED_SHARE = 2, 1 / 3
SAME_TEXTS = 3
AGREES, DISAGREES = 4, 2
"""From and up to which rating an attention check was understood."""


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
    median_s: dict[Task, float]
    checks: int
    failed: int
    reasons: tuple[str, ...]


_Medians: TypeAlias = dict[str, dict[Task, float]]
"""Seconds for an item, by person and task."""


@dataclass(slots=True)
class _Work:
    answers: int = 0
    seconds: dict[Task, list[float]] = field(default_factory=dict)
    checks: list[bool] = field(default_factory=list)
    ratings: list[int] = field(default_factory=list)
    texts: list[str] = field(default_factory=list)


def workers(session: Session, study_id: str) -> list[Worker]:
    """Everybody who has answered, those to look at first."""
    work: dict[str, _Work] = {}
    rows = session.execute(
        select(
            Answer.person_id, Answer.task, Answer.seconds, Answer.body, Item.attention, Item.payload
        )
        .join(Item, Item.id == Answer.item_id)
        .where(Item.study_id == study_id)
        .order_by(Answer.id)
    )
    for person_id, task, seconds, body, attention, payload in rows:
        right = payload["right"] if attention else None
        _add(work.setdefault(person_id, _Work()), task, seconds, body, right=right)
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


def passes(right: bool, rating: int) -> bool:
    """Whether an attention check was answered as it should be."""
    return rating >= AGREES if right else rating <= DISAGREES


def _add(
    mine: _Work, task: Task, seconds: float | None, body: Record, *, right: bool | None
) -> None:
    mine.answers += 1
    if seconds is not None:
        mine.seconds.setdefault(task, []).append(seconds)
    if right is not None:
        mine.checks.append(passes(right, body["rating"]))
    elif task == "rate":
        mine.ratings.append(body["rating"])
    elif task == "describe":
        mine.texts.append(body["text"].casefold())


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
    for task, own in medians[person_id].items():
        others = [
            theirs[task]
            for other, theirs in medians.items()
            if other != person_id and task in theirs
        ]
        if len(mine.seconds[task]) >= FEWEST and others and own < FAST * median(others):
            usual = median(others)
            yield f"too fast: {own:.0f} s for an item of {task}, others take {usual:.0f} s"
    if len(mine.ratings) >= FEWEST_RATINGS and len(set(mine.ratings)) == 1:
        yield f"always the same rating: {mine.ratings[0]}, {len(mine.ratings)} times"
    same = max((mine.texts.count(text) for text in set(mine.texts)), default=0)
    if same >= SAME_TEXTS:
        yield f"typed the same command {same} times"
