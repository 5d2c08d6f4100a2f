"""From the answers of one task to the items of the next: describe, segment, ground, check, rate.

A description is adopted at once. A segmentation or a grounding is adopted when it is the only
one that is asked for, or all that were asked for agree; else an adjudicator adopts one.
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from sqlalchemy import bindparam, delete, func, select
from sqlalchemy.orm import Session

from annotation_app.core.random_ids import new_id
from annotation_app.store.models import Answer, Item, Media, Person, Record, Slot, Study, Task
from annotation_app.studies.study_file import StudyConfig, restored
from annotation_app.tasks.payloads import scene_of
from annotation_app.tasks.submissions import AGREED, add_event
from g3.sdc.clauses import breadth_first
from g3.sdc.sdc_notation import from_json

REPLACED = "replaced "
"""How the subjects of items begin that were made of an answer that has been replaced."""


@dataclass(frozen=True, slots=True)
class NewItem:
    """An item to be made, if there is none about its subject yet."""

    task: Task
    subject: str
    payload: Record
    author_id: str | None = None
    attention: bool = False


_VIDEOS = select(Media.video).where(Media.study_id == bindparam("study"), Media.role == "manifest")
_KNOWN = select(Item.id).where(
    Item.study_id == bindparam("study"),
    Item.task == bindparam("of_task"),
    Item.subject == bindparam("of_subject"),
)

_ANSWERED = (
    select(Answer, Item, Study)
    .join(Item, Item.id == Answer.item_id)
    .join(Study, Study.id == Item.study_id)
    .where(Answer.id == bindparam("answer"))
    # One at a time, or of two who agree at the same moment neither sees the other's answer.
    .with_for_update(key_share=True, of=Item)
)


def answered(session: Session, task: Task, answer_id: int) -> None:
    """Go on with an answer that was accepted; adopt it, if that is to be decided here and clear."""
    if task not in _NEXT:
        return
    answer, item, study = session.execute(_ANSWERED, {"answer": answer_id}).one()
    if item.task in AGREED:
        others = session.scalars(
            select(Answer).where(Answer.item_id == item.id, Answer.surplus.is_(False))
        ).all()
        is_full = not session.scalar(
            select(func.count()).where(Slot.item_id == item.id, Slot.answered.is_(False))
        )
        if not is_full or any(_essence(a.body) != _essence(answer.body) for a in others):
            return
        adopt(session, study, item, answer)
    else:
        _go_on(session, study, item, answer)


def adopt(session: Session, study: Study, item: Item, answer: Answer) -> None:
    """Take an answer as the right one, in place of any other, and make the next items of it.

    Nobody gets the items that were made of the one that it replaces any more.
    """
    if answer.adopted:
        return
    if item.task in AGREED:
        replaced = session.scalars(
            select(Answer).where(
                Answer.item_id == item.id, Answer.adopted.is_(True), Answer.id != answer.id
            )
        ).all()
        for other in replaced:
            other.adopted = False
        _withdraw(session, study, [*replaced, answer])
    answer.adopted = True
    session.flush()
    _go_on(session, study, item, answer)


def adjudicate(
    session: Session,
    study: Study,
    item: Item,
    person: Person,
    *,
    uuid: str,
    sent: Record,
    body: Record,
    now: float,
) -> Answer:
    """Keep what an adjudicator answers to an item, and adopt it.

    They may think better of it: then they have another answer to the item in its place.
    """
    event = add_event(session, item, person.id, name="adjudicate", uuid=uuid, body=sent, now=now)
    answer = session.scalars(
        select(Answer).where(
            Answer.person_id == person.id,
            Answer.task == item.task,
            Answer.subject == item.subject,
        )
    ).first()
    if answer is None:
        answer = Answer(
            item_id=item.id,
            person_id=person.id,
            task=item.task,
            subject=item.subject,
            surplus=True,
            seconds=None,
        )
        session.add(answer)
    answer.event_id, answer.body, answer.at = event, body, now
    answer.adopted = False
    session.flush()
    adopt(session, study, item, answer)
    return answer


def add_item(session: Session, study: Study, config: StudyConfig, new: NewItem) -> Item | None:
    """Add an item with its slots; None if there is one about its subject."""
    about = {"study": study.id, "of_task": new.task, "of_subject": new.subject}
    if session.scalar(_KNOWN, about) is not None:
        return None
    item = Item(
        id=new_id(),
        study_id=study.id,
        task=new.task,
        subject=new.subject,
        payload=new.payload,
        rank=_draws(config, new.subject).random(),
        author_id=new.author_id,
        attention=new.attention,
    )
    slots = 0 if new.attention else config.tasks[new.task].answers
    item.slots = [Slot(answered=False) for _ in range(slots)]
    session.add(item)
    return item


def videos_of(session: Session, study_id: str) -> list[str]:
    """The names of a study's videos."""
    return sorted(session.scalars(_VIDEOS, {"study": study_id}))


def _go_on(session: Session, study: Study, item: Item, answer: Answer) -> None:
    """Make the next items of an answer that is adopted."""
    if item.task not in _NEXT:
        return
    config = restored(study.config)
    for new in _NEXT[item.task](session, study, config, item, answer):
        if new.task in config.tasks:
            add_item(session, study, config, new)


def _withdraw(session: Session, study: Study, answers: Sequence[Answer]) -> None:
    """Let nobody get what was made of answers any more, and make their subjects free."""
    for answer in answers:
        items = select(Item).where(
            Item.study_id == study.id,
            Item.subject == f"answer {answer.id}",
            Item.task.in_(("ground", "check")),
        )
        for item in session.scalars(items).all():
            session.execute(delete(Slot).where(Slot.item_id == item.id, Slot.answered.is_(False)))
            item.subject = f"{REPLACED}{item.id}"
    session.flush()


def _essence(body: Record) -> Any:
    """What two answers must share to agree."""
    if "groundings" not in body:
        return body
    return body["trims"], {
        node: (sorted(grounding["objects"]), grounding["places"], grounding["cant_tell"])
        for node, grounding in body["groundings"].items()
    }


def _draws(config: StudyConfig, subject: str) -> np.random.Generator:
    return np.random.default_rng([config.seed, zlib.crc32(subject.encode())])


def _described(
    session: Session, study: Study, config: StudyConfig, item: Item, answer: Answer
) -> list[NewItem]:
    own, text = item.payload["video"], answer.body["text"]
    about = {"text": text, "command": answer.id}
    subject = f"command {answer.id}"
    others = [video for video in videos_of(session, study.id) if video != own]
    shown = [own]
    if others:
        shown.append(others[int(_draws(config, subject).integers(len(others)))])
    return [
        NewItem("segment", subject, {**about, "video": own}),
        *(
            NewItem(
                "rate",
                f"{subject} video {video}",
                {**about, "video": video, "own_video": own, "right": None},
                author_id=answer.person_id,
            )
            for video in shown
        ),
    ]


def _segmented(
    _session: Session, _study: Study, _config: StudyConfig, item: Item, answer: Answer
) -> list[NewItem]:
    about = {key: item.payload[key] for key in ("text", "command", "video")}
    return [
        NewItem(
            "ground",
            f"answer {answer.id}",
            {**about, "sdcs": answer.body["sdcs"]},
        )
    ]


def _grounded(
    session: Session, study: Study, config: StudyConfig, item: Item, answer: Answer
) -> list[NewItem]:
    subject = f"answer {answer.id}"
    shown = _random_groundings(session, study, item, answer.body, _draws(config, subject))
    if not shown:
        return []
    about = {key: item.payload[key] for key in ("text", "command", "video", "sdcs")}
    return [NewItem("check", subject, {**about, "grounding": answer.id, "shown": shown})]


def _random_groundings(
    session: Session, study: Study, item: Item, body: Record, draws: np.random.Generator
) -> Mapping[str, Record]:
    """As many random groundings for each clause as it has right ones (section 4.1).

    They come from all videos; what happens comes from another video than the command's.
    """
    own = item.payload["video"]
    videos = videos_of(session, study.id)
    others = [video for video in videos if video != own]
    shown: dict[str, Record] = {}
    for node, sdc in enumerate(breadth_first(from_json(item.payload["sdcs"]))):
        if sdc.type in ("EVENT", "PATH"):
            if others:
                video = others[int(draws.integers(len(others)))]
                shown[str(node)] = {"video": video, "objects": [], "places": []}
            continue
        right = body["groundings"].get(str(node))
        count = len(right["objects"]) + len(right["places"]) if right is not None else 0
        if right is None or not count:
            continue
        video = videos[int(draws.integers(len(videos)))]
        context = scene_of(session, study.id, video).context
        kind = "objects" if right["objects"] or not context.places else "places"
        pool: list[Any] = (
            [o.id for o in context.objects] if kind == "objects" else [*range(len(context.places))]
        )
        if video == own:
            known = [place.get("place") for place in right["places"]]
            pool = [thing for thing in pool if thing not in (*right["objects"], *known)]
        picks = draws.choice(len(pool), size=min(count, len(pool)), replace=False)
        drawn: Record = {"video": video, "objects": [], "places": []}
        drawn[kind] = [pool[int(i)] for i in sorted(picks)]
        if drawn[kind]:
            shown[str(node)] = drawn
    return shown


_NEXT = {"describe": _described, "segment": _segmented, "ground": _grounded}
