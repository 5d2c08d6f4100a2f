"""People's language about a LeRobot dataset's episodes, for a copy of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
from sqlalchemy.orm import Session

from annotation_app.items.item_scenes import films_of
from annotation_app.items.replaced_videos import replaced
from annotation_app.store.models import Study
from annotation_app.study_setup.every_problem import together
from annotation_app.tasks.corpus_parts import people_of
from annotation_app.tasks.episode_parts import LEAST, EpisodeParts, KeepFrom
from annotation_app.tasks.task_registry import tasks
from corpus_tools.lerobot.episode_index import IndexColumn
from corpus_tools.lerobot.language_rows import TASK_AUG
from corpus_tools.lerobot.language_writing import EpisodeLanguage
from g3.errors import FormatError


@dataclass(frozen=True, slots=True)
class PeoplesLanguage:
    """Language of people, for a copy of a dataset."""

    dataset: Path
    """The dataset's folder, as the study's table names it."""
    language: Mapping[int, EpisodeLanguage]
    """Language by the numbers of episodes."""
    columns: Sequence[IndexColumn]
    """Columns of the episodes' index."""
    files: Mapping[str, bytes]
    """Further files by their names in the copy."""
    counts: Mapping[str, int]
    """Number of each kind of language."""
    episodes: Mapping[int, Mapping[str, Any]]
    """The row of the study's table of each episode."""


def peoples_language(
    session: Session, study: Study, keep_from: KeepFrom = LEAST
) -> PeoplesLanguage:
    """Return the answers to a study of a dataset's episodes, task by task.

    The first wording of a task (``task_aug``) is also the task of an episode that had none.

    A FormatError reports that the study's videos are no episodes. A CorpusError lists the files
    that were replaced since they were shown to people.
    """
    films = films_of(session, study.id)
    videos = {video: film.metadata for video, film in films.items() if "episode" in film.metadata}
    datasets = {str(row["dataset"]) for row in videos.values() if "dataset" in row}
    if len(datasets) != 1:
        several = f"the videos are of several datasets: {', '.join(sorted(datasets))}"
        raise FormatError(
            several if datasets else "the videos are no episodes of a LeRobot dataset",
            where=f"study {study.name}",
            fix="make the study of what `ct import lerobot` writes",
        )
    if wrong := list(replaced(session, study.id, with_gone=False)):
        raise together(wrong)
    parts = EpisodeParts(session, study, videos, people_of(session), keep_from=keep_from)
    for task in tasks():
        task.episodes(parts)
    language = {
        index: EpisodeLanguage(
            tuple(rows),
            frozenset(parts.replaced[index]),
            next((row.text for row in rows if row.style == TASK_AUG), ""),
            parts.corrected.get(index, {}),
        )
        for index in sorted(parts.language.keys() | parts.corrected.keys())
        for rows in [parts.language.get(index, [])]
    }
    files = {name: msgspec.json.Encoder().encode_lines(rows) for name, rows in parts.files.items()}
    files |= {name: indented(value) for name, value in parts.documents.items()}
    written = language.keys() | {index for column in parts.columns for index in column.values}
    counts = {"episodes": len(written), **parts.counts}
    whole = filter(parts.shows_whole_episode, videos)
    episodes = {parts.episode(video): videos[video] for video in whole}
    return PeoplesLanguage(Path(datasets.pop()), language, parts.columns, files, counts, episodes)


def indented(value: Any) -> bytes:
    """Return a value as JSON for people to read."""
    return msgspec.json.format(msgspec.json.encode(value), indent=2) + b"\n"


def language_lines(said: PeoplesLanguage) -> bytes:
    """Return a line for each text of people, then those of :attr:`PeoplesLanguage.files`.

    ``source`` is the episode's place in the dataset, ``step`` the number of the frame, and
    ``time_ns`` the moment by the recording's clock; each is null where it isn't known.
    """
    lines = msgspec.json.Encoder().encode_lines(list(_texts(said)))
    more = (content for name, content in said.files.items() if name.endswith(".jsonl"))
    return b"".join((lines, *more))


def _texts(said: PeoplesLanguage) -> Iterator[dict[str, Any]]:
    for index, added in said.language.items():
        about = said.episodes.get(index, {})
        rate, start = rate_of(about), str(about.get("start") or "")
        for item in added.said:
            time_ns = int(start) + round(item.start_s * 1e9) if start.isdecimal() else None
            yield {
                "episode_index": index,
                "source": about.get("source") or None,
                "style": item.style,
                "start_s": item.start_s,
                "step": round(item.start_s * rate) if rate else None,
                "time_ns": time_ns,
                "content": item.text,
                **item.of_event(),
                **item.source,
            }


def rate_of(about: Any) -> float:
    """Return the frames a second of an episode by its row of the study's table; 0 if unknown."""
    try:
        rate = float(about.get("fps") or 0)
    except (TypeError, ValueError):
        return 0.0
    return rate if 0 < rate < float("inf") else 0.0
