"""On what the people of a study disagree most: tasks, sorts of clauses, words, things, items."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from sqlalchemy import select
from sqlalchemy.orm import Session

from annotation_app.store.models import Answer, Item, Record, TaskName
from annotation_app.tasks.agreement import CLAUSE_TYPE, PLACE, THING, WORDS, Part
from annotation_app.tasks.task_registry import find_task, tasks

KINDS = (CLAUSE_TYPE, WORDS, THING, PLACE)
MOST = 10


@dataclass(frozen=True, slots=True)
class Disagreement:
    """Something on which people disagree.

    Parameters
    ----------
    kind
        ``task``, ``item``, ``clause type``, ``words``, ``thing`` or ``place``.
    what
        Which: a name, words, an item's id.
    task
        In which task.
    video
        Where a thing or place is, and an item's video.
    disputed, parts
        On how many parts of answers people disagree, of how many that several people answered.
    command
        An item's.
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
        """The part that is disputed."""
        return round(100 * self.disputed / self.parts) if self.parts else 0


def disagreements(session: Session, study_id: str, most: int = MOST) -> list[Disagreement]:
    """Of each kind those on which people disagree most often; the most frequent come first."""
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
    """Items with the answers of several people; adjudicators have seen what others answered."""
    rows = session.execute(
        select(Item, Answer.body)
        .join(Answer, Answer.item_id == Item.id)
        .where(
            Answer.study_id == study_id,
            Answer.task.in_([task.name for task in tasks() if task.has_disputes]),
            Answer.kind == "usual",
            Answer.excluded.is_(False),
        )
        .order_by(Answer.id)
    )
    bodies: dict[str, tuple[Item, list[Record]]] = {}
    for item, body in rows:
        bodies.setdefault(item.id, (item, []))[1].append(body)
    return (pair for pair in bodies.values() if len(pair[1]) > 1)
