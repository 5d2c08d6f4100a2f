"""Tables for a study of episodes, with the same columns for every format.

- ``episodes.csv``: the episodes as videos, to be described and cut into subtasks.
- ``tasks.csv``: the dataset's task of each episode, as a command to be checked or rated.
- ``subtasks.csv``: the dataset's own subtasks, each with its part of the video. Only LeRobot's
  datasets have some.
- ``moments.csv``: the same of its other texts at moments: memory, motion, interjections, and
  questions with answers that words can give.

Videos are made of episodes that are pictures, beside the tables.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from corpus_tools.episodes.depth import DepthScale
from corpus_tools.episodes.films import Picture, write_film
from corpus_tools.runtime.progress import OnProgress, no_progress
from g3.errors import CorpusError, FormatError, ManyError

EPISODES, TASKS, SUBTASKS = "episodes.csv", "tasks.csv", "subtasks.csv"
MOMENTS = "moments.csv"
FILMS = "films"
"""The folder beside the tables with the videos that were made of pictures, or are links."""
MOST_CAMERAS = 8
"""Largest number of cameras that people see side by side."""
VIDEO_COLUMNS = ("video", "id", "start_s", "end_s")
TASK_COLUMNS = ("video", "command", "episode", "style")

OnError = Callable[[CorpusError], None]
Table = tuple[Sequence[str], Sequence[Sequence[object]]]
"""A header, and rows."""


@dataclass(frozen=True, slots=True)
class StudyInput:
    """The tables by name, and videos that were made for them."""

    files: dict[str, bytes | Path]
    rows: dict[str, int]
    """The number of rows of each table."""
    notes: tuple[str, ...] = ()
    """The parts of the dataset that aren't shown as it has them, each with the reason."""


@dataclass(frozen=True, slots=True, eq=False)
class RecordedEpisode:
    """An episode whose frames are pictures."""

    index: int
    """Its number in the whole dataset, from 0."""
    source: str
    """Its place in the dataset, such as ``demo.hdf5/demo_3``."""
    tasks: tuple[str, ...]
    fps: float
    """Frames a second."""
    pictures: Iterator[Picture]
    """Read as they are needed; errors are raised then."""
    start: str = ""
    """The time of the first picture by the recording's clock, if there is one."""


class EpisodeSource(Protocol):
    """A dataset of episodes in a format that is read."""

    @property
    def path(self) -> Path:
        """The dataset's file or folder."""

    @property
    def cameras(self) -> Sequence[str]:
        """Names of the cameras."""

    @property
    def depth_cameras(self) -> Collection[str]:
        """Names of those whose pixels are distances."""

    @property
    def without_cameras(self) -> str:
        """Remedy for a dataset without a camera."""

    @property
    def notes(self) -> Sequence[str]:
        """Notes about the dataset as a whole."""

    def episodes(self, camera: str, on_error: OnError) -> Iterator[RecordedEpisode]:
        """Yield the episodes in their order; `on_error` gets the errors of those left out."""


def episode_name(index: int) -> str:
    """Return the name of an episode in a study."""
    return f"episode-{index:06d}"


def choose_cameras(
    cameras: Sequence[str],
    wanted: Sequence[str],
    *,
    depth: Collection[str],
    where: Path,
    without: str,
) -> Sequence[str]:
    """Return the cameras that people see: the given ones, else all that are no depth maps.

    Parameters
    ----------
    cameras
        All of the dataset.
    wanted
        The cameras to show, the large one first.
    where
        The dataset, for errors.
    without
        Remedy for a dataset without a camera.

    Raises
    ------
    FormatError
        If there is no such camera, or none at all that shows what is done.
    """
    named = ", ".join(f"{name} (a depth map)" if name in depth else name for name in cameras)
    if not cameras:
        raise FormatError(
            "the dataset has no videos and no images: its frames are numbers only, and people "
            "couldn't see what is done",
            where=str(where),
            fix=without,
        )
    wanted = list(dict.fromkeys(wanted))
    if len(wanted) > MOST_CAMERAS:
        what = f"people can see {MOST_CAMERAS} cameras side by side, and {len(wanted)} are given"
        raise FormatError(what, where="--camera", fix="give fewer")
    for camera in wanted:
        if camera not in cameras:
            raise FormatError(
                f"the dataset has no camera {camera!r}",
                where="--camera",
                fix=f"the cameras are: {named}",
            )
    seen = [name for name in cameras if name not in depth]
    if not wanted and not seen:
        raise FormatError(
            "all cameras are depth maps, on which people can't see what is done",
            where=str(where),
            fix=f"show one all the same with --camera: {named}",
        )
    return wanted or seen[:MOST_CAMERAS]


def depth_note(camera: str, scale: DepthScale | None = None) -> str:
    """Return the note that people see a depth map, with the scale of its false colours."""
    if scale is None:
        return f"{camera} is a depth map: people see distances, no colours"
    ends = f"{scale.near_m:.2f} m (red) to {scale.far_m:.2f} m (blue)"
    return f"{camera} is a depth map: people see distances, from {ends}"


def check_errors(errors: Sequence[CorpusError], shown: int, *, keep_going: bool) -> None:
    """Raise the errors of episodes, unless they may be left out and some are shown."""
    if errors and not (keep_going and shown):
        raise errors[0] if len(errors) == 1 else ManyError(errors)


def written(
    tables: dict[str, Table], files: dict[str, bytes | Path], notes: Iterable[str]
) -> StudyInput:
    """Return the input of a study; empty tables are left out, but for the first."""
    kept = {name: table for name, table in tables.items() if table[1] or name == EPISODES}
    files |= {name: _csv(header, rows) for name, (header, rows) in kept.items()}
    return StudyInput(files, {name: len(rows) for name, (_, rows) in kept.items()}, tuple(notes))


def _csv(header: Sequence[str], rows: Iterable[Sequence[object]]) -> bytes:
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerow(header)
    writer.writerows(rows)
    return text.getvalue().encode()


def study_input(
    source: EpisodeSource,
    scratch: Path,
    *,
    camera: str | None = None,
    first: int | None = None,
    keep_going: bool = False,
    on_progress: OnProgress = no_progress,
) -> StudyInput:
    """Make the tables and videos for a study of episodes that are pictures.

    Parameters
    ----------
    scratch
        A folder in which videos are made.
    camera
        The camera to show; by default the first that is no depth map.
    first
        The number of episodes to take; all if None.
    keep_going
        True to leave out and name episodes that can't be shown.

    Raises
    ------
    FormatError
        If there is no such camera, or episodes can't be read.
    """
    shown_camera, *_ = choose_cameras(
        source.cameras,
        () if camera is None else (camera,),
        depth=source.depth_cameras,
        where=source.path,
        without=source.without_cameras,
    )
    errors: list[CorpusError] = []
    files: dict[str, bytes | Path] = {}
    shown: list[RecordedEpisode] = []
    for episode in source.episodes(shown_camera, errors.append):
        name = f"{FILMS}/{episode_name(episode.index)}.mp4"
        film = scratch / f"{episode_name(episode.index)}.mp4"
        try:
            write_film(episode.pictures, film, episode.fps, f"{source.path}, {episode.source}")
        except CorpusError as error:
            errors.append(error)
        else:
            files[name] = film
            shown.append(episode)
        on_progress("making videos of pictures", len(shown), first or 0)
        if first is not None and len(shown) + len(errors) >= first:
            break
    check_errors(errors, len(shown), keep_going=keep_going)
    if not shown:
        raise FormatError("there are no episodes", where=str(source.path), fix="record some first")
    notes = [*(f"left out: {error}" for error in errors), *source.notes]
    if shown_camera in source.depth_cameras:
        notes.append(depth_note(shown_camera))
    where = str(source.path)
    header = ("episode", "task", "camera", "dataset", "source", "fps", "start")
    rows = [
        (
            name, episode_name(one.index), "", "",
            one.index, "; ".join(one.tasks), shown_camera, where, one.source, one.fps, one.start,
        )
        for name, one in zip(files, shown, strict=True)
    ]  # fmt: skip
    tasks = [(episode_name(e.index), task, e.index, "task") for e in shown for task in e.tasks]
    tables: dict[str, Table] = {
        EPISODES: ((*VIDEO_COLUMNS, *header), rows),
        TASKS: (TASK_COLUMNS, tasks),
    }
    return written(tables, files, notes)
