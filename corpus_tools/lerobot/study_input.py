"""What a study needs of a LeRobot dataset: tables that name its videos, and what is said of them.

No video is copied: tables name files and parts of them (``start_s``, ``end_s``).

- ``episodes.csv``: the episodes as videos, to be described and cut into subtasks.
- ``tasks.csv``: what the dataset says is done in each, as commands to be checked or rated.
- ``subtasks.csv``: the dataset's subtasks, each with its part of the video, as commands to be
  rated. Only for datasets with language.
"""

from __future__ import annotations

import csv
import io
import os
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from corpus_tools.lerobot.episode_reading import Dataset, Episode, VideoPart
from corpus_tools.lerobot.language_rows import SUBTASK, Row, persistent_rows
from g3.errors import FormatError

EPISODES, TASKS, SUBTASKS = "episodes.csv", "tasks.csv", "subtasks.csv"
_VIDEO = ("video", "id", "start_s", "end_s")


@dataclass(frozen=True, slots=True)
class StudyInput:
    """Tables by name, and how many rows they have."""

    files: dict[str, bytes]
    rows: dict[str, int]


def episode_name(index: int) -> str:
    """What an episode is called in a study."""
    return f"episode-{index:06d}"


def study_input(
    dataset: Dataset, folder: Path, *, camera: str | None = None, first: int | None = None
) -> StudyInput:
    """The tables for a study of a dataset, with paths that begin in `folder`, where they will be.

    `camera` is the video to show, by default the first camera's; `first` how many episodes to take,
    by default all. FormatError if the dataset has no such camera, a video is missing, or metadata
    can't be read.
    """
    shown = _camera(dataset, camera)
    episodes = list(islice(dataset.episodes(), first))
    _check_files(episodes, shown)
    names = _Names(dataset, folder, shown, episodes)
    tables: dict[str, tuple[Sequence[str], list[Sequence[object]]]] = {
        EPISODES: (
            (*_VIDEO, "episode", "task", "camera", "dataset"),
            [
                (*names.video(e), e.index, "; ".join(e.tasks), shown, str(names.dataset))
                for e in episodes
            ],
        ),
        TASKS: (
            ("video", "command", "episode", "style"),
            [
                (episode_name(e.index), task, e.index, "task")
                for e in episodes
                for task in e.tasks
                if task.strip()
            ],
        ),
        SUBTASKS: (
            (*_VIDEO, "command", "episode", "style", "timestamp", "dataset"),
            list(_subtasks(dataset, names, {e.index: e for e in episodes})),
        ),
    }
    kept = {name: table for name, table in tables.items() if table[1] or name == EPISODES}
    return StudyInput(
        {name: _csv(header, rows) for name, (header, rows) in kept.items()},
        {name: len(rows) for name, (_, rows) in kept.items()},
    )


def _camera(dataset: Dataset, camera: str | None) -> str:
    cameras = dataset.cameras
    if not cameras:
        raise FormatError(
            "the dataset has no videos, and people couldn't see what is done",
            where=str(dataset.folder),
            fix="convert its pictures to videos with LeRobot's own tools",
        )
    if camera is not None and camera not in cameras:
        raise FormatError(
            f"the dataset has no camera {camera!r}",
            where="--camera",
            fix=f"the cameras are: {', '.join(cameras)}",
        )
    return camera or cameras[0]


def _check_files(episodes: Sequence[Episode], camera: str) -> None:
    for file in {episode.videos[camera].file: None for episode in episodes}:
        if not file.is_file():
            raise FormatError(
                "a video is missing", where=str(file), fix="download all of the dataset"
            )


class _Names:
    """How the tables name videos."""

    def __init__(
        self, dataset: Dataset, folder: Path, camera: str, episodes: Sequence[Episode]
    ) -> None:
        self.dataset, self.camera = dataset.folder.resolve(), camera
        self._folder = folder.resolve()
        self._in_file = Counter(episode.videos[camera].file for episode in episodes)

    def video(self, episode: Episode) -> tuple[str, str, float | str, float | str]:
        """An episode; where it has a file of its own, no part is named."""
        part = episode.videos[self.camera]
        is_whole = self._in_file[part.file] == 1 and part.start_s == 0
        start, end = ("", "") if is_whole else (part.start_s, part.end_s)
        return self._path(part), episode_name(episode.index), start, end

    def part(
        self, episode: Episode, number: int, start_s: float, end_s: float
    ) -> tuple[str, str, float, float]:
        """A part of an episode."""
        part = episode.videos[self.camera]
        begin, end = part.start_s + start_s, min(part.start_s + end_s, part.end_s)
        name = f"{episode_name(episode.index)}-subtask-{number:02d}"
        return self._path(part), name, round(begin, 6), round(end, 6)

    def _path(self, part: VideoPart) -> str:
        return os.path.relpath(part.file.resolve(), self._folder)


def _subtasks(
    dataset: Dataset, names: _Names, episodes: dict[int, Episode]
) -> Iterator[Sequence[object]]:
    for index, rows in persistent_rows(dataset):
        episode = episodes.get(index)
        if episode is None:
            continue
        last_s = episode.frames / dataset.info.fps
        subtasks = sorted((r for r in rows if r["style"] == SUBTASK and r["content"]), key=_time)
        ends = [*(_time(row) for row in subtasks[1:]), last_s][: len(subtasks)]
        for number, (row, end_s) in enumerate(zip(subtasks, ends, strict=True), start=1):
            if end_s > _time(row):
                video = names.part(episode, number, _time(row), end_s)
                told = (row["content"], index, SUBTASK, _time(row), str(names.dataset))
                yield (*video, *told)


def _time(row: Row) -> float:
    return float(row["timestamp"])


def _csv(header: Sequence[str], rows: Iterable[Sequence[object]]) -> bytes:
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerow(header)
    writer.writerows(rows)
    return text.getvalue().encode()
