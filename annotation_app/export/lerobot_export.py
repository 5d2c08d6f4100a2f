"""People's language about a LeRobot dataset's episodes, for a copy of it.

Videos name the episode that they show by what ``ct import lerobot`` has written of them:
``episode`` and, for subtasks of the dataset itself, ``style`` and ``timestamp``.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import msgspec
from scipy.stats import binomtest
from sqlalchemy.orm import Session

from annotation_app.export.answer_tables import iso
from annotation_app.items.item_scenes import films_of
from annotation_app.items.new_items import GIVEN
from annotation_app.items.replaced_videos import replaced
from annotation_app.store.models import Answer, Study
from annotation_app.study_setup.every_problem import together
from annotation_app.tasks.corpus_parts import answers_of, people_of
from annotation_app.tasks.rate import RATE
from annotation_app.tasks.subtasks import SUBTASKS, boundary_f, most_agreed, steps_of
from annotation_app.tasks.task_record import COMMAND
from annotation_app.tasks.task_registry import tasks
from corpus_tools.lerobot.language_rows import PLAN, SUBTASK, TASK_AUG, Language
from corpus_tools.lerobot.language_writing import EpisodeLanguage
from g3.errors import FormatError

VERDICTS = "meta/verdicts.jsonl"
"""The file of the copy with people's ratings of the dataset's own language."""
AGREES = 4
"""Least rating that counts as agreement."""

Record = dict[str, Any]


@dataclass(frozen=True, slots=True)
class PeoplesLanguage:
    """Language of people, for a copy of a dataset."""

    dataset: Path
    """The dataset's folder, as the study's table names it."""
    language: Mapping[int, EpisodeLanguage]
    """Language by the numbers of episodes."""
    files: Mapping[str, bytes]
    """The verdicts, by their name in the copy."""
    counts: Mapping[str, int]
    """Number of each kind of language."""


def peoples_language(session: Session, study: Study) -> PeoplesLanguage:
    """Return the language that people gave in a study of a dataset's episodes.

    Descriptions become other wordings of the task (``task_aug``), and the task of an episode that
    had none. Subtasks take the place of the dataset's own and of its plans. Ratings are verdicts.

    A FormatError reports that the study's videos are no episodes. A CorpusError lists the files
    that were replaced since they were shown to people.
    """
    films = films_of(session, study.id)
    told = {video: film.metadata for video, film in films.items() if "episode" in film.metadata}
    datasets = {str(row["dataset"]) for row in told.values() if "dataset" in row}
    if len(datasets) != 1:
        several = f"the videos are of several datasets: {', '.join(sorted(datasets))}"
        raise FormatError(
            several if datasets else "the videos are no episodes of a LeRobot dataset",
            where=f"study {study.name}",
            fix="make the study of what `ct import lerobot` writes",
        )
    if wrong := list(replaced(session, study.id, with_gone=False)):
        raise together(wrong)
    found = _Gathered(session, study, told, people_of(session))
    found.add_wordings()
    found.add_subtasks()
    verdicts = list(found.verdicts())
    files = {VERDICTS: msgspec.json.Encoder().encode_lines(verdicts)} if verdicts else {}
    styles = Counter(row.style for rows in found.said.values() for row in rows)
    counts = {
        "episodes": len(found.said),
        "wordings": styles[TASK_AUG],
        "steps": styles[SUBTASK],
        "verdicts": len(verdicts),
    }
    language = {index: _of_episode(rows) for index, rows in sorted(found.said.items())}
    return PeoplesLanguage(Path(datasets.pop()), language, files, counts)


def _of_episode(rows: Sequence[Language]) -> EpisodeLanguage:
    subtasks = [row for row in rows if row.style == SUBTASK]
    wordings = [row.text for row in rows if row.style == TASK_AUG]
    replaces = frozenset({SUBTASK, PLAN}) if subtasks else frozenset()
    return EpisodeLanguage(tuple(rows), replaces, wordings[0] if wordings else "")


@dataclass(slots=True)
class _Gathered:
    """Language by episode, with its authors."""

    session: Session
    study: Study
    told: Mapping[str, Mapping[str, Any]]
    """Records of the study's table, by the videos' names."""
    people: Mapping[str, str]
    """Names of people in exports, by their ids."""
    said: dict[int, list[Language]] = field(default_factory=lambda: defaultdict(list))

    def add_wordings(self) -> None:
        """Add the wordings typed for whole episodes; not the commands that a table gave."""
        for task in (task for task in tasks() if task.gives == COMMAND):
            for answer, item in answers_of(self.session, self.study, task.name):
                about = self.told.get(item.payload["video"], {"style": ""})
                if "style" not in about and not item.subject.startswith(GIVEN):
                    source = self._source(answer)
                    said = Language(TASK_AUG, 0.0, answer.body["text"], source)
                    self.said[self._episode(item.payload["video"])].append(said)

    def add_subtasks(self) -> None:
        """Add the subtasks of each episode: of several answers, that which agrees best."""
        by_episode = defaultdict(list)
        for answer, item in answers_of(self.session, self.study, SUBTASKS.name):
            if item.payload["video"] in self.told:
                by_episode[self._episode(item.payload["video"])].append(answer)
        for index, answers in by_episode.items():
            chosen = answers[most_agreed([answer.body for answer in answers])]
            scores = [boundary_f(chosen.body, a.body) for a in answers if a is not chosen]
            agreement = sum(scores) / len(scores) if scores else None
            source = self._source(chosen, answers=len(answers), agreement=agreement)
            steps = steps_of(chosen.body)
            self.said[index] += [Language(SUBTASK, time, text, source) for time, text in steps]

    def verdicts(self) -> Iterator[Record]:
        """Return people's ratings of the language of a video, shown with that video."""
        ratings: dict[tuple[str, str], list[int]] = defaultdict(list)
        for answer, item in answers_of(self.session, self.study, RATE.name):
            about = item.payload
            if about["video"] in self.told and about["video"] == about["own_video"]:
                ratings[about["video"], about["text"]].append(answer.body["rating"])
        for (video, text), given in sorted(ratings.items()):
            agree = sum(rating >= AGREES for rating in given)
            interval = binomtest(agree, len(given)).proportion_ci(method="wilson")
            yield {
                "episode_index": self._episode(video),
                "style": self.told[video].get("style", "task"),
                "timestamp": self._number(video, "timestamp"),
                "content": text,
                "ratings": given,
                "agree": agree / len(given),
                "agree_95": [float(interval.low), float(interval.high)],
                "study": self.study.name,
            }

    def _episode(self, video: str) -> int:
        number = self._number(video, "episode")
        if number < 0 or number != int(number):
            raise self._bad(video, "episode")
        return int(number)

    def _number(self, video: str, column: str) -> float:
        """Return a number that the study's table has of a video; 0 if it has none."""
        try:
            number = float(self.told[video].get(column, 0.0))
        except (TypeError, ValueError):
            raise self._bad(video, column) from None
        if not abs(number) < float("inf"):
            raise self._bad(video, column)
        return number

    def _bad(self, video: str, column: str) -> FormatError:
        return FormatError(
            f"{self.told[video][column]!r:.60} is no {column} of a dataset",
            where=f"study {self.study.name}, video {video}, column {column}",
            fix="make the tables once more with `ct import lerobot`, and the study of these",
        )

    def _source(self, answer: Answer, **more: Any) -> Record:
        """Return the person, the answer and its time, for the provenance."""
        return {
            "study": self.study.name,
            "answer": answer.id,
            "subject": self.people[answer.person_id],
            "at": iso(answer.at),
            **more,
        }
