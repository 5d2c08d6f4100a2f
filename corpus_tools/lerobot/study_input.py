"""Tables for a study of a LeRobot dataset: its videos, and the dataset's own language.

No video is copied: tables name files and parts of them (``start_s``, ``end_s``). Only episodes
whose frames are pictures get videos, beside the tables.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from corpus_tools.episodes.curves import CURVES
from corpus_tools.episodes.depth import DepthScale
from corpus_tools.episodes.study_tables import (
    EPISODES,
    FILMS,
    MOMENTS,
    SUBTASKS,
    TASK_COLUMNS,
    TASKS,
    VIDEO_COLUMNS,
    StudyInput,
    Table,
    View,
    camera_cells,
    camera_columns,
    check_errors,
    choose_cameras,
    curve_cells,
    curve_columns,
    depth_note,
    episode_name,
    written,
)
from corpus_tools.lerobot.dataset_files import check_is_file, first_of
from corpus_tools.lerobot.episode_curves import write_episode_curves
from corpus_tools.lerobot.episode_films import has_distances, write_depth_films, write_films
from corpus_tools.lerobot.episode_frames import FramedEpisode, OnError, checked_episodes
from corpus_tools.lerobot.episode_reading import INFO, Dataset
from corpus_tools.lerobot.grounded_answers import in_words
from corpus_tools.lerobot.language_rows import (
    ASSISTANT,
    INTERJECTION,
    MEMORY,
    MOTION,
    SUBTASK,
    USER,
    VQA,
    Row,
    event_rows,
    persistent_rows,
)
from corpus_tools.runtime.progress import OnProgress, no_progress
from g3.errors import CorpusError, FormatError

_OF_SUBTASKS = ("episode", "style", "timestamp", "camera", "dataset")
EVENT_S = 3.0
"""Longest part of an episode that is shown with a text about a moment, in seconds."""
_ROUNDING_S = 1e-3

Seconds = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class _Shown:
    """An episode with its view by each camera; the first one is shown large."""

    framed: FramedEpisode
    views: tuple[View, ...]


def study_input(
    dataset: Dataset,
    folder: Path,
    *,
    cameras: Sequence[str] = (),
    first: int | None = None,
    scratch: Path | None = None,
    has_curves: bool = True,
    keep_going: bool = False,
    on_progress: OnProgress = no_progress,
) -> StudyInput:
    """Make the tables for a study of a dataset.

    The parameters are those of :func:`corpus_tools.episodes.study_tables.study_input`. Without a
    `scratch` folder there are no curves, and pictures and depth maps can't be shown.
    """
    cameras = _cameras(dataset, cameras)
    videos = [name for name in cameras if name in dataset.cameras]
    errors: list[CorpusError] = []
    every = list(
        checked_episodes(
            dataset,
            videos,
            first=first,
            is_thorough=True,
            on_error=errors.append,
            on_progress=on_progress,
        )
    )
    framed = [one for one in every if one.episode.frames]
    files: dict[str, bytes | Path] = {}
    longer: dict[int, None] = {}
    views: dict[str, Mapping[int, View]] = {}
    scales: dict[str, DepthScale] = {}
    for number, camera in enumerate(cameras, start=1):
        there = framed
        if camera in videos:
            views[camera], its_longer = _parts(
                dataset, framed, camera, folder, on_error=errors.append, on_progress=on_progress
            )
            longer |= its_longer
            there = [one for one in framed if one.episode.index in views[camera]]
        is_measured = bool(there) and has_distances(dataset, there[0], camera)
        if camera in videos and not is_measured:
            shown_files = {one.episode.videos[camera].file for one in framed}
            files |= {name: file for file in shown_files if (name := _linked(dataset, file))}
        elif there:
            if scratch is None:
                raise FormatError("videos are to be made of pictures", fix="give a folder for them")
            place = f"{FILMS}/camera-{number}" if number > 1 else FILMS
            if is_measured:
                films, scale = write_depth_films(
                    dataset, there, camera, scratch / place, on_progress=on_progress
                )
                scales[camera] = scale
            else:
                films = write_films(
                    dataset, there, camera, scratch / place, on_progress=on_progress
                )
            views[camera] = {index: View(f"{place}/{film.name}") for index, film in films.items()}
            files |= {f"{place}/{film.name}": film for film in films.values()}
    shown = [
        _Shown(one, tuple(of_camera[one.episode.index] for of_camera in views.values()))
        for one in framed
        if all(one.episode.index in of_camera for of_camera in views.values())
    ]
    check_errors(errors, len(shown), keep_going=keep_going)
    if not shown:
        raise FormatError(
            "no episode has frames", where=str(dataset.folder), fix="record episodes first"
        )
    notes = [
        *(f"left out: {error}" for error in errors),
        *(depth_note(c, scales.get(c)) for c in cameras if c in dataset.depth_cameras),
        *_notes(dataset, every, cameras, list(longer), is_all=first is None and not errors),
    ]
    more = camera_columns(cameras)
    curves: dict[int, str] = {}
    if has_curves and scratch is not None:
        without: list[CorpusError] = []
        of_episodes, left_out = write_episode_curves(
            dataset,
            [one.framed for one in shown],
            scratch / CURVES,
            on_error=without.append,
            on_progress=on_progress,
        )
        check_errors(without, len(shown), keep_going=keep_going)
        notes += [*left_out, *(f"without curves: {error}" for error in without)]
        curves = {index: f"{CURVES}/{file.name}" for index, file in of_episodes.items()}
        files |= {curves[index]: file for index, file in of_episodes.items()}
        more += curve_columns(curves)
    tables: dict[str, Table] = {
        EPISODES: (
            (*VIDEO_COLUMNS, "episode", "task", "camera", "dataset", *more),
            list(_episodes(dataset, shown, cameras, curves)),
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
            (*VIDEO_COLUMNS, "command", *_OF_SUBTASKS, *more),
            list(_of_texts(dataset, _lasting(dataset, shown, (SUBTASK,), notes), cameras, curves)),
        ),
        MOMENTS: (
            (*VIDEO_COLUMNS, "command", *_OF_SUBTASKS, *more),
            list(
                _of_texts(
                    dataset,
                    [
                        *_lasting(dataset, shown, (MEMORY, MOTION), notes),
                        *_events(dataset, shown, cameras[0], notes),
                    ],
                    cameras,
                    curves,
                )
            ),
        ),
    }
    return written(tables, files, notes)


def _cameras(dataset: Dataset, wanted: Sequence[str]) -> Sequence[str]:
    return choose_cameras(
        (*dataset.cameras, *dataset.image_cameras),
        wanted,
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
) -> tuple[dict[int, View], dict[int, None]]:
    """Return the parts of a camera's videos that show episodes, and the episodes with longer ones.

    Both are by the numbers of the episodes.
    """
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
    views: dict[int, View] = {}
    longer: dict[int, None] = {}
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
            longer[one.episode.index] = None
        times = looked.frame_times
        is_whole = bool(start_s - margin_s < times[0] and times[-1] < end_s - _ROUNDING_S)
        path = _linked(dataset, part.file) or os.path.relpath(part.file, folder.resolve())
        views[one.episode.index] = View(path, start_s, is_whole)
    return views, longer


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
    cameras: Sequence[str],
    longer: Sequence[int],
    *,
    is_all: bool,
) -> Iterator[str]:
    others = [c for c in (*dataset.cameras, *dataset.image_cameras) if c not in cameras]
    if others:
        yield f"cameras that aren't shown: {first_of(others)}"
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


def _episodes(
    dataset: Dataset, shown: Sequence[_Shown], cameras: Sequence[str], curves: Mapping[int, str]
) -> Iterator[Sequence[object]]:
    for one in shown:
        episode, length_s = one.framed.episode, one.framed.length_s
        path, *part = one.views[0].cells(0.0, length_s, is_part=False)
        tasks = "; ".join(episode.tasks)
        yield (
            path, episode_name(episode.index), *part,
            episode.index, tasks, cameras[0], str(dataset.folder),
            *camera_cells(one.views, cameras, 0.0, length_s, is_part=False),
            *curve_cells(episode.index, curves, 0.0),
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class _Text:
    """A text of the dataset's own, with the part of the episode in which people judge it."""

    shown: _Shown
    style: str
    content: str
    timestamp: float
    since_s: float
    until_s: float


def _lasting(
    dataset: Dataset, shown: Sequence[_Shown], styles: Collection[str], notes: list[str]
) -> Iterator[_Text]:
    """Yield the texts that last until the next one of their style.

    Those with one beginning share a part.
    """
    by_index = {one.framed.episode.index: one for one in shown}
    seen: set[int] = set()
    files = dict.fromkeys(one.framed.episode.data for one in shown)
    for index, rows in persistent_rows(dataset, files):
        one = by_index.get(index)
        if one is None or index in seen:
            continue
        seen.add(index)
        first_s, length_s = float(one.framed.frames.times[0]), one.framed.length_s
        for style in styles:
            texts = []
            for row in sorted((r for r in rows if r["style"] == style), key=_time):
                since_s = round(_time(row) - first_s, 6)
                if not 0 <= since_s < length_s or not (row["content"] or "").strip():
                    text, at = repr(row["content"])[:60], f"at {_time(row):g} s"
                    why = f"isn't shown: the episode has {length_s:g} s, and it needs a text"
                    notes.append(f"episode {index}: the {style} {text} {at} {why}")
                    continue
                texts.append((since_s, row))
            starts = [*sorted({since_s for since_s, _ in texts}), length_s]
            for since_s, row in texts:
                end_s = starts[starts.index(since_s) + 1]
                yield _Text(one, style, row["content"], _time(row), since_s, end_s)


def _events(
    dataset: Dataset, shown: Sequence[_Shown], camera: str, notes: list[str]
) -> Iterator[_Text]:
    """Yield interjections, and questions about the camera's picture with their answers."""
    by_index = {one.framed.episode.index: one for one in shown}
    drawn = 0
    for index, frame, rows in event_rows(dataset):
        one = by_index.get(index)
        if one is None or frame >= len(one.framed.frames.times):
            continue
        time = float(one.framed.frames.times[frame])
        since_s = round(time - float(one.framed.frames.times[0]), 6)
        until_s = min(since_s + EVENT_S, one.framed.length_s)
        said = {
            (row["style"], row["role"]): row["content"] or ""
            for row in rows
            if row.get("camera") in (None, camera)
        }
        answer = in_words(said.get((VQA, ASSISTANT), ""))
        question = said.get((VQA, USER), "").strip()
        texts = {INTERJECTION: said.get((INTERJECTION, USER), "").strip()}
        if question and answer:
            texts[VQA] = f"{question} – {answer}"
        drawn += bool(question and answer is None)
        for style, text in texts.items():
            if text:
                yield _Text(one, style, text, time, since_s, until_s)
    if drawn:
        notes.append(f"{drawn} answers that are drawn in the picture are not in {MOMENTS}")


def _of_texts(
    dataset: Dataset, texts: Iterable[_Text], cameras: Sequence[str], curves: Mapping[int, str]
) -> Iterator[Sequence[object]]:
    """Yield the rows of the dataset's own texts."""
    numbers: Counter[tuple[int, str]] = Counter()
    for text in texts:
        index, part_s = text.shown.framed.episode.index, (text.since_s, text.until_s)
        numbers[index, text.style] += 1
        path, *part = text.shown.views[0].cells(*part_s, is_part=True)
        name = f"{episode_name(index)}-{text.style}-{numbers[index, text.style]:02d}"
        yield (
            path, name, *part, text.content, index, text.style, text.timestamp, cameras[0],
            str(dataset.folder),
            *camera_cells(text.shown.views, cameras, *part_s, is_part=True),
            *curve_cells(index, curves, text.since_s),
        )  # fmt: skip


def _time(row: Row) -> float:
    return float(row["timestamp"])
