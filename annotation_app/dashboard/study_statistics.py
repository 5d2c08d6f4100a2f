"""How far a study is, how long its items take, and what has been collected."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np
from sqlalchemy import and_, func, select
from sqlalchemy.orm import Session

from annotation_app.store.models import TASKS, Answer, Event, Item, Slot, Task
from g3.sdc.clauses import SDC_TYPES, breadth_first
from g3.sdc.sdc_notation import from_json


@dataclass(frozen=True, slots=True)
class Progress:
    """How many answers there are of those that are wanted. `video` is None for all videos."""

    task: Task
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

    task: Task
    answers: int
    lower_s: float
    median_s: float
    upper_s: float


@dataclass(frozen=True, slots=True)
class Collected:
    """What there is for a corpus."""

    commands: int
    words: int
    vocabulary: int
    annotators: int
    trees: int
    clauses: dict[str, int]
    groundings: int
    checks: int
    ratings: dict[int, int]
    surplus: int


def progress_by_video(session: Session, study_id: str, *, now: float) -> list[Progress]:
    """Progress of each task for each video, in the order of tasks."""
    video = Item.payload["video"].as_string()
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
    found = [Progress(*row) for row in rows]
    return sorted(found, key=lambda p: (TASKS.index(p.task), p.video or ""))


def progress_by_task(by_video: list[Progress]) -> list[Progress]:
    """Progress of each task over all videos."""
    totals: list[Progress] = []
    for task in TASKS:
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
        .where(Item.study_id == study_id)
    )
    seconds: dict[Task, list[float]] = {}
    for task, taken in rows:
        if taken is not None:
            seconds.setdefault(task, []).append(taken)
    return [
        Duration(task, len(seconds[task]), *map(float, np.percentile(seconds[task], (25, 50, 75))))
        for task in TASKS
        if task in seconds
    ]


def collected(session: Session, study_id: str) -> Collected:
    """What people have given so far."""
    rows = session.execute(
        select(
            Answer.task,
            Answer.body,
            Answer.adopted,
            and_(Answer.surplus, Event.name != "adjudicate"),
        )
        .join(Item, Item.id == Answer.item_id)
        .join(Event, Event.id == Answer.event_id)
        .where(Item.study_id == study_id, Item.attention.is_(False))
    ).all()
    texts = [body["text"].split() for task, body, _, _ in rows if task == "describe"]
    trees = [
        from_json(body["sdcs"]) for task, body, adopted, _ in rows if task == "segment" and adopted
    ]
    clauses = Counter(
        sdc.type for tree in trees for sdc in breadth_first(tree) if not sdc.is_implicit
    )
    ratings = Counter(body["rating"] for task, body, _, _ in rows if task == "rate")
    people = (
        select(func.count(Answer.person_id.distinct()))
        .join(Item, Item.id == Answer.item_id)
        .where(Item.study_id == study_id)
    )
    return Collected(
        commands=len(texts),
        words=sum(map(len, texts)),
        vocabulary=len({word.casefold().strip(".,;:!?") for text in texts for word in text}),
        annotators=session.scalar(people) or 0,
        trees=len(trees),
        clauses={name: clauses[name] for name in SDC_TYPES},
        groundings=sum(
            not grounding["cant_tell"]
            for task, body, adopted, _ in rows
            if task == "ground" and adopted
            for grounding in body["groundings"].values()
        ),
        checks=sum(len(body["verdicts"]) for task, body, _, _ in rows if task == "check"),
        ratings={value: ratings[value] for value in range(1, 6)},
        surplus=sum(is_late for _, _, _, is_late in rows),
    )
