"""Finding answers and reports: filtered, a page at a time, newest first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias, get_args

from sqlalchemy import ColumnElement, Select, and_, case, exists, func, or_, select
from sqlalchemy.orm import Session

from annotation_app.core.problems import Refusal
from annotation_app.dashboard.adjudication_queue import disputed
from annotation_app.people.participants import subject_of
from annotation_app.people.person_names import anonymous_name, shown_name
from annotation_app.store.audit import name_of
from annotation_app.store.models import (
    Answer,
    Event,
    Item,
    Media,
    Person,
    Record,
    Remark,
    TaskName,
)
from annotation_app.tasks.task_record import COMMAND
from annotation_app.tasks.task_registry import task_names, tasks

State: TypeAlias = Literal["submitted", "adopted", "in dispute", "late", "excluded"]
STATES: tuple[State, ...] = get_args(State)
Order: TypeAlias = Literal["newest", "oldest", "person", "disagreement", "reports"]
ORDERS: tuple[Order, ...] = get_args(Order)
"""Orders of a list: by time, by person, disputed items first, items with most reports first."""
PAGE = 25
FURTHEST = 1_000_000
"""Largest number of answers before a page."""
_REPORTS = ("flag", "skip")


@dataclass(frozen=True, slots=True)
class Wanted:
    """A filter of answers; empty fields leave out nothing.

    `person` is a name on the dashboard, or the beginning of the hash in exports, `text` a part of
    the command, in small or capital letters. Where the newest come first, answers have
    a lower id than `before`; else it is the number of those before. If `flagged`, they are about
    items of which somebody has reported a problem.
    """

    task: str = ""
    person: str = ""
    video: str = ""
    state: str = ""
    flagged: bool = False
    text: str = ""
    order: str = "newest"
    before: int | None = None

    def parameters(self) -> dict[str, str]:
        """Return parameters of an address that shows the same answers from the first page."""
        found = {name: getattr(self, name) for name in ("task", "person", "video", "state", "text")}
        found["flagged"] = "1" if self.flagged else ""
        found["order"] = "" if self.order == ORDERS[0] else self.order
        return {name: text for name, text in found.items() if text}


@dataclass(frozen=True, slots=True)
class FoundAnswer:
    """An answer in a list."""

    answer: int
    task: TaskName
    item: str
    video: str
    command: str
    subject: str
    person: str
    """Name on the dashboard."""
    at: float
    seconds: float | None
    states: tuple[State, ...]
    reports: int
    body: Record


@dataclass(frozen=True, slots=True)
class Said:
    """A reviewer's action or remark."""

    by: str
    kind: str
    text: str
    at: float


@dataclass(frozen=True, slots=True)
class Report:
    """A problem that somebody reported, or why they skipped an item."""

    report: int
    kind: Literal["flag", "skip"]
    task: TaskName
    item: str
    video: str
    command: str
    subject: str
    person: str
    reason: str
    at: float


def read_wanted(asked: Mapping[str, str]) -> Wanted:
    """Read the filter from an address's parameters; refused if the task or state is unknown."""
    task, state = asked.get("task", ""), asked.get("state", "")
    if task and task not in task_names():
        raise Refusal(404, "There is no such task.")
    if state and state not in STATES:
        raise Refusal(404, f"There is no such state. Use one of: {', '.join(STATES)}.")
    order = asked.get("order", "") or ORDERS[0]
    if order not in ORDERS:
        raise Refusal(404, f"There is no such order. Use one of: {', '.join(ORDERS)}.")
    words = {
        n: asked.get(n, "").replace("\0", "").strip()[:200] for n in ("person", "video", "text")
    }
    flagged = asked.get("flagged", "") in ("1", "true", "yes")
    before = read_before(asked)
    return Wanted(task=task, state=state, flagged=flagged, order=order, before=before, **words)


def read_before(asked: Mapping[str, str]) -> int | None:
    """Read the id that a page begins after, if an address names one."""
    before = asked.get("before", "")
    return int(before[:15]) if before.isascii() and before.isdigit() else None


def find_answers(
    session: Session, study_id: str, wanted: Wanted
) -> tuple[list[FoundAnswer], int | None]:
    """Return answers of a study, and the next page's id, if there are more.

    Only ids are sorted; what people sent is read for one page.
    """
    is_newest = wanted.order == ORDERS[0]
    ids = session.scalars(
        _ids(session, study_id, wanted)
        .offset(0 if is_newest else min(wanted.before or 0, FURTHEST))
        .limit(PAGE + 1)
    ).all()
    found = {one.answer: one for one in shown(session, study_id, ids[:PAGE])}
    after = ids[PAGE - 1] if is_newest and len(ids) > PAGE else (wanted.before or 0) + PAGE
    return [found[one] for one in ids[:PAGE]], after if len(ids) > PAGE else None


def ids_of_all(session: Session, study_id: str, wanted: Wanted, most: int) -> Sequence[int]:
    """Return the ids of the answers that a filter lets through, regardless of pages."""
    everything = replace(wanted, before=None)
    return session.scalars(_ids(session, study_id, everything).limit(most)).all()


def count_answers(session: Session, study_id: str, wanted: Wanted) -> int:
    """Count the answers that a filter lets through."""
    everything = replace(wanted, before=None, order=ORDERS[0])
    ids = _ids(session, study_id, everything).order_by(None).subquery()
    return session.scalar(select(func.count()).select_from(ids)) or 0


def _ids(session: Session, study_id: str, wanted: Wanted) -> Select[int]:
    """Select the ids of the answers that a filter lets through, in its order."""
    # By the study's index all of its answers would be sorted: newest first, a page ends early.
    study = Item.study_id if wanted.video else Item.study_id + ""
    found = (
        select(Answer.id)
        .join(Item, Item.id == Answer.item_id)
        .where(study == study_id, *_conditions(session, study_id, wanted))
    )
    if wanted.order == "oldest":
        return found.order_by(Answer.id)
    if wanted.order == "person":
        people = found.join(Person, Person.id == Answer.person_id)
        return people.order_by(Person.login, Person.external_hash, Answer.id)
    if wanted.order == "disagreement":
        is_open = case((Item.id.in_(disputed(study_id)), 0), else_=1)
        return found.order_by(is_open, Item.command, Item.id, Answer.id)
    if wanted.order == "reports":
        flags = select(func.count()).where(Event.item_id == Item.id, Event.name == "flag")
        return found.order_by(flags.scalar_subquery().desc(), Item.id, Answer.id)
    return found.order_by(Answer.id.desc())


def shown(session: Session, study_id: str, ids: Sequence[int]) -> list[FoundAnswer]:
    """Return answers of a study by their ids, newest first."""
    rows = session.execute(
        select(Answer, Item, Person, Event.name)
        .join(Event, Event.id == Answer.event_id)
        .join(Item, Item.id == Answer.item_id)
        .join(Person, Person.id == Answer.person_id)
        .where(Answer.id.in_(ids), Item.study_id == study_id)
        .order_by(Answer.id.desc())
    ).all()
    items = [item.id for _, item, _, _ in rows]
    open_ = set(session.scalars(disputed(study_id, items)))
    reports = list(
        session.scalars(select(Event.item_id).where(Event.item_id.in_(items), Event.name == "flag"))
    )
    return [
        FoundAnswer(
            answer=answer.id,
            task=item.task,
            item=item.id,
            video=item.video,
            command=item.command or str(answer.body.get("text", "")),
            subject=subject_of(person),
            person=shown_name(person),
            at=answer.at,
            seconds=answer.seconds,
            states=_states(answer, event, item.id in open_),
            reports=reports.count(item.id),
            body=answer.body,
        )
        for answer, item, person, event in rows
    ]


def adopted_now(session: Session, item: Item) -> int | None:
    """Return the id of an item's adopted answer."""
    wanted = select(Answer.id).where(Answer.item_id == item.id, Answer.adopted.is_(True))
    return session.scalar(wanted.limit(1))


def remarks(session: Session, answer_id: int) -> list[Said]:
    """Return the actions on an answer and the remarks about it, oldest first."""
    rows = session.execute(
        select(Remark, Person)
        .join(Person, Person.id == Remark.person_id)
        .where(Remark.answer_id == answer_id)
        .order_by(Remark.id)
    )
    return [Said(name_of(person), one.kind, one.text, one.at) for one, person in rows]


def find_reports(
    session: Session,
    study_id: str,
    *,
    item: str = "",
    before: int | None = None,
    most: int | None = PAGE,
) -> tuple[list[Report], int | None]:
    """Return reported problems and skipped items, newest first, and the next page's id."""
    query = (
        select(Event, Item, Person)
        .join(Item, Item.id == Event.item_id)
        .join(Person, Person.id == Event.person_id)
        .where(Item.study_id == study_id, Event.name.in_(_REPORTS))
        .order_by(Event.id.desc())
    )
    if item:
        query = query.where(Event.item_id == item)
    if before is not None:
        query = query.where(Event.id < before)
    rows = session.execute(query if most is None else query.limit(most + 1)).all()
    found = [
        Report(
            report=event.id,
            kind="flag" if event.name == "flag" else "skip",
            task=found_item.task,
            item=found_item.id,
            video=found_item.video,
            command=found_item.command,
            subject=subject_of(person),
            person=shown_name(person),
            reason=str(event.body.get("reason", "")),
            at=event.at,
        )
        for event, found_item, person in rows[:most]
    ]
    return found, found[-1].report if most is not None and len(rows) > most else None


def open_reports(session: Session, study_id: str) -> int:
    """Count the reported problems, without those of items that were only skipped."""
    # Events are read once, in their order: to look them up item by item takes five times as long.
    here = exists().where(Item.id == Event.item_id, Item.study_id == study_id)
    return session.scalars(select(func.count()).where(Event.name == "flag", here)).one()


def posters(session: Session, study_id: str, videos: Sequence[str]) -> dict[str, dict[str, str]]:
    """Return the public names of videos' files that people may see, by video and role."""
    rows = session.execute(
        select(Media.video, Media.role, Media.id).where(
            Media.study_id == study_id,
            Media.video.in_(set(videos)),
            Media.role.in_(("video", "poster")),
        )
    )
    found: dict[str, dict[str, str]] = {}
    for video, role, name in rows:
        found.setdefault(video, {})[role] = name
    return found


def people(session: Session, study_id: str) -> list[tuple[str, str]]:
    """Return the hash in exports of each person who has answered, and the name, in its order."""
    found = [(subject_of(person), shown_name(person)) for person in _answering(session, study_id)]
    return sorted(found, key=lambda pair: pair[1].casefold())


def _answering(session: Session, study_id: str) -> Sequence[Person]:
    answering = select(Answer.person_id).where(Answer.study_id == study_id).distinct()
    return session.scalars(select(Person).where(Person.id.in_(answering))).all()


def _ids_of(session: Session, study_id: str, wanted: str) -> list[str]:
    """Return the ids of the people whom a name on the dashboard, or one in exports, means."""
    return [
        person.id
        for person in _answering(session, study_id)
        if person.external_hash.startswith(wanted)
        or wanted.casefold() in (shown_name(person).casefold(), anonymous_name(person).casefold())
    ]


def videos(session: Session, study_id: str) -> Sequence[str]:
    """Return the names of the videos that items are about."""
    return session.scalars(
        select(Item.video).where(Item.study_id == study_id).distinct().order_by(Item.video)
    ).all()


def _conditions(session: Session, study_id: str, wanted: Wanted) -> list[ColumnElement[bool]]:
    found: list[ColumnElement[bool]] = []
    if wanted.task:
        found.append(Answer.task == wanted.task)
    if wanted.person:
        found.append(Answer.person_id.in_(_ids_of(session, study_id, wanted.person)))
    if wanted.video:
        found.append(Item.video == wanted.video)
    if wanted.flagged:
        found.append(exists().where(Event.item_id == Item.id, Event.name == "flag"))
    if wanted.text:
        # Only the answers that are commands are read for it: they are short.
        typed = [task.name for task in tasks() if task.gives == COMMAND]
        own = Answer.body["text"].as_string().icontains(wanted.text, autoescape=True)
        here = Item.command.icontains(wanted.text, autoescape=True)
        found.append(or_(here, and_(Answer.task.in_(typed), own)))
    if wanted.before is not None and wanted.order == ORDERS[0]:
        found.append(Answer.id < wanted.before)
    if wanted.state:
        found += _in_state(study_id, wanted.state)
    return found


def _in_state(study_id: str, state: str) -> list[ColumnElement[bool]]:
    if state == "excluded":
        return [Answer.excluded.is_(True)]
    counts = Answer.excluded.is_(False)
    if state == "adopted":
        return [counts, Answer.adopted.is_(True)]
    if state == "late":
        came = exists().where(Event.id == Answer.event_id, Event.name != "adjudicate")
        return [counts, Answer.surplus.is_(True), came]
    if state == "in dispute":
        return [counts, Answer.item_id.in_(disputed(study_id))]
    return [counts]


def _states(answer: Answer, event: str, is_open: bool) -> tuple[State, ...]:
    if answer.excluded:
        return ("excluded",)
    found: dict[State, bool] = {
        "adopted": answer.adopted,
        "late": answer.surplus and event != "adjudicate",
        "in dispute": is_open,
    }
    return ("submitted", *(state for state, holds in found.items() if holds))
