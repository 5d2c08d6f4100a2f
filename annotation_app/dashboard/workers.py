"""Workers whose work should be checked, and the reasons."""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from statistics import median
from typing import Literal, NamedTuple

import msgspec
import numpy as np
from sqlalchemy import ColumnElement, String, case, cast, exists, func, or_, select
from sqlalchemy.orm import Session

from annotation_app.items.new_items import GIVEN
from annotation_app.people.participants import platform_knowledge, subject_of
from annotation_app.people.person_names import anonymous_name, shown_name
from annotation_app.store.models import Answer, Item, Person, Record, TaskName
from annotation_app.tasks.agreement import FEWEST_ITEMS
from annotation_app.tasks.task_registry import task_names, tasks
from annotation_app.work.answer_flags import UNREAD, UNWATCHED, WATCHED_LONGER, answer_flags
from corpus_tools.corpus.rater_agreement import dawid_skene

FEWEST = 5
"""Answers of a task by which a person can be distinguished from others."""
FAST = 1 / 3
"""Share of the others' median time, below which work is fast."""
FAILED_CHECKS, FAILED_SHARE = 2, 1 / 3
FEWEST_FLAGS = {UNREAD: 3, UNWATCHED: 2, WATCHED_LONGER: 2}
"""Least number of odd answers that makes their author odd."""


@dataclass(frozen=True, slots=True)
class Worker:
    """Work of a person, and its oddities.

    Parameters
    ----------
    subject
        Part of a hash that exports have of the person.
    person, exported
        Names of the person on the dashboard, and in exports.
    checks, failed
        Attention checks that they had, and that they failed.
    weight
        Probability that a verdict of theirs is the true one, by task, in Dawid and Skene's model;
        only where at least `FEWEST_ITEMS` items have several verdicts.
    reasons
        Oddities, in plain words; empty for most people.
    platform
        Crowd platform's knowledge of the person; None for others, and before a comparison.
    """

    person_id: str
    subject: str
    person: str
    exported: str
    provider: str
    is_blocked: bool
    answers: int
    median_s: dict[TaskName, float]
    checks: int
    failed: int
    weight: dict[TaskName, float]
    reasons: tuple[str, ...]
    platform: Literal["known", "unknown"] | None = None


class _Median(NamedTuple):
    """Median of the seconds for an item, and the number of items."""

    seconds: float
    items: int


@dataclass(slots=True)
class _Work:
    answers: int = 0
    medians: dict[TaskName, _Median] = field(default_factory=dict)
    checks: list[bool] = field(default_factory=list)
    bodies: dict[TaskName, list[Record]] = field(default_factory=dict)
    flags: Counter[str] = field(default_factory=Counter)


def workers(session: Session, study_id: str, *, weighed: bool = False) -> list[Worker]:
    """Return everybody who has answered, those to look at first; with weights only if asked to.

    The session must read one state: what is counted first must be there when the rest is read.
    """
    work: dict[str, _Work] = {}
    for person_id, task_name, count, seconds in _times(session, study_id):
        mine = work.setdefault(person_id, _Work())
        mine.answers += count
        if seconds:
            mine.medians[task_name] = _Median(median(seconds), len(seconds))
    for person_id, passed in _checks(session, study_id):
        work[person_id].checks.append(passed)
    for person_id, task_name, bodies in _told(session, study_id):
        work[person_id].bodies.setdefault(task_name, []).extend(bodies)
    for person_id, flags in _flags(session, study_id):
        work[person_id].flags.update(flags)
    weights = _weights(session, study_id) if weighed else {}
    others = _by_task(work.values())
    knowledge = platform_knowledge(session, study_id)
    people = session.scalars(select(Person).where(has_answered(study_id)))
    found = [
        _worker(
            person, work[person.id], others, weights.get(person.id, {}), knowledge.get(person.id)
        )
        for person in people
    ]
    return sorted(found, key=lambda worker: (-len(worker.reasons), -worker.answers, worker.subject))


def has_answered(study_id: str) -> ColumnElement[bool]:
    """Return the condition of people with answers in a study; it reads one of each person's.

    A command that a table gives is no answer: nobody typed it here.
    """
    return exists().where(
        Answer.study_id == study_id,
        Answer.person_id == Person.id,
        ~Answer.subject.startswith(GIVEN),
    )


def flagged_people(session: Session, study_id: str) -> Iterator[str]:
    """Return the ids of people with something odd about their work."""
    return (worker.person_id for worker in workers(session, study_id) if worker.reasons)


def _checks(session: Session, study_id: str) -> Iterator[tuple[str, bool]]:
    """Yield the person of each attention check, and whether they passed."""
    passing = {task.name: task.passes for task in tasks() if task.passes is not None}
    unless_gist = case((Answer.gist.is_(None), Answer.body))
    rows = session.execute(
        select(Answer.person_id, Answer.task, Answer.item_id, Answer.gist, unless_gist)
        .where(Answer.study_id == study_id, Answer.kind == "attention", Answer.task.in_(passing))
        .order_by(Answer.id)
    )
    items = select(Item.id, Item.payload).where(Item.study_id == study_id, Item.attention.is_(True))
    payloads: dict[str, Record] = dict(session.execute(items).all())
    known: dict[tuple[str, str], bool] = {}
    for person_id, task_name, item_id, gist, body in rows:
        key = (item_id, gist or "")
        if gist is None or key not in known:
            told = body if gist is None else msgspec.json.decode(gist)
            known[key] = passing[task_name](payloads[item_id], told or {})
        yield person_id, known[key]


def _told(session: Session, study_id: str) -> Iterator[tuple[str, TaskName, list[Record]]]:
    """Yield people's answers to tasks that look for oddities in them; equal gists come together."""
    looking = [task.name for task in tasks() if task.oddities is not None]
    checking = [task.name for task in tasks() if task.passes is not None]
    told = (
        Answer.study_id == study_id,
        Answer.task.in_(looking),
        or_(Answer.kind != "attention", Answer.task.not_in(checking)),
    )
    columns = Answer.person_id, Answer.task, Answer.gist
    gists = select(*columns, func.count()).where(*told, Answer.gist.is_not(None)).group_by(*columns)
    for person_id, task_name, gist, count in session.execute(gists):
        yield person_id, task_name, [msgspec.json.decode(gist or "")] * count
    bodies = select(Answer.person_id, Answer.task, Answer.body)
    for person_id, task_name, body in session.execute(
        bodies.where(*told, Answer.gist.is_(None)).order_by(Answer.id)
    ):
        yield person_id, task_name, [body]


def _weights(session: Session, study_id: str) -> dict[str, dict[TaskName, float]]:
    """Return each person's weight by task, where the answers show how each of them errs."""
    found: dict[str, dict[TaskName, float]] = {}
    for task in tasks():
        if task.verdict is None:
            continue
        rows = session.execute(
            select(
                Answer.item_id,
                Answer.person_id,
                Answer.gist,
                case((Answer.gist.is_(None), Answer.body)),
            )
            .where(
                Answer.study_id == study_id,
                Answer.task == task.name,
                Answer.kind == "usual",
                Answer.excluded.is_(False),
            )
            .order_by(Answer.id)
        ).all()
        several = {item for item, count in Counter(row[0] for row in rows).items() if count > 1}
        if len(several) < FEWEST_ITEMS:
            continue
        _, item = np.unique([row[0] for row in rows], return_inverse=True)
        people, rater = np.unique([row[1] for row in rows], return_inverse=True)
        told = (body if gist is None else msgspec.json.decode(gist) for *_, gist, body in rows)
        model = dawid_skene(item, rater, np.array([task.verdict(one) for one in told]))
        for number, person_id in enumerate(people if not model.reason else ()):
            found.setdefault(str(person_id), {})[task.name] = model.accuracy(number)
    return found


def _flags(session: Session, study_id: str) -> Iterator[tuple[str, Iterator[str]]]:
    """Yield the oddities of single answers, of those that may be odd."""
    rows = session.execute(
        select(Answer.person_id, Item.payload, Answer.body, Answer.provenance, Answer.seconds)
        .join(Item, Item.id == Answer.item_id)
        .where(
            Answer.study_id == study_id,
            or_(Answer.odd_below_s.is_(None), Answer.seconds < Answer.odd_below_s),
        )
        .order_by(Answer.id)
    )
    for person_id, payload, body, provenance, seconds in rows:
        yield person_id, answer_flags(payload, body, provenance, seconds)


def _times(session: Session, study_id: str) -> Iterator[tuple[str, TaskName, int, list[float]]]:
    """Yield the number of each person's answers to each task, and the seconds that are known.

    An index has them in this order. As one text a person they take half the time of rows.
    """
    of_one = Answer.person_id, Answer.task
    texts = func.aggregate_strings(cast(Answer.seconds, String), ",")
    rows = session.execute(
        select(*of_one, func.count(), texts)
        .where(Answer.study_id == study_id)
        .group_by(*of_one)
        .order_by(*of_one)
    )
    known = task_names()
    for person_id, task_name, count, text in rows:
        timed = text is not None and task_name in known
        seconds = msgspec.json.decode(f"[{text}]", type=list[float]) if timed else []
        yield person_id, task_name, count, seconds


def _by_task(work: Iterable[_Work]) -> dict[TaskName, list[float]]:
    """Return all people's medians, in order, by task."""
    found: dict[TaskName, list[float]] = {}
    for mine in work:
        for task_name, one in mine.medians.items():
            found.setdefault(task_name, []).append(one.seconds)
    return {task_name: sorted(seconds) for task_name, seconds in found.items()}


def median_of_others(ordered: Sequence[float], own: float) -> float | None:
    """Return the median of ordered numbers without one of them; None if nothing is left."""
    left, out = len(ordered) - 1, bisect_left(ordered, own)
    if not left:
        return None
    low, high = (ordered[i + (i >= out)] for i in ((left - 1) // 2, left // 2))
    return low if left % 2 else (low + high) / 2


def _worker(
    person: Person,
    mine: _Work,
    ordered: Mapping[TaskName, Sequence[float]],
    weight: dict[TaskName, float],
    platform: Literal["known", "unknown"] | None,
) -> Worker:
    failed = mine.checks.count(False)
    unknown = ("the platform doesn't know them",) if platform == "unknown" else ()
    return Worker(
        person_id=person.id,
        subject=subject_of(person),
        person=shown_name(person),
        exported=anonymous_name(person),
        provider=person.provider,
        is_blocked=person.blocked_at is not None,
        answers=mine.answers,
        median_s={task_name: one.seconds for task_name, one in mine.medians.items()},
        checks=len(mine.checks),
        failed=failed,
        weight=weight,
        reasons=(*unknown, *_reasons(mine, failed, ordered)),
        platform=platform,
    )


def _reasons(
    mine: _Work, failed: int, ordered: Mapping[TaskName, Sequence[float]]
) -> Iterator[str]:
    if failed >= FAILED_CHECKS and failed > FAILED_SHARE * len(mine.checks):
        yield f"failed {failed} of {len(mine.checks)} attention checks"
    for name, own in mine.medians.items():
        usual = median_of_others(ordered[name], own.seconds)
        if own.items >= FEWEST and usual is not None and own.seconds < FAST * usual:
            yield f"too fast: {own.seconds:.0f} s for an item of {name}, others take {usual:.0f} s"
    for flag, count in mine.flags.items():
        if count >= FEWEST_FLAGS[flag]:
            yield f"{flag}: {'once' if count == 1 else f'{count} times'}"
    for task in tasks():
        if task.oddities is not None:
            yield from task.oddities(mine.bodies.get(task.name, []))
