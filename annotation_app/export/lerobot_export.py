"""What people have said of a LeRobot dataset's episodes, for a copy of it.

Videos tell which episode they show by what ``ct import lerobot`` has written of them: ``episode``
and, for subtasks of the dataset itself, ``style`` and ``timestamp``.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
from scipy.stats import binomtest
from sqlalchemy.orm import Session

from annotation_app.items.item_scenes import films_of
from annotation_app.store.models import Study
from annotation_app.tasks.corpus_parts import answers_of, people_of
from annotation_app.tasks.rate import RATE
from annotation_app.tasks.subtasks import SUBTASKS, boundary_f, most_agreed
from annotation_app.tasks.task_record import COMMAND
from annotation_app.tasks.task_registry import tasks
from corpus_tools.lerobot.language_rows import PLAN, SUBTASK, TASK_AUG, Language, plans
from corpus_tools.lerobot.language_writing import EpisodeLanguage
from g3.errors import FormatError

PROVENANCE, VERDICTS = "meta/people.jsonl", "meta/verdicts.jsonl"
"""Files of the copy: who said what, and what people think of the dataset's own language."""
AGREES = 4
"""From which rating on somebody agrees."""

Record = dict[str, Any]


@dataclass(frozen=True, slots=True)
class PeoplesLanguage:
    """What people have said.

    Parameters
    ----------
    dataset
        The dataset's folder, as the study's table names it.
    language
        By the numbers of episodes.
    files
        The provenance and the verdicts, by their names in the copy.
    counts
        How many of each there are.
    """

    dataset: Path
    language: Mapping[int, EpisodeLanguage]
    files: Mapping[str, bytes]
    counts: Mapping[str, int]


def peoples_language(session: Session, study: Study) -> PeoplesLanguage:
    """What people have said in a study of a dataset's episodes.

    Descriptions become other wordings of the task (``task_aug``), and the task of an episode that
    had none. Subtasks take the place of the dataset's own and of its plans. Ratings are verdicts.

    Raises
    ------
    FormatError
        If the study's videos are no episodes.
    """
    films = films_of(session, study.id)
    told = {video: film.metadata for video, film in films.items()}
    datasets = {str(row["dataset"]) for row in told.values() if "dataset" in row}
    if len(datasets) != 1:
        raise FormatError(
            "the videos are no episodes of a LeRobot dataset"
            if not datasets
            else f"the videos are of several datasets: {', '.join(sorted(datasets))}",
            where=f"study {study.name}",
            fix="make the study of what `ct import lerobot` writes",
        )
    episodes = {video: int(row["episode"]) for video, row in told.items() if "episode" in row}
    said: dict[int, list[Language]] = defaultdict(list)
    provenance: list[Record] = []
    _add_wordings(session, study, episodes, told, said, provenance)
    _add_subtasks(session, study, episodes, said, provenance)
    verdicts = _verdicts(session, study, episodes, told)
    language = {index: _of_episode(rows) for index, rows in sorted(said.items())}
    counts = {
        "episodes": len(language),
        "wordings": sum(row["style"] == TASK_AUG for row in provenance),
        "subtasks": sum(row["style"] == SUBTASK for row in provenance),
        "verdicts": len(verdicts),
    }
    lines = msgspec.json.Encoder().encode_lines
    files = {PROVENANCE: lines(provenance)} if provenance else {}
    if verdicts:
        files[VERDICTS] = lines(verdicts)
    return PeoplesLanguage(Path(datasets.pop()), language, files, counts)


def _of_episode(rows: list[Language]) -> EpisodeLanguage:
    subtasks = [row for row in rows if row.style == SUBTASK]
    wordings = [row.text for row in rows if row.style == TASK_AUG]
    replaces = frozenset({SUBTASK, PLAN}) if subtasks else frozenset()
    return EpisodeLanguage((*rows, *plans(subtasks)), replaces, wordings[0] if wordings else "")


def _add_wordings(
    session: Session,
    study: Study,
    episodes: Mapping[str, int],
    told: Mapping[str, Mapping[str, Any]],
    said: dict[int, list[Language]],
    provenance: list[Record],
) -> None:
    people = people_of(session)
    for task in (task for task in tasks() if task.gives == COMMAND):
        for answer, item in answers_of(session, study, task.name):
            video = item.payload["video"]
            # Commands that came with the study's tables are the dataset's own.
            is_given = "metadata" in answer.body
            if video not in episodes or is_given or "style" in told[video]:
                continue
            text = answer.body["text"]
            said[episodes[video]].append(Language(TASK_AUG, 0.0, text))
            provenance.append(
                _provenance(study, episodes[video], TASK_AUG, 0.0, text, answer, people)
            )


def _add_subtasks(
    session: Session,
    study: Study,
    episodes: Mapping[str, int],
    said: dict[int, list[Language]],
    provenance: list[Record],
) -> None:
    people, by_episode = people_of(session), defaultdict(list)
    for answer, item in answers_of(session, study, SUBTASKS.name):
        if item.payload["video"] in episodes:
            by_episode[episodes[item.payload["video"]]].append(answer)
    for index, answers in by_episode.items():
        bodies = [answer.body for answer in answers]
        chosen = answers[most_agreed(bodies)]
        others = [body for body in bodies if body is not chosen.body]
        scores = [boundary_f(chosen.body, body) for body in others]
        agreement = {
            "answers": len(answers),
            "agreement": sum(scores) / len(scores) if scores else None,
        }
        for step in chosen.body["subtasks"]:
            start_s, text = float(step["start_s"]), step["text"]
            said[index].append(Language(SUBTASK, start_s, text))
            row = _provenance(study, index, SUBTASK, start_s, text, chosen, people)
            provenance.append(row | agreement)


def _verdicts(
    session: Session,
    study: Study,
    episodes: Mapping[str, int],
    told: Mapping[str, Mapping[str, Any]],
) -> list[Record]:
    """What people think of what was said of an episode, or of a part of it, shown with its video."""
    ratings: dict[tuple[str, str], list[int]] = defaultdict(list)
    for answer, item in answers_of(session, study, RATE.name):
        payload = item.payload
        if payload["video"] in episodes and payload["video"] == payload["own_video"]:
            ratings[payload["video"], payload["text"]].append(answer.body["rating"])
    found = []
    for (video, text), given in sorted(ratings.items(), key=lambda entry: episodes[entry[0][0]]):
        agree = sum(rating >= AGREES for rating in given)
        interval = binomtest(agree, len(given)).proportion_ci(method="wilson")
        found.append(
            {
                "episode_index": episodes[video],
                "style": told[video].get("style", "task"),
                "timestamp": float(told[video].get("timestamp", 0.0)),
                "content": text,
                "ratings": given,
                "agree": agree / len(given),
                "agree_95": [float(interval.low), float(interval.high)],
                "study": study.name,
            }
        )
    return found


def _provenance(
    study: Study,
    index: int,
    style: str,
    start_s: float,
    text: str,
    answer: Any,
    people: Mapping[str, str],
) -> Record:
    return {
        "episode_index": index,
        "style": style,
        "start_s": start_s,
        "content": text,
        "study": study.name,
        "answer": answer.id,
        "subject": people[answer.person_id],
        "at": answer.at,
    }
