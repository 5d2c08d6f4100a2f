"""Shared functions of the tasks in which people watch videos."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, TypeAlias

import msgspec
from sqlalchemy.orm import Session

from annotation_app.items.item_scenes import watched
from annotation_app.items.new_items import NewItem, about_video
from annotation_app.store.models import Item, Record, TaskName

Seconds: TypeAlias = Annotated[float, msgspec.Meta(ge=0, le=1e6)]
Speed: TypeAlias = Annotated[float, msgspec.Meta(gt=0, le=4)]
"""Playing speed of a video: the player offers up to 4 times."""


def with_watching(body: Record, answer: Any) -> Record:
    """Return an answer in its kept form with the page's reports of watching.

    That is ``watched_s``, seconds of videos that were played, at any speed, and ``speed``, the
    fastest that they were played at.
    """
    told = {"watched_s": answer.watched_s, "speed": answer.speed}
    return body | {name: value for name, value in told.items() if value is not None}


def its_video(payload: Record) -> tuple[str]:
    """Return the video of an item whose question is about it (`Task.watches`)."""
    return (payload["video"],)


def video_payload(session: Session, item: Item, _salt: bytes) -> Record:
    """Return the payload of an item that is about a video and nothing else."""
    return watched(session, item)


def opened_with(data: Record, answer: Record) -> Record:
    """Return a page's data that begins with an answer.

    Adjudicators have seen the video on the page before, and needn't watch it again.
    """
    return {**data, "start": {**answer, "played_to_end": True, "watched_s": 0}}


def item_of_video(task: TaskName) -> Callable[[str, str], NewItem]:
    """Return a function that makes a task's item of a video and its file's digest."""
    return lambda video, sha256: NewItem(task, about_video(video, sha256), {"video": video})
