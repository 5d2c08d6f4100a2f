"""The episodes of a LeRobot dataset: what is where, without reading frames.

Version 2.1 has a file for each episode and its metadata in JSON lines. Version 3 has several
episodes one after the other in a file, and Parquet metadata that tell which part is whose
(https://huggingface.co/docs/lerobot/lerobot-dataset-v3).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from corpus_tools.runtime.parquet import import_pyarrow
from g3.errors import FormatError
from g3.storage import regular_file

INFO = "meta/info.json"
TASKS_JSONL, TASKS_PARQUET = "meta/tasks.jsonl", "meta/tasks.parquet"
EPISODES_JSONL, EPISODES_FOLDER = "meta/episodes.jsonl", "meta/episodes"
OLD, NEW = "v2.1", "v3.0"
READ = ("v2.0", OLD, NEW)
ROWS_AT_ONCE = 256
"""Of metadata: a row has the statistics of all features, too."""


class Info(msgspec.Struct, frozen=True):
    """What this program needs of ``meta/info.json``."""

    codebase_version: str
    fps: float
    features: dict[str, dict[str, Any]]
    data_path: str
    video_path: str | None = None
    robot_type: str | None = None
    chunks_size: int = 1000
    total_episodes: int = 0


@dataclass(frozen=True, slots=True)
class VideoPart:
    """A part of a video file, which shows an episode; times in seconds from the file's start."""

    file: Path
    start_s: float
    end_s: float


@dataclass(frozen=True, slots=True)
class Episode:
    """An episode."""

    index: int
    frames: int
    tasks: tuple[str, ...]
    data: Path
    """The file with its frames."""
    videos: Mapping[str, VideoPart]
    """By camera."""


@dataclass(frozen=True, slots=True)
class Dataset:
    """A dataset's folder, and what its ``meta/info.json`` says."""

    folder: Path
    info: Info

    @property
    def is_old(self) -> bool:
        """Whether it has a file for each episode (version 2)."""
        return self.info.codebase_version != NEW

    @property
    def cameras(self) -> tuple[str, ...]:
        """The features that are videos."""
        features = self.info.features.items()
        return tuple(name for name, feature in features if feature.get("dtype") == "video")

    def episodes(self) -> Iterator[Episode]:
        """The episodes in the order of the metadata, some at a time.

        FormatError if the metadata can't be read, or pyarrow isn't installed for those of version
        3.
        """
        return _old_episodes(self) if self.is_old else _new_episodes(self)


def open_dataset(folder: Path) -> Dataset:
    """A dataset's folder; FormatError if it is no LeRobot dataset of version 2.0, 2.1 or 3.0."""
    file = folder / INFO
    try:
        info = msgspec.json.decode(regular_file.read_bytes(file), type=Info)
    except OSError as error:
        raise FormatError(
            f"this is no LeRobot dataset: there is no {INFO}",
            where=str(folder),
            fix="name the folder that holds meta, data and videos",
        ) from error
    except msgspec.DecodeError as error:
        raise FormatError(
            f"the file can't be read: {error}", where=str(file), fix="restore the dataset"
        ) from error
    if info.codebase_version not in READ:
        raise FormatError(
            f"the dataset's version is {info.codebase_version}, this program reads "
            f"{', '.join(READ)}",
            where=str(file),
            fix="convert it with LeRobot's own converter",
        )
    if info.fps <= 0:
        raise FormatError(f"fps is {info.fps}", where=str(file), fix="say how fast it was recorded")
    return Dataset(folder, info)


def data_files(dataset: Dataset) -> list[Path]:
    """The files with frames, in their order."""
    return sorted((dataset.folder / "data").glob("*/*.parquet"))


def _old_episodes(dataset: Dataset) -> Iterator[Episode]:
    info, file = dataset.info, dataset.folder / EPISODES_JSONL
    for number, row in _json_lines(file):
        try:
            index, frames = int(row["episode_index"]), int(row["length"])
            tasks = tuple(map(str, row.get("tasks", ())))
        except (KeyError, TypeError, ValueError) as error:
            raise _damaged(file, f"line {number}: {error!r}") from error
        names = {"episode_chunk": index // info.chunks_size, "episode_index": index}
        videos = {
            camera: VideoPart(
                dataset.folder / (info.video_path or "").format(video_key=camera, **names),
                0.0,
                frames / info.fps,
            )
            for camera in dataset.cameras
        }
        data = dataset.folder / info.data_path.format(**names)
        yield Episode(index, frames, tasks, data, videos)


def _json_lines(file: Path) -> Iterator[tuple[int, dict[str, Any]]]:
    try:
        with regular_file.opened(file) as stream:
            for number, line in enumerate(stream, start=1):
                if line.strip():
                    yield number, msgspec.json.decode(line, type=dict[str, Any])
    except (OSError, msgspec.DecodeError) as error:
        raise _damaged(file, str(error)) from error


def _new_episodes(dataset: Dataset) -> Iterator[Episode]:
    pa, pq = import_pyarrow()
    info = dataset.info
    columns = ["episode_index", "length", "tasks", "data/chunk_index", "data/file_index"]
    for camera in dataset.cameras:
        columns += [f"videos/{camera}/{name}" for name in _OF_VIDEO]
    files = sorted((dataset.folder / EPISODES_FOLDER).glob("*/*.parquet"))
    if not files:
        raise _damaged(dataset.folder / EPISODES_FOLDER, "there are no episodes")
    for file in files:
        try:
            with regular_file.opened(file) as stream, pq.ParquetFile(stream) as parquet:
                missing = set(columns) - set(parquet.schema_arrow.names)
                if missing:
                    raise _damaged(file, f"there is no column {min(missing)}")
                for batch in parquet.iter_batches(ROWS_AT_ONCE, columns=columns):
                    for row in batch.to_pylist():
                        yield _new_episode(dataset.folder, info, dataset.cameras, row)
        except (OSError, pa.ArrowException) as error:
            raise _damaged(file, str(error)) from error


_OF_VIDEO = ("chunk_index", "file_index", "from_timestamp", "to_timestamp")


def _new_episode(
    folder: Path, info: Info, cameras: tuple[str, ...], row: Mapping[str, Any]
) -> Episode:
    videos = {}
    for camera in cameras:
        chunk, number, start, end = (row[f"videos/{camera}/{name}"] for name in _OF_VIDEO)
        path = (info.video_path or "").format(
            video_key=camera, chunk_index=chunk, file_index=number
        )
        videos[camera] = VideoPart(folder / path, float(start), float(end))
    data = info.data_path.format(
        chunk_index=row["data/chunk_index"], file_index=row["data/file_index"]
    )
    tasks = tuple(row["tasks"] or ())
    return Episode(int(row["episode_index"]), int(row["length"]), tasks, folder / data, videos)


def _damaged(file: Path, what: str) -> FormatError:
    return FormatError(
        f"the metadata can't be read: {what}", where=str(file), fix="restore the dataset"
    )
