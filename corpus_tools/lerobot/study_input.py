"""Tables for a study of a LeRobot dataset: its videos, and the dataset's own language.

No video is copied: tables name files and parts of them (``start_s``, ``end_s``). Only episodes
whose frames are pictures get videos, beside the tables.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from corpus_tools.episodes.films import Picture, decoded, write_film
from corpus_tools.episodes.study_tables import (
    EPISODES,
    FILMS,
    SUBTASKS,
    TASK_COLUMNS,
    TASKS,
    VIDEO_COLUMNS,
    StudyInput,
    Table,
    check_errors,
    choose_camera,
    depth_note,
    episode_name,
    written,
)
from corpus_tools.lerobot.dataset_files import (
    check_is_file,
    damaged,
    file_inside,
    first_of,
    parquet_file,
    whole_numbers_of,
)
from corpus_tools.lerobot.episode_frames import (
    EPISODE_INDEX,
    FramedEpisode,
    OnError,
    checked_episodes,
)
from corpus_tools.lerobot.episode_reading import INFO, Dataset
from corpus_tools.lerobot.language_rows import SUBTASK, Row, persistent_rows_of
from corpus_tools.runtime.progress import OnProgress, no_progress
from g3.errors import CorpusError, FormatError

_ROUNDING_S = 1e-3

Seconds = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class _Shown:
    """The part of a video that shows an episode; `path` is as tables have it."""

    framed: FramedEpisode
    path: str
    start_s: float
    is_whole: bool
    """True if the file shows nothing else."""

    @property
    def end_s(self) -> float:
        return self.start_s + self.framed.length_s


def study_input(
    dataset: Dataset,
    folder: Path,
    *,
    camera: str | None = None,
    first: int | None = None,
    scratch: Path | None = None,
    keep_going: bool = False,
    on_progress: OnProgress = no_progress,
) -> StudyInput:
    """Make the tables for a study of a dataset.

    Parameters
    ----------
    folder
        The folder where the tables will be; paths in them begin there.
    camera
        The feature to show; by default the first video that is no depth map, else the first such
        image.
    first
        The number of episodes to take; all if None.
    scratch
        A folder in which videos are made of pictures; a dataset of pictures needs it.
    keep_going
        True to leave out and name episodes that can't be shown.

    Raises
    ------
    FormatError
        If the dataset has no such camera, or metadata, frames or videos can't be read or contradict
        each other.
    """
    shown_camera = _camera(dataset, camera)
    is_video = shown_camera in dataset.cameras
    errors: list[CorpusError] = []
    cameras = (shown_camera,) if is_video else ()
    every = list(
        checked_episodes(
            dataset,
            cameras,
            first=first,
            is_thorough=True,
            on_error=errors.append,
            on_progress=on_progress,
        )
    )
    framed = [one for one in every if one.episode.frames]
    files: dict[str, bytes | Path] = {}
    if is_video:
        shown, longer = _parts(
            dataset, framed, shown_camera, folder, on_error=errors.append, on_progress=on_progress
        )
        videos = (one.framed.episode.videos[shown_camera].file for one in shown)
        files |= {name: file for file in videos if (name := _linked(dataset, file))}
    else:
        if scratch is None:
            raise FormatError("videos are to be made of pictures", fix="give a folder for them")
        films = write_films(dataset, framed, shown_camera, scratch, on_progress=on_progress)
        names = {index: f"{FILMS}/{film.name}" for index, film in films.items()}
        files |= {names[index]: film for index, film in films.items()}
        shown = [_Shown(f, names[f.episode.index], 0.0, True) for f in framed]
        longer = []
    check_errors(errors, len(shown), keep_going=keep_going)
    if not shown:
        raise FormatError(
            "no episode has frames", where=str(dataset.folder), fix="record episodes first"
        )
    notes = [
        *(f"left out: {error}" for error in errors),
        *_notes(dataset, every, shown_camera, longer, is_all=first is None and not errors),
    ]
    tables: dict[str, Table] = {
        EPISODES: (
            (*VIDEO_COLUMNS, "episode", "task", "camera", "dataset"),
            list(_episodes(dataset, shown, shown_camera)),
        ),
        TASKS: (
            TASK_COLUMNS,
            [
                (episode_name(one.framed.episode.index), task, one.framed.episode.index, "task")
                for one in shown
                for task in one.framed.episode.tasks
            ],
        ),
        SUBTASKS: (
            (*VIDEO_COLUMNS, "command", "episode", "style", "timestamp", "dataset"),
            list(_subtasks(dataset, shown, notes)),
        ),
    }
    return written(tables, files, notes)


def _camera(dataset: Dataset, camera: str | None) -> str:
    return choose_camera(
        (*dataset.cameras, *dataset.image_cameras),
        camera,
        depth=dataset.depth_cameras,
        where=dataset.folder,
        without="take a dataset with a camera, or draw its episodes as videos and make a study of "
        "these: ct annotate init study.yaml --videos FOLDER",
    )


def _parts(
    dataset: Dataset,
    framed: Sequence[FramedEpisode],
    camera: str,
    folder: Path,
    *,
    on_error: OnError,
    on_progress: OnProgress,
) -> tuple[list[_Shown], list[int]]:
    """Return the parts of videos that show episodes, and the episodes with longer videos."""
    from corpus_tools.video.probe import VideoInfo, probe  # noqa: PLC0415 - PyAV may be missing

    files = list(dict.fromkeys(one.episode.videos[camera].file for one in framed))
    looked_at: dict[Path, VideoInfo | None] = {}
    for number, file in enumerate(files):
        on_progress("looking at videos", number, len(files))
        try:
            check_is_file(file)
            info = probe(file)
            if info.problem:
                what, fix = f"the video isn't whole: {info.problem}", "download it again"
                raise FormatError(what, where=str(file), fix=fix)
            looked_at[file] = info
        except CorpusError as error:
            looked_at[file] = None
            on_error(error)
    shown, longer = [], []
    for one in framed:
        part = one.episode.videos[camera]
        looked = looked_at[part.file]
        if looked is None:
            continue
        start_s = part.start_s + float(one.frames.times[0])
        if what := _problem(one, camera, looked.frame_times, dataset.info.fps):
            on_error(one.episode.error(what))
            continue
        end_s = start_s + one.length_s
        margin_s = 0.5 / dataset.info.fps
        last_s = looked.duration_s if part.end_s is None else part.end_s
        if last_s > end_s + margin_s:
            longer.append(one.episode.index)
        times = looked.frame_times
        is_whole = bool(start_s - margin_s < times[0] and times[-1] < end_s - _ROUNDING_S)
        path = _linked(dataset, part.file) or os.path.relpath(part.file, folder.resolve())
        shown.append(_Shown(one, path, start_s, is_whole))
    return shown, longer


def _linked(dataset: Dataset, file: Path) -> str:
    """Return the name beside the tables of a video whose own name is a link; empty for any other.

    The file at the end of a link may have a name without an ending, as in Hugging Face's cache, and
    studies refuse such files. So it gets a second name.
    """
    is_link = file.resolve().name != file.name
    return f"{FILMS}/{file.relative_to(dataset.folder).as_posix()}" if is_link else ""


def _problem(one: FramedEpisode, camera: str, frame_times: Seconds, fps: float) -> str:
    """Return the reason why a part of a video doesn't show an episode; empty if it does."""
    part, times = one.episode.videos[camera], one.frames.times
    margin_s = 0.5 / fps + _ROUNDING_S
    if part.end_s is not None:
        stated_s = part.end_s - part.start_s
        if stated_s < float(times[-1]) + 1 / fps - margin_s:
            return (
                f"its part of the video {part.file.name} takes {stated_s:g} s, and its "
                f"{len(times)} frames take {one.length_s:g} s"
            )
    wanted = part.start_s + times
    after = np.clip(np.searchsorted(frame_times, wanted), 0, len(frame_times) - 1)
    before = np.maximum(after - 1, 0)
    gaps = np.minimum(np.abs(frame_times[after] - wanted), np.abs(frame_times[before] - wanted))
    apart_s = float(np.median(np.diff(frame_times))) if len(frame_times) > 1 else 1 / fps
    missing = np.flatnonzero(gaps > max(margin_s, 0.5 * apart_s + _ROUNDING_S))
    if not len(missing):
        return ""
    return (
        f"{len(missing)} of its {len(times)} frames are not in the video {part.file.name}, which "
        f"has frames from 0 to {frame_times[-1]:g} s: the first would be at "
        f"{wanted[missing[0]]:g} s"
    )


def _notes(
    dataset: Dataset,
    every: Sequence[FramedEpisode],
    camera: str,
    longer: Sequence[int],
    *,
    is_all: bool,
) -> Iterator[str]:
    if camera in dataset.depth_cameras:
        yield depth_note(camera)
    empty = [one.episode.index for one in every if not one.episode.frames]
    if empty:
        yield f"left out, as they have no frames: {len(empty)} episodes: {first_of(empty)}"
    if longer:
        yield (
            f"the videos of {len(longer)} episodes go on after their frames; people see the "
            f"frames only: {first_of(longer)}"
        )
    stated = dataset.info.total_episodes
    if is_all and stated is not None and stated != len(every):
        yield f"{INFO} has {stated!r:.20} as total_episodes, and there are {len(every)}"


def _episodes(dataset: Dataset, shown: Sequence[_Shown], camera: str) -> Iterator[Sequence[object]]:
    for one in shown:
        episode = one.framed.episode
        part = ("", "") if one.is_whole else (round(one.start_s, 6), round(one.end_s, 6))
        tasks = "; ".join(episode.tasks)
        yield (
            one.path, episode_name(episode.index), *part,
            episode.index, tasks, camera, str(dataset.folder),
        )  # fmt: skip


def _subtasks(
    dataset: Dataset, shown: Sequence[_Shown], notes: list[str]
) -> Iterator[Sequence[object]]:
    """Yield the rows of the dataset's own subtasks; those with one beginning share a part."""
    by_index = {one.framed.episode.index: one for one in shown}
    seen: set[int] = set()
    for file in dict.fromkeys(one.framed.episode.data for one in shown):
        for index, rows in persistent_rows_of(file):
            one = by_index.get(index)
            if one is None or index in seen:
                continue
            seen.add(index)
            first_s, length_s = float(one.framed.frames.times[0]), one.framed.length_s
            subtasks = []
            for row in sorted((r for r in rows if r["style"] == SUBTASK), key=_time):
                since_s = round(_time(row) - first_s, 6)
                if not 0 <= since_s < length_s or not (row["content"] or "").strip():
                    text, at = repr(row["content"])[:60], f"at {_time(row):g} s"
                    why = f"isn't shown: the episode has {length_s:g} s, and it needs a text"
                    notes.append(f"episode {index}: the subtask {text} {at} {why}")
                    continue
                subtasks.append((since_s, row))
            starts = [*sorted({since_s for since_s, _ in subtasks}), length_s]
            for number, (since_s, row) in enumerate(subtasks, start=1):
                end_s = starts[starts.index(since_s) + 1]
                part = (round(one.start_s + since_s, 6), round(one.start_s + end_s, 6))
                name = f"{episode_name(index)}-subtask-{number:02d}"
                of_row = (row["content"], index, SUBTASK, _time(row), str(dataset.folder))
                yield (one.path, name, *part, *of_row)


def _time(row: Row) -> float:
    return float(row["timestamp"])


FILES = (
    "images/{key}/episode_{episode:06d}/frame_{frame:06d}.png",
    "images/{key}/episode-{episode:06d}/frame-{frame:06d}.png",
)
"""The files of pictures, as LeRobot has them in version 2 and in version 3."""
ROWS_AT_ONCE = 16
LARGEST_FILE = 256 << 20


def write_films(
    dataset: Dataset,
    episodes: Sequence[FramedEpisode],
    camera: str,
    folder: Path,
    *,
    on_progress: OnProgress,
) -> dict[int, Path]:
    """Write a video of each episode into a folder, by the numbers of the episodes.

    Raises
    ------
    FormatError
        If a picture is missing, can't be read, or hasn't the size of the first of its episode.
    """
    wanted = {one.episode.index: one for one in episodes}
    films: dict[int, Path] = {}
    for file in dict.fromkeys(one.episode.data for one in episodes):
        for index, cells in groupby(_cells(file, camera), key=lambda cell: cell.episode):
            one = wanted.get(index)
            if one is None:
                continue
            if index in films:
                raise one.episode.error(f"its frames in {file.name} are not all together")
            films[index] = folder / f"episode-{index:06d}.mp4"
            pictures = _pictures(dataset, camera, cells)
            write_film(pictures, films[index], dataset.info.fps, str(file))
            on_progress("making videos of pictures", len(films), len(wanted))
    return films


@dataclass(frozen=True, slots=True)
class _Cell:
    """The picture of a frame, as the data have it."""

    episode: int
    frame: int
    """Counted from 0 in the episode."""
    value: Any
    where: str


def _cells(file: Path, camera: str) -> Iterator[_Cell]:
    row, last, frame = 0, -1, 0
    with parquet_file(file) as parquet:
        has_cells = camera in parquet.schema_arrow.names
        columns = [EPISODE_INDEX, *([camera] if has_cells else [])]
        for batch in parquet.iter_batches(ROWS_AT_ONCE, columns=columns):
            episodes = whole_numbers_of(batch, EPISODE_INDEX, file, row).tolist()
            cells = batch.column(camera).to_pylist() if has_cells else [None] * len(episodes)
            for index, cell in zip(episodes, cells, strict=True):
                frame = frame + 1 if index == last else 0
                last = index
                where = f"{file}, column {camera}, episode {index}, frame {frame}"
                yield _Cell(index, frame, cell, where)
            row += len(episodes)


def _pictures(dataset: Dataset, camera: str, cells: Iterable[_Cell]) -> Iterator[Picture]:
    for cell in cells:
        yield decoded(_content(dataset, camera, cell), cell.where)


def _content(dataset: Dataset, camera: str, cell: _Cell) -> bytes:
    """Return the bytes of a picture: from the cell, else from the named or usual file."""
    is_row = isinstance(cell.value, Mapping)
    content = cell.value.get("bytes") if is_row else cell.value
    if isinstance(content, bytes) and content:
        return content
    named = cell.value.get("path") if is_row else cell.value
    names = [p.format(key=camera, episode=cell.episode, frame=cell.frame) for p in FILES]
    if isinstance(named, str) and named:
        names.insert(0, named)
    for name in names:
        file = file_inside(dataset.folder, name, where=cell.where)
        if file.exists():
            check_is_file(file)
            if file.stat().st_size > LARGEST_FILE:
                raise damaged(file, "the picture is too large")
            return file.read_bytes()
    raise damaged(cell.where, f"there is no picture, and no file {names[0]}")
