"""Parts of a copy of a LeRobot dataset, gathered task by task.

Videos name the episode that they show by what ``ct import lerobot`` has written of them:
``episode`` and, for subtasks of the dataset itself, ``style`` and ``timestamp``.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from sqlalchemy.orm import Session

from annotation_app.items.elapsed import iso
from annotation_app.items.new_items import GIVEN
from annotation_app.store.models import Answer, Record, Study, TaskName
from annotation_app.tasks.corpus_parts import answers_of
from corpus_tools.lerobot.episode_index import IndexColumn
from corpus_tools.lerobot.language_rows import TASK_AUG, Language
from g3.errors import FormatError
from g3.short_repr import short_repr


@dataclass(frozen=True, slots=True)
class KeepFrom:
    """The least that an episode must have to be kept."""

    success: str = "partly"
    quality: float = 1.0


LEAST = KeepFrom()


@short_repr
@dataclass(slots=True)
class EpisodeParts:
    """Parts that tasks add to, in the tasks' order."""

    session: Session
    study: Study
    videos: Mapping[str, Mapping[str, Any]]
    """The records of the study's table of those videos that show episodes, by their names."""
    people: Mapping[str, str]
    """Names of people in exports, by their ids."""
    language: dict[int, list[Language]] = field(default_factory=lambda: defaultdict(list))
    """Texts by the numbers of episodes."""
    replaced: dict[int, set[str]] = field(default_factory=lambda: defaultdict(set))
    """Styles of which the dataset's own rows go, by the numbers of episodes."""
    corrected: dict[int, dict[str, str]] = field(default_factory=lambda: defaultdict(dict))
    """New texts of tasks by the replaced ones, by the numbers of episodes."""
    columns: list[IndexColumn] = field(default_factory=list)
    """Columns of the episodes' index."""
    files: dict[str, list[Record]] = field(default_factory=lambda: defaultdict(list))
    """Further files of the copy: their lines by their names."""
    documents: dict[str, Any] = field(default_factory=dict)
    """Further files of the copy with one JSON value: the values by their names."""
    keep_from: KeepFrom = LEAST
    counts: dict[str, int] = field(default_factory=dict)
    """Number of each kind of what was added, by a word for it."""

    def shows_whole_episode(self, video: str) -> bool:
        """Check that a video shows an episode from its beginning to its end."""
        return video in self.videos and "style" not in self.videos[video]

    def episode(self, video: str) -> int:
        """Return the number of the episode that a video shows."""
        number = self.number(video, "episode")
        if number < 0 or number != int(number):
            raise self._bad(video, "episode")
        return int(number)

    def number(self, video: str, column: str) -> float:
        """Return a number that the study's table has of a video; 0 if it has none."""
        try:
            number = float(self.videos[video].get(column, 0.0))
        except (TypeError, ValueError):
            raise self._bad(video, column) from None
        if not abs(number) < float("inf"):
            raise self._bad(video, column)
        return number

    def source(self, answer: Answer, **more: Any) -> Record:
        """Return the person, the answer and its time, for the provenance."""
        return {
            "study": self.study.name,
            "answer": answer.id,
            "subject": self.people[answer.person_id],
            "at": iso(answer.at),
            **more,
        }

    def _bad(self, video: str, column: str) -> FormatError:
        return FormatError(
            f"{self.videos[video][column]!r:.60} is no {column} of a dataset",
            where=f"study {self.study.name}, video {video}, column {column}",
            fix="make the tables once more with `ct import lerobot`, and the study of these",
        )


def add_wordings(parts: EpisodeParts, task: TaskName) -> None:
    """Add the answers to a task as wordings of their episodes' tasks.

    Left out are the commands that a table gave, and the answers about parts of episodes.
    """
    added = 0
    for answer, item in answers_of(parts.session, parts.study, task):
        video = item.payload["video"]
        if parts.shows_whole_episode(video) and not item.subject.startswith(GIVEN):
            said = Language(TASK_AUG, 0.0, answer.body["text"], parts.source(answer))
            parts.language[parts.episode(video)].append(said)
            added += 1
    parts.counts["wordings"] = parts.counts.get("wordings", 0) + added
