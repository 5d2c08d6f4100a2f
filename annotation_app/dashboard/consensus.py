"""Agreement of a study's people, task by task, and their most frequent disagreements."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from operator import itemgetter
from typing import Any, TypeAlias

import numpy as np
from sqlalchemy import ColumnElement, and_, func, select
from sqlalchemy.orm import Session

from annotation_app.items.item_scenes import scene_of
from annotation_app.items.scenes import place_names, thing_names
from annotation_app.store.database import decoded
from annotation_app.store.models import BODY_TEXT, Answer, Item, Record, TaskName
from annotation_app.tasks.agreement import (
    CLAUSE_TYPE,
    FEWEST_ITEMS,
    PLACE,
    THING,
    WORDS,
    Measured,
    Part,
    figures,
)
from annotation_app.tasks.task_record import Task
from annotation_app.tasks.task_registry import find_task, tasks
from annotation_app.work.answer_flags import is_untouched

ALL, TOUCHED, UNSEEN = "all", "without untouched suggestions", "no suggestion seen"
"""Groups of answers that are measured. Where a program makes suggestions: all, those that are no
untouched suggestion, and those of people who saw none."""
_BETWEEN = "\n"
"""Separator of an item's answers as JSON, which has no such character."""

KINDS = (CLAUSE_TYPE, WORDS, THING, PLACE)
MOST = 10
WINDOWS = 8
"""Largest number of points of agreement over time."""
GROUPS, SAMPLE = 10, 200
"""Groups of the jackknife, and the number of items that it looks at."""


@dataclass(frozen=True, slots=True)
class AgreementOverTime:
    """A task's first measure, of items that were finished by certain times (since 1970)."""

    task: TaskName
    at: tuple[float, ...]
    measured: tuple[Measured, ...]


@dataclass(frozen=True, slots=True)
class Consensus:
    """Agreement over all items, and of one part of the items after the other."""

    overall: list[Measured]
    over_time: list[AgreementOverTime]


def agreement(session: Session, study_id: str) -> list[Measured]:
    """Measure the agreement so far, of all tasks that several people answer."""
    return consensus(session, study_id).overall


def consensus(session: Session, study_id: str) -> Consensus:
    """Measure the agreement so far, and its change over time.

    There is no value below `FEWEST_ITEMS` items. The others have an interval of 95 %.
    """
    answered: _Answered = defaultdict(list)
    _add_gists(session, study_id, answered)
    _add_bodies(session, study_id, answered)
    edges, all_windows = _windows(answered)
    overall = []
    over_time = []
    for task in tasks():
        if (task.name, ALL) not in all_windows:  # few studies have all tasks
            continue
        for group in (ALL,) if task.suggestion is None else (ALL, TOUCHED, UNSEEN):
            windows = all_windows.get((task.name, group), [])
            found = _estimated(task, [item for window in windows for item in window])
            overall += [replace(one, task=task.name, answers=group) for one in found]
            if group == ALL and found and found[0].value is not None:
                over_time.append(_over_time(session, task, windows, edges))
    return Consensus(overall, over_time)


def _over_time(
    session: Session, task: Task, windows: Sequence[list[_Units]], edges: Sequence[int]
) -> AgreementOverTime:
    """Measure one part of the items after the other; too small a part goes with the next one."""
    at, found, items = [], [], list[_Units]()
    for window, edge in zip(windows, (*edges, None), strict=True):
        items += window
        first, *_ = _estimated(task, items) or [Measured("", None, 0)]
        if first.value is not None:
            at.append(_time_of(session, edge))
            found.append(replace(first, task=task.name))
            items = []
    return AgreementOverTime(task.name, tuple(at), tuple(found))


def _time_of(session: Session, answer_id: int | None) -> float:
    """Return when an answer, or the next one, came; for None the last answer's time."""
    if answer_id is None:
        return session.scalars(select(Answer.at).order_by(Answer.id.desc()).limit(1)).one()
    later = select(Answer.at).where(Answer.id >= answer_id).order_by(Answer.id).limit(1)
    return session.scalars(later).one()


def _estimated(task: Task, items: Sequence[_Units]) -> list[Measured]:
    """Measure a task's agreement with intervals, by leaving out one group of items after the other.

    The grouped jackknife (Wolter, *Introduction to Variance Estimation*, 2007, section 4.2), by
    item. The interval is that of Student's t. Where all groups agree equally there is none.
    """
    whole = [replace(one, items=len(items)) for one in figures(task.agreement, items)]
    if len(items) < FEWEST_ITEMS:
        few = [replace(one, value=None, reason="few items") for one in whole]
        return [one if one.value is None else less for one, less in zip(whole, few, strict=True)]
    sample = items[:: math.ceil(len(items) / SAMPLE)]
    groups = min(GROUPS, len(sample))
    values = defaultdict(list)
    for group in range(groups):
        left = [item for n, item in enumerate(sample) if n % groups != group]
        for one in figures(task.agreement, left):
            values[one.measure].append(math.nan if one.value is None else one.value)
    return [_bounded(one, values[one.measure], len(sample) / len(items)) for one in whole]


def _bounded(one: Measured, values: Sequence[float], share: float) -> Measured:
    from scipy.special import stdtrit  # noqa: PLC0415 - takes long, and few pages need it

    spread = math.sqrt((len(values) - 1) * np.var(values) * share) if values else math.nan
    if one.value is None or not spread > 0:
        return one
    reach = float(stdtrit(len(values) - 1, 0.975)) * spread
    return replace(one, low=max(one.value - reach, -1.0), high=min(one.value + reach, 1.0))


_Group: TypeAlias = tuple[TaskName, str]
"""A task, and which of its answers."""
_Units: TypeAlias = tuple[Sequence[Any], ...]
"""Units of the answers to an item, by each measure of its task."""
_Answered: TypeAlias = dict[_Group, list[tuple[int, _Units | None]]]
"""The id of each item's last answer, and what is compared; None of an item with one answer.
Ids grow with time."""


@lru_cache(maxsize=8192)  # the dashboard looks again, and most items are as they were
def _units(task_name: TaskName, texts: str) -> _Units | None:
    """Compare the answers to an item, from their JSON between `_BETWEEN`."""
    task = find_task(task_name)
    bodies = [decoded(text) for text in texts.split(_BETWEEN)]
    if task is None or len(bodies) < 2:
        return None
    answers = [[measure.read(body) for measure in task.agreement] for body in bodies]
    return tuple(m.units([one[n] for one in answers]) for n, m in enumerate(task.agreement))


def _windows(answered: _Answered) -> tuple[list[int], dict[_Group, list[list[_Units]]]]:
    """Return the ids that begin all windows but the first, and the items finished in each."""
    ids = [last for items in answered.values() for last, _ in items]
    first, last = min(ids, default=0), max(ids, default=0)
    edges = [first + (last - first) * n // WINDOWS for n in range(1, WINDOWS)]
    windows = {}
    for group, items in answered.items():
        windows[group] = [list[_Units]() for _ in range(WINDOWS)]
        # In an order of their own, so that samples of them are always the same.
        for last, units in sorted(items, key=itemgetter(0)):
            if units is not None:
                windows[group][bisect_right(edges, last)].append(units)
    return edges, windows


def _add_gists(session: Session, study_id: str, answered: _Answered) -> None:
    """Add the answers to the items of which all answers have gists; equal ones are read once."""
    rows = session.execute(
        select(Answer.task, func.max(Answer.id), func.aggregate_strings(Answer.gist, _BETWEEN))
        .where(*_compared(study_id), Answer.task.in_(_with_gists()))
        .group_by(Answer.task, Answer.item_id)
        .having(func.count(Answer.gist) == func.count())
    )
    for task, last, texts in rows:
        answered[task, ALL].append((last, _units(task, texts)))


def _add_bodies(session: Session, study_id: str, answered: _Answered) -> None:
    """Add the answers to the other items."""
    compared, with_gists = _compared(study_id), _with_gists()
    without = select(Answer.item_id).where(*compared, Answer.gist.is_(None))
    for condition in (
        Answer.task.in_([t.name for t in tasks() if t.agreement and t.name not in with_gists]),
        and_(Answer.task.in_(with_gists), Answer.item_id.in_(without)),
    ):
        rows = (
            select(Answer.id, Answer.task, Answer.item_id, BODY_TEXT, Answer.provenance)
            .where(*compared, condition)
            .order_by(Answer.id)
        )
        found: dict[_Group, dict[str, list[str]]] = {}
        last: dict[str, int] = {}
        for number, task, item_id, text, provenance in session.execute(rows):
            last[item_id] = number
            for group in _groups(provenance):
                found.setdefault((task, group), {}).setdefault(item_id, []).append(text)
        for key, items in found.items():
            answered[key] += [
                (last[item_id], _units(key[0], _BETWEEN.join(texts)))
                for item_id, texts in items.items()
            ]


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
        _named(session, study_id, one)
        for kind in ("task", *KINDS, "item")
        for one in [one for one in found if one.kind == kind][:most]
    ]


def _named(session: Session, study_id: str, one: Disagreement) -> Disagreement:
    """Return a disagreement on a thing or a place with its name instead of its id."""
    if one.kind not in (THING, PLACE):
        return one
    context = scene_of(session, study_id, one.video).context
    if one.kind == THING:
        return replace(one, what=thing_names(context).get(one.what, one.what))
    return replace(one, what=place_names(context)[int(one.what)])


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
