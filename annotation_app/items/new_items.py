"""Making items: their subjects, and the number of answers that they want.

An item's subject names its origin. So all items made of an answer can be looked up when the
answer is replaced, or its author's data are erased:

- the payload of an item that shows a command has ``"command"``, the id of the command's answer;
- the subject of an item made of another answer is :func:`about_answer`.

The subject of an item about a video is :func:`about_video`. A study asks once about each of its
videos, which differ by their names: two may show the same file, as in a test and a retest.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import numpy as np
from sqlalchemy import Select, bindparam, func, select
from sqlalchemy.orm import Session

from annotation_app.core.random_ids import new_id
from annotation_app.store.models import Answer, Item, Media, Record, Slot, Study, TaskName, queue_of
from annotation_app.studies.study_file import StudyConfig
from g3.short_repr import short_repr

REPLACED = "replaced "
"""Prefix of the subjects of items that were made of an answer since replaced."""

ABOUT_VIDEO = "video "
"""Prefix of the subjects of items that are about a video."""

GIVEN = "given "
"""Prefix of the subjects of items that came with their only answer."""


@short_repr
@dataclass(frozen=True, slots=True)
class NewItem:
    """An item to be made, if there is none about its subject yet."""

    task: TaskName
    subject: str
    """Subject of the item: nobody answers a task about a subject twice."""
    payload: Record
    """Data that the server keeps of the item. All have ``"video"``, and those about a command
    ``"text"``."""
    author_id: str | None = None
    """Person who must not get the item."""
    attention: bool = False
    """True if the right answer is known, for an attention check."""
    drawn_with: str = ""
    """Seed of the item's place among the others; its subject if empty."""


_VIDEOS = select(Media.video).where(Media.study_id == bindparam("study"), Media.role == "manifest")
_DIGEST = select(Media.sha256).where(
    Media.study_id == bindparam("study"),
    Media.video == bindparam("of_video"),
    Media.role == "video",
    Media.sha256 != "",
)
_KNOWN = select(Item.id).where(
    Item.study_id == bindparam("study"),
    Item.task == bindparam("of_task"),
    Item.subject == bindparam("of_subject"),
)


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
        rank=draws(config, new.drawn_with or new.subject).random(),
        author_id=new.author_id,
        attention=new.attention,
    )
    item.slots = new_slots(item, 0 if new.attention else wanted_answers(config, item))
    session.add(item)
    return item


def wanted_answers(config: StudyConfig, item: Item) -> int:
    """Return how many people answer an item: one, if it isn't drawn to be answered by several."""
    task = config.tasks[item.task]
    is_shared = draws(config, f"overlap of {item.subject}").random() < task.overlap
    return task.answers if is_shared else 1


def new_slots(item: Item, count: int) -> list[Slot]:
    """Return slots for some more answers to an item, not yet added to its own."""
    queue = queue_of(item.study_id, item.task)
    return [Slot(item_id=item.id, queue=queue, rank=item.rank) for _ in range(count)]


def about_answer(answer: Answer) -> str:
    """Return the subject of items made of an answer that is no command."""
    return f"answer {answer.id}"


def about_video(video: str, sha256: str) -> str:
    """Return the subject of an item about a video: its file's first digest, and its name.

    Nobody is asked about it in two studies.
    """
    return f"{ABOUT_VIDEO}{sha256} {video}"


def videos_of(session: Session, study_id: str) -> list[str]:
    """Return the names of a study's videos."""
    return sorted(session.scalars(_VIDEOS, {"study": study_id}))


def other_video(
    session: Session,
    study_id: str,
    video: str,
    rng: np.random.Generator,
    without: Select[str] | None = None,
) -> str | None:
    """Draw a video of a study that doesn't show the same file as another; None if there is none.

    Parameters
    ----------
    without
        Selects names that aren't drawn either.
    """
    digest = session.scalar(_DIGEST, {"study": study_id, "of_video": video})
    others = _VIDEOS if without is None else _VIDEOS.where(Media.video.not_in(without))
    alike = {video}
    while True:
        left = others.where(Media.video.not_in(alike))
        count = session.scalar(left.with_only_columns(func.count(Media.video)), {"study": study_id})
        if not count:
            return None
        drawn = left.order_by(Media.video).limit(1).offset(int(rng.integers(count)))
        name = session.scalars(drawn, {"study": study_id}).one()
        of_drawn = {"study": study_id, "of_video": name}
        if digest is None or session.scalar(_DIGEST, of_drawn) != digest:
            return name
        alike.add(name)


def draws(config: StudyConfig, subject: str) -> np.random.Generator:
    """Return a random generator that is the same each time for a subject."""
    return np.random.default_rng([config.seed, zlib.crc32(subject.encode())])
