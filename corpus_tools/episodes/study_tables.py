"""Tables for a study of episodes, with the same columns for every format.

- ``episodes.csv``: the episodes as videos, to be described and cut into subtasks.
- ``tasks.csv``: the dataset's task of each episode, as a command to be checked or rated.
- ``subtasks.csv``: the dataset's own subtasks, each with its part of the video. Only LeRobot's
  datasets have some.
- ``moments.csv``: the same of its other texts at moments: memory, motion, interjections, and
  questions with answers that words can give.

Videos are made of episodes that are pictures, beside the tables. Further cameras have numbered
columns (``video_2``, ``start_s_2``, ``end_s_2``, ``camera_2``), and ``curves`` names a file with
numbers over time.
"""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice, repeat
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Protocol

from corpus_tools.episodes.curves import CURVES, EpisodeCurves
from corpus_tools.episodes.depth import DepthScale
from corpus_tools.episodes.films import Picture, write_film
from corpus_tools.runtime.atomic_folder import check_target, write_folder
from corpus_tools.runtime.progress import OnProgress, no_progress
from corpus_tools.tables.curve_file import SUFFIX, write_curves
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


@dataclass(frozen=True, slots=True)
class View:
    """The part of a camera's video that shows an episode; `path` is as tables have it."""

    path: str
    start_s: float = 0.0
    is_whole: bool = True
    """True if the file shows nothing else."""

    def cells(self, since_s: float, until_s: float, *, is_part: bool) -> tuple[object, ...]:
        """Return the file and the part between two times of the episode, as tables have them."""
        if not self.path or (self.is_whole and not is_part):
            return self.path, "", ""
        return self.path, round(self.start_s + since_s, 6), round(self.start_s + until_s, 6)


NO_VIEW = View("")
"""That of a camera which an episode lacks."""


def no_curves(frames: int) -> None:
    """Return None, as for episodes without numbers."""


@dataclass(frozen=True, slots=True, eq=False)
class RecordedEpisode:
    """An episode whose frames are pictures or videos."""

    index: int
    """Its number in the whole dataset, from 0."""
    source: str
    """Its place in the dataset, such as ``demo.hdf5/demo_3``."""
    tasks: tuple[str, ...]
    fps: float
    """Frames a second."""
    views: Mapping[str, Iterator[Picture] | Path]
    """Its pictures, or a video of them, by camera; cameras that it lacks are left out.

    Pictures are read as they are needed; errors are raised then.
    """
    start: str = ""
    """The time of the first picture by the recording's clock, if there is one."""
    curves: Callable[[int], EpisodeCurves | None] = no_curves
    """Curves for a video of so many frames; None if there are no numbers."""


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
    def other_cameras(self) -> Collection[str]:
        """Names of further ones that people see only if they are chosen."""

    @property
    def without_cameras(self) -> str:
        """Remedy for a dataset without a camera."""

    @property
    def notes(self) -> Sequence[str]:
        """Notes about the dataset as a whole."""

    def episodes(self, cameras: Sequence[str], on_error: OnError) -> Iterator[RecordedEpisode]:
        """Yield the episodes in their order; `on_error` gets the errors of those left out.

        The first camera's time is that of the episode.
        """


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
    others: Collection[str] = (),
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
    others
        Further cameras that are seen only if they are given.
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
    usual = [name for name in seen if name not in others]
    return wanted or (usual or seen)[:MOST_CAMERAS]


def camera_columns(cameras: Sequence[str]) -> list[str]:
    """Return the columns of the cameras after the first one."""
    names = ("video", "start_s", "end_s", "camera")
    return [f"{name}_{number}" for number in range(2, len(cameras) + 1) for name in names]


def camera_cells(
    views: Sequence[View], cameras: Sequence[str], since_s: float, until_s: float, *, is_part: bool
) -> Iterator[object]:
    """Yield the cells of the cameras after the first one, between two times of the episode."""
    for camera, view in zip(cameras[1:], views[1:], strict=True):
        yield from (*view.cells(since_s, until_s, is_part=is_part), camera if view.path else "")


def curve_columns(curves: Mapping[int, str]) -> list[str]:
    """Return the columns of curves, by the files of the episodes that have some."""
    return [CURVES, f"{CURVES}_start_s"] if curves else []


def curve_cells(index: int, curves: Mapping[int, str], since_s: float) -> tuple[object, ...]:
    """Return the cells of an episode's curves that begin at a time."""
    return () if not curves else (curves.get(index, ""), since_s or "")


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


def write_tables(make: Callable[[Path], StudyInput], folder: Path, *, force: bool) -> StudyInput:
    """Write the tables that `make` returns to a folder; `make` gets a folder for films.

    Parameters
    ----------
    force
        True to replace the tables that are there.
    """
    check_target(folder, force=force, marker=EPISODES)
    with TemporaryDirectory(dir=folder.parent, prefix=".episodes-") as scratch:
        made = make(Path(scratch))
        write_folder(folder, made.files, force=force, marker=EPISODES)
    return made


def is_of_episodes(table: Path) -> bool:
    """Check that a table of videos is one of episodes, as importers write it."""
    if table.name != EPISODES or not table.is_file():
        return False
    with table.open(encoding="utf-8", errors="replace", newline="") as file:
        return {*VIDEO_COLUMNS, "episode", "dataset"} <= set(next(csv.reader(file), []))


def _csv(header: Sequence[str], rows: Iterable[Sequence[object]]) -> bytes:
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerow(header)
    writer.writerows(rows)
    return text.getvalue().encode()


def study_input(
    source: EpisodeSource,
    folder: Path,
    scratch: Path,
    *,
    cameras: Sequence[str] = (),
    first: int | None = None,
    has_curves: bool = True,
    keep_going: bool = False,
    on_progress: OnProgress = no_progress,
) -> StudyInput:
    """Make the tables, videos and curves for a study of episodes that are pictures or videos.

    Parameters
    ----------
    folder
        The folder where the tables will be; paths in them begin there.
    scratch
        A folder in which videos and curves are made.
    cameras
        The cameras to show, the large one first; by default all that are no depth maps, at most
        `MOST_CAMERAS`. Without a choice, a further camera that can't be shown is left out.
    first
        The number of episodes to take; all if None.
    has_curves
        True to have numbers, such as state and action, beside the videos as curves.
    keep_going
        True to leave out and name episodes that can't be shown.
    """
    is_chosen = bool(cameras)
    cameras = choose_cameras(
        source.cameras,
        cameras,
        depth=source.depth_cameras,
        where=source.path,
        without=source.without_cameras,
        others=source.other_cameras,
    )
    errors: list[CorpusError] = []
    without: dict[str, list[CorpusError]] = {}
    files: dict[str, bytes | Path] = {}
    shown: list[tuple[RecordedEpisode, list[View]]] = []
    curves: dict[int, str] = {}
    for episode in source.episodes(cameras, errors.append):
        filmed = _Filming(source, episode, folder, scratch, without)
        try:
            filmed.make_views(cameras, is_chosen=is_chosen)
        except CorpusError as error:
            errors.append(error)
        else:
            if has_curves:
                filmed.make_curves(curves)
            files |= filmed.files
            # Without its content, of which so much would be too large for the memory.
            shown.append((replace(episode, views={}, curves=no_curves), filmed.made))
        on_progress("making videos of pictures", len(shown), first or 0)
        if first is not None and len(shown) + len(errors) >= first:
            break
    check_errors(errors, len(shown), keep_going=keep_going)
    if not shown:
        raise FormatError("there are no episodes", where=str(source.path), fix="record some first")
    notes = [*(f"left out: {error}" for error in errors), *source.notes]
    for what, several in without.items():
        notes.append(f"{len(several)} episodes without {what}, the first because: {several[0]}")
    notes += [depth_note(camera) for camera in cameras if camera in source.depth_cameras]
    if others := [name for name in source.cameras if name not in cameras]:
        notes.append(f"cameras that aren't shown: {', '.join(others[:MOST_CAMERAS])}")
    header = ("episode", "task", "camera", "dataset", "source", "fps", "start")
    rows = [
        (
            views[0].path, episode_name(one.index), "", "",
            one.index, "; ".join(one.tasks), cameras[0], str(source.path), one.source, one.fps,
            one.start,
            *camera_cells(views, cameras, 0.0, 0.0, is_part=False),
            *curve_cells(one.index, curves, 0.0),
        )
        for one, views in shown
    ]  # fmt: skip
    tasks = [(episode_name(e.index), task, e.index, "task") for e, _ in shown for task in e.tasks]
    more = (*camera_columns(cameras), *curve_columns(curves))
    tables: dict[str, Table] = {
        EPISODES: ((*VIDEO_COLUMNS, *header, *more), rows),
        TASKS: (TASK_COLUMNS, tasks),
    }
    return written(tables, files, notes)


class _Filming:
    """Videos and curves of an episode."""

    def __init__(
        self,
        source: EpisodeSource,
        episode: RecordedEpisode,
        folder: Path,
        scratch: Path,
        without: dict[str, list[CorpusError]],
    ) -> None:
        self._without = without
        self._episode, self._folder, self._scratch = episode, folder.resolve(), scratch
        self._where = f"{source.path}, {episode.source}"
        self._frames = 0
        self.made: list[View] = []
        self.files: dict[str, bytes | Path] = {}

    def make_views(self, cameras: Sequence[str], *, is_chosen: bool) -> None:
        """Make the video of each camera; a further one may be left out, unless it is chosen."""
        for number, camera in enumerate(cameras, start=1):
            try:
                self.made.append(self._view(camera, number))
            except CorpusError as error:
                if is_chosen or number == 1:
                    raise
                self.made.append(NO_VIEW)
                self._without.setdefault(camera, []).append(error)

    def _view(self, camera: str, number: int) -> View:
        pictures = self._episode.views.get(camera)
        where = self._where if number == 1 else f"{self._where}, {camera}"
        if pictures is None:
            raise FormatError(f"there are no pictures by {camera}", where=self._where)
        if isinstance(pictures, Path):
            return View(os.path.relpath(pictures, self._folder))
        name = f"{FILMS}/camera-{number}" if number > 1 else FILMS
        name += f"/{episode_name(self._episode.index)}.mp4"
        if number > 1 and self._frames:
            pictures = _held(pictures, self._frames)
        frames = write_film(pictures, self._scratch / name, self._episode.fps, where)
        self._frames = self._frames or frames
        self.files[name] = self._scratch / name
        return View(name)

    def make_curves(self, written_curves: dict[int, str]) -> None:
        """Write the episode's curves, if it has some and they can be read."""
        index = self._episode.index
        name = f"{CURVES}/{episode_name(index)}{SUFFIX}"
        file = self._scratch / name
        file.parent.mkdir(parents=True, exist_ok=True)
        try:
            made = self._episode.curves(self._frames)
            if made is not None:
                write_curves(file, made.curves, made.rate, made.samples, made.pieces)
                self.files[name] = file
                written_curves[index] = name
        except CorpusError as error:
            self._without.setdefault(CURVES, []).append(error)


def _held(pictures: Iterator[Picture], frames: int) -> Iterator[Picture]:
    """Yield so many pictures; the last one stays if there are fewer."""
    last, left = None, frames
    for last in islice(pictures, frames):
        left -= 1
        yield last
    if last is not None:
        yield from repeat(last, left)
