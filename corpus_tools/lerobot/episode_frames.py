"""The frames of a dataset's episodes: their times and their tasks.

:func:`checked_episodes` compares them with the metadata, before an episode is shown to anybody.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path

import numpy as np
import numpy.typing as npt

from corpus_tools.lerobot.dataset_files import (
    numbers_of,
    parquet_file,
    rows_of_size,
    whole_numbers_of,
)
from corpus_tools.lerobot.episode_reading import Dataset, Episode
from corpus_tools.lerobot.language_rows import check_language
from corpus_tools.lerobot.task_tables import TASK_INDEX, task_table
from corpus_tools.runtime.progress import OnProgress, no_progress
from g3.errors import CorpusError

EPISODE_INDEX, TIMESTAMP = "episode_index", "timestamp"
FRAMES_AT_ONCE = 4096
MOST_UNNAMED = 10_000
"""Numbers of tasks in frames beyond those of the table of tasks."""

Seconds = npt.NDArray[np.float64]
OnError = Callable[[CorpusError], None]


@dataclass(frozen=True, slots=True)
class EpisodeFrames:
    """The frames of an episode."""

    times: Seconds
    """The times of the frames as the data have them, shape (n,), seconds, ascending."""
    tasks: tuple[int, ...]
    """The numbers of the tasks, in the order in which they come."""


@dataclass(frozen=True, slots=True)
class FramedEpisode:
    """An episode with its frames."""

    episode: Episode
    frames: EpisodeFrames
    length_s: float
    """From the first frame to the end of the last one."""


def frames_of(file: Path, *, is_thorough: bool = False) -> dict[int, EpisodeFrames]:
    """Read the frames in a file, by the numbers of their episodes.

    Parameters
    ----------
    is_thorough
        True to read all columns, to find damaged ones.
    """
    times: dict[int, list[Seconds]] = {}
    tasks: dict[int, dict[int, None]] = {}
    row = 0
    with parquet_file(file) as parquet:
        names = parquet.schema_arrow.names
        check_language(parquet.schema_arrow, file)
        columns = [n for n in (EPISODE_INDEX, TIMESTAMP, TASK_INDEX) if n in names]
        rows, read = FRAMES_AT_ONCE, None if is_thorough else columns
        if is_thorough:  # pictures may be among the columns
            rows = rows_of_size(parquet, rows)
        for batch in parquet.iter_batches(rows, columns=read):
            episodes = whole_numbers_of(batch, EPISODE_INDEX, file, row)
            stamps = numbers_of(batch, TIMESTAMP, file, row)
            numbers = (
                whole_numbers_of(batch, TASK_INDEX, file, row) if TASK_INDEX in names else None
            )
            for index in np.unique(episodes).tolist():
                own = episodes == index
                times.setdefault(index, []).append(stamps[own])
                if numbers is not None:
                    ordered = dict.fromkeys(numbers[own].tolist())
                    tasks.setdefault(index, {}).update(ordered)
            row += len(episodes)
    return {
        index: EpisodeFrames(np.concatenate(pieces), tuple(tasks.get(index, ())))
        for index, pieces in times.items()
    }


def checked_episodes(
    dataset: Dataset,
    cameras: Sequence[str] | None = None,
    *,
    first: int | None = None,
    is_thorough: bool = False,
    on_error: OnError | None = None,
    on_progress: OnProgress = no_progress,
) -> Iterator[FramedEpisode]:
    """Yield the episodes that have frames, in the order of the metadata.

    An episode without a task in the metadata has the tasks of its frames.

    Parameters
    ----------
    cameras
        The cameras whose videos are named; all if None.
    first
        The number of episodes to take; all if None.
    is_thorough
        True to read all columns of the frames, so that a copy can be written later.
    on_error
        Called with the error of each episode that is left out; without it, the first is raised.
    on_progress
        Called after each file with frames.
    """
    texts = task_table(dataset).texts
    files: dict[Path, dict[int, EpisodeFrames]] = {}
    unreadable: set[Path] = set()
    for episode in islice(dataset.episodes(cameras), first):
        if episode.data in unreadable:
            continue  # whose error is reported
        try:
            if episode.data not in files:
                files.clear()  # episodes lie in their files one after the other
                unreadable.add(episode.data)
                files[episode.data] = frames_of(episode.data, is_thorough=is_thorough)
                unreadable.remove(episode.data)
            framed = _framed(dataset, episode, files[episode.data], texts)
        except CorpusError as error:
            if on_error is None:
                raise
            on_error(error)
            continue
        on_progress("reading episodes", episode.index + 1, 0)
        yield framed


def _framed(
    dataset: Dataset,
    episode: Episode,
    of_file: Mapping[int, EpisodeFrames],
    texts: Mapping[int, str],
) -> FramedEpisode:
    none = EpisodeFrames(np.zeros(0), ())
    frames = of_file.get(episode.index, none)
    if len(frames.times) != episode.frames:
        raise episode.error(
            f"its length is {episode.frames}, and {episode.data.name} has {len(frames.times)} "
            "frames of it"
        )
    times = frames.times
    if len(times) and (times[0] < 0 or (np.diff(times) <= 0).any()):
        raise episode.error(
            f"the times of its frames in {episode.data.name}, column {TIMESTAMP}, don't increase"
        )
    last_task = max(texts, default=-1)
    if max(frames.tasks, default=-1) > last_task + MOST_UNNAMED:
        raise episode.error(
            f"the {TASK_INDEX} of its frames in {episode.data.name} is {max(frames.tasks)}, and "
            f"the last task has the number {last_task}"
        )
    if not episode.tasks:
        tasks = tuple(t for n in frames.tasks if (t := texts.get(n, "")).strip())
        episode = replace(episode, tasks=tasks)
    return FramedEpisode(episode, frames, _length_s(times, dataset.info.fps))


def _length_s(times: Seconds, fps: float) -> float:
    """Return the seconds to the last frame's end, by the frame rate if the times agree with it."""
    if not len(times):
        return 0.0
    regular = len(times) / fps
    measured = float(times[-1] - times[0]) + 1 / fps
    return regular if abs(measured - regular) < 0.5 / fps else measured
