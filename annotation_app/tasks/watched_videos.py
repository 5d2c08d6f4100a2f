"""What tasks share in which people watch one whole video: `describe` and `subtasks`."""

from __future__ import annotations

from collections.abc import Callable

from sqlalchemy.orm import Session

from annotation_app.core.languages import gettext
from annotation_app.core.problems import FieldProblem
from annotation_app.items.item_scenes import watched
from annotation_app.items.new_items import NewItem
from annotation_app.store.models import Item, Record, TaskName


def not_watched() -> FieldProblem:
    """The problem of an answer that was sent before the video's end."""
    return FieldProblem("played_to_end", gettext("Watch the video to its end first."))


def video_payload(session: Session, item: Item, _salt: bytes) -> Record:
    """The payload of an item that is about a video and nothing else."""
    return watched(session, item)


def item_of_video(task: TaskName) -> Callable[[str, str], NewItem]:
    """What makes a task's item of a video and its file's digest."""
    # A video is the same for a person in any study, if its file is.
    return lambda video, sha256: NewItem(task, f"video {sha256}", {"video": video})
