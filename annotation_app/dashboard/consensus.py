"""Agreement of a study's people, task by task, and their most frequent disagreements."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import msgspec
from sqlalchemy import ColumnElement, and_, func, select
from sqlalchemy.orm import Session

from annotation_app.store.models import Answer, Item, Record, TaskName
from annotation_app.tasks.agreement import CLAUSE_TYPE, PLACE, THING, WORDS, Measured, Part
from annotation_app.tasks.task_registry import find_task, task_names, tasks
from annotation_app.work.answer_flags import is_untouched

ALL, TOUCHED, UNSEEN = "all", "without untouched suggestions", "no suggestion seen"
"""Groups of answers that are measured. Where a program makes suggestions: all, those that are no
untouched suggestion, and those of people who saw none."""
_BETWEEN = "\n"
"""Separator of the gists of an item, which have no such character."""

KINDS = (CLAUSE_TYPE, WORDS, THING, PLACE)
MOST = 10


def agreement(session: Session, study_id: str) -> list[Measured]:
    """Measure the agreement so far, of all tasks that several people answer."""
    answered = _by_gists(session, study_id)
    for key, items in _by_bodies(session, study_id).items():
        answered.setdefault(key, []).extend(items.values())
    return [
        replace(found, task=task.name, answers=group)
        for task in tasks()
        for group in ((ALL,) if task.suggestion is None else (ALL, TOUCHED, UNSEEN))
        for found in task.agreement(answered.get((task.name, group), []))
    ]


_Group: TypeAlias = tuple[TaskName, str]
"""A task, and which of its answers."""


def _by_gists(session: Session, study_id: str) -> dict[_Group, list[list[Record]]]:
    """Return the answers to the items of which all answers have gists.

    Items with the same answers are counted by the database, and read once.
    """
    gists = func.aggregate_strings(Answer.gist, _BETWEEN)
    items = (
        select(Answer.task, gists.label("gists"))
        .where(*_compared(study_id), Answer.task.in_(_with_gists()))
        .group_by(Answer.task, Answer.item_id)
        .having(func.count(Answer.gist) == func.count())
        .subquery()
    )
    same = items.c.task, items.c.gists
    rows = select(*same, func.count()).group_by(*same)
    found: dict[_Group, list[list[Record]]] = {}
    for task, texts, count in session.execute(rows):
        bodies = [msgspec.json.decode(text) for text in texts.split(_BETWEEN)]
        found.setdefault((task, ALL), []).extend([bodies] * count)
    return found


def _by_bodies(session: Session, study_id: str) -> dict[_Group, dict[str, list[Record]]]:
    """Return the answers to the other items."""
    compared, with_gists = _compared(study_id), _with_gists()
    without = select(Answer.item_id).where(*compared, Answer.gist.is_(None))
    found: dict[_Group, dict[str, list[Record]]] = {}
    for condition in (
        Answer.task.in_([name for name in task_names() if name not in with_gists]),
        and_(Answer.task.in_(with_gists), Answer.item_id.in_(without)),
    ):
        rows = (
            select(Answer.task, Answer.item_id, Answer.body, Answer.provenance)
            .where(*compared, condition)
            .order_by(Answer.id)
        )
        for task, item_id, body, provenance in session.execute(rows):
            for group in _groups(provenance):
                found.setdefault((task, group), {}).setdefault(item_id, []).append(body)
    return found


def _compared(study_id: str) -> tuple[ColumnElement[bool], ...]:
    """Return the condition of compared answers: adjudicators have seen those of others."""
    return Answer.study_id == study_id, Answer.kind == "usual", Answer.excluded.is_(False)


def _with_gists() -> list[TaskName]:
    """Return the tasks fully described by their gist, which doesn't show an answer's group."""
    return [task.name for task in tasks() if task.gist is not None and task.suggestion is None]


def _groups(provenance: Record | None) -> Iterator[str]:
    """Yield the groups of an answer; for old ones the shown suggestions are unknown."""
    yield ALL
    if provenance is None:
        return
    if provenance["suggestion"] != "shown":
        yield UNSEEN
    if not is_untouched(provenance):
        yield TOUCHED


@dataclass(frozen=True, slots=True)
class Disagreement:
    """Something on which people disagree.

    Parameters
    ----------
    kind
        ``task``, ``item``, ``clause type``, ``words``, ``thing`` or ``place``.
    what
        Subject of the disagreement: a name, words, an item's id.
    task
        Task of the answers.
    video
        Video of a thing, place or item.
    disputed, parts
        Number of parts of answers on which people disagree, and of parts with several answers.
    command
        Command of an item.
    """

    kind: str
    what: str
    task: TaskName
    video: str
    disputed: int
    parts: int
    command: str = ""

    @property
    def percent(self) -> int:
        """Share of disputed parts, in percent."""
        return round(100 * self.disputed / self.parts) if self.parts else 0


def disagreements(session: Session, study_id: str, most: int = MOST) -> list[Disagreement]:
    """Return the most frequent disagreements of each kind, most frequent first."""
    counts: dict[tuple[str, str, TaskName, str, str], list[int]] = {}
    for item, bodies in _answered(session, study_id):
        task = find_task(item.task)
        parts = list(task.disputed(item, bodies)) if task is not None else []
        for part in parts:
            _count(counts, (part.kind, part.what, item.task, part.video, ""), [part])
        if parts:
            _count(counts, ("task", item.task, item.task, "", ""), parts)
            _count(counts, ("item", item.id, item.task, item.video, item.command), parts)
    found = [
        Disagreement(kind, what, task, video, disputed, parts, command)
        for (kind, what, task, video, command), (disputed, parts) in counts.items()
        if disputed
    ]
    found.sort(key=lambda one: (-one.disputed, -one.disputed / one.parts, one.what))
    return [
        one
        for kind in ("task", *KINDS, "item")
        for one in [one for one in found if one.kind == kind][:most]
    ]


def _count(
    counts: dict[tuple[str, str, TaskName, str, str], list[int]],
    key: tuple[str, str, TaskName, str, str],
    parts: Sequence[Part],
) -> None:
    row = counts.setdefault(key, [0, 0])
    row[0] += sum(part.differs for part in parts)
    row[1] += len(parts)


def _answered(session: Session, study_id: str) -> Iterable[tuple[Item, list[Record]]]:
    """Return items with the answers of several people."""
    rows = session.execute(
        select(Item, Answer.body)
        .join(Answer, Answer.item_id == Item.id)
        .where(
            *_compared(study_id),
            Answer.task.in_([task.name for task in tasks() if task.has_disputes]),
        )
        .order_by(Answer.id)
    )
    bodies: dict[str, tuple[Item, list[Record]]] = {}
    for item, body in rows:
        bodies.setdefault(item.id, (item, []))[1].append(body)
    return (pair for pair in bodies.values() if len(pair[1]) > 1)
