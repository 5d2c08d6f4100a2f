"""The episodes of a LeRobot dataset, as its metadata have them.

Version 2 has a file for each episode and its metadata in JSON lines. Version 3 has several
episodes one after the other in a file, and Parquet metadata with the part of each
(https://huggingface.co/docs/lerobot/lerobot-dataset-v3). What these layouts leave open may be
missing. Numbers of another type are converted where that changes none, and else refused with file,
row and column.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import msgspec

from corpus_tools.lerobot.dataset_files import (
    Record,
    check_is_file,
    damaged,
    file_inside,
    files_below,
    filled_in,
    json_lines,
    parquet_file,
)
from g3.errors import FormatError

INFO = "meta/info.json"
EPISODES_JSONL, EPISODES_FOLDER = "meta/episodes.jsonl", "meta/episodes"
OLD, NEW = "v2.1", "v3.0"
READ = ("v2.0", OLD, NEW)
VIDEO, IMAGE = "video", "image"
CHUNKS_SIZE = 1000
"""Number of episodes in a folder, where the metadata give none."""
FASTEST = 10_000.0
"""Frames a second."""
ROWS_AT_ONCE = 256
"""Rows of metadata read at once: a row has the statistics of all features, too."""

PATHS = {
    True: (
        "data/chunk-{episode_chunk:03d}/episode_{episode_index:06d}.parquet",
        "videos/chunk-{episode_chunk:03d}/{video_key}/episode_{episode_index:06d}.mp4",
    ),
    False: (
        "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
        "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4",
    ),
}
"""The patterns of paths of data and of videos where none are given, of version 2 and of 3."""


class Info(msgspec.Struct, frozen=True):
    """The fields of ``meta/info.json`` that this program needs."""

    codebase_version: str
    fps: float
    features: dict[str, dict[str, Any]]
    data_path: str | None = None
    video_path: str | None = None
    chunks_size: int | None = None
    total_episodes: Any = None


@dataclass(frozen=True, slots=True)
class VideoPart:
    """The part of a video file that shows an episode, in seconds from the file's first frame."""

    file: Path
    start_s: float
    end_s: float | None
    """End according to the metadata; None in version 2, where a file is an episode's."""


@dataclass(frozen=True, slots=True)
class Episode:
    """An episode, as the metadata have it."""

    index: int
    frames: int
    tasks: tuple[str, ...]
    """Tasks that aren't blank."""
    data: Path
    """The file with its frames."""
    record: Record
    """Its row of the metadata."""
    videos: Mapping[str, VideoPart] = field(default_factory=dict)
    """By camera."""

    def error(self, what: str) -> FormatError:
        """Return the error that something is wrong with it, with its row in the metadata."""
        return damaged(
            f"{self.record.file}, row {self.record.row}", f"episode {self.index}: {what}"
        )


@dataclass(frozen=True, slots=True)
class Dataset:
    """A dataset's folder, resolved, and the content of its ``meta/info.json``."""

    folder: Path
    info: Info

    @property
    def is_old(self) -> bool:
        """True for version 2, which has a file for each episode."""
        return self.info.codebase_version != NEW

    @property
    def cameras(self) -> tuple[str, ...]:
        """The features that are videos."""
        return self._features_of(VIDEO)

    @property
    def image_cameras(self) -> tuple[str, ...]:
        """The features that are images, a file or a cell for each frame."""
        return self._features_of(IMAGE)

    @property
    def depth_cameras(self) -> frozenset[str]:
        """The features whose pixels are distances."""
        return frozenset(
            name for name, feature in self.info.features.items() if _is_depth_map(feature)
        )

    @property
    def pictures(self) -> Mapping[str, tuple[int, int] | None]:
        """The cameras, with the width and height of their pictures where the metadata have them."""
        cameras = (*self.cameras, *self.image_cameras)
        return {name: _size(self.info.features[name]) for name in cameras}

    def _features_of(self, dtype: str) -> tuple[str, ...]:
        features = self.info.features.items()
        return tuple(name for name, feature in features if feature.get("dtype") == dtype)

    def episodes(self, cameras: Sequence[str] | None = None) -> Iterator[Episode]:
        """Yield the episodes in the order of the metadata, some at a time.

        Parameters
        ----------
        cameras
            The cameras whose videos are named; all if None.
        """
        shown = self.cameras if cameras is None else cameras
        rows = json_lines(self.folder / EPISODES_JSONL) if self.is_old else _new_rows(self, shown)
        seen: dict[int, Record] = {}
        files = _Files(self)
        for record in rows:
            episode = _episode(self, record, shown, files)
            first = seen.setdefault(episode.index, record)
            if first is not record:
                what = f"episode {episode.index} is also in {first.file.name}, row {first.row}"
                raise record.error("episode_index", what)
            yield episode


def _size(feature: Mapping[str, Any]) -> tuple[int, int] | None:
    """Return the width and height of a camera's pictures: the channels are first or last."""
    shape = feature.get("shape")
    if not isinstance(shape, list) or len(shape) != 3 or not all(isinstance(n, int) for n in shape):
        return None
    names = feature.get("names")
    first = names[0] if isinstance(names, list) and names else ""
    is_first = first in ("channel", "channels", "c") or (shape[0] <= 4 < shape[2])
    height, width = shape[1:] if is_first else shape[:2]
    return width, height


def _is_depth_map(feature: Mapping[str, Any]) -> bool:
    """Return True for a feature that is marked so, by LeRobot's current name or its former one."""
    places = [feature, feature.get("info"), feature.get("video_info")]
    return any(
        bool(one.get(name))
        for one in places
        if isinstance(one, dict)
        for name in ("is_depth_map", "video.is_depth_map")
    )


def open_dataset(folder: Path) -> Dataset:
    """Read a dataset's ``meta/info.json``."""
    folder = folder.resolve()
    file = file_inside(folder, INFO, where=str(folder))
    if not file.exists():
        raise FormatError(
            f"this is no LeRobot dataset: there is no {INFO}",
            where=str(folder),
            fix="name the folder that holds meta, data and videos, or a hub's by --repo-id",
        )
    check_is_file(file)
    try:
        # In two steps: what Info has no field for is checked, too.
        info = msgspec.convert(msgspec.json.decode(file.read_bytes()), Info)
    except (OSError, msgspec.MsgspecError, ValueError, RecursionError) as error:
        raise damaged(file, f"the file can't be read: {error}") from error
    if info.codebase_version not in READ:
        raise FormatError(
            f"the dataset's version is {info.codebase_version}, this program reads "
            f"{', '.join(READ)}",
            where=str(file),
            fix="convert it with LeRobot's own converter",
        )
    if not 0 < info.fps <= FASTEST:
        raise FormatError(
            f"fps is {info.fps}", where=str(file), fix="give the frames a second of its recording"
        )
    if info.chunks_size is not None and info.chunks_size < 1:
        raise FormatError(
            f"chunks_size is {info.chunks_size}", where=str(file), fix="give the files of a chunk"
        )
    return Dataset(folder, info)


def data_files(dataset: Dataset) -> list[Path]:
    """Return the files with frames, in their order."""
    return files_below(dataset.folder, "data")


def _new_rows(dataset: Dataset, cameras: Sequence[str]) -> Iterator[Record]:
    files = files_below(dataset.folder, EPISODES_FOLDER)
    if not files:
        raise damaged(dataset.folder / EPISODES_FOLDER, "there are no episodes")
    wanted = ["episode_index", "length", "tasks", *_OF_DATA]
    wanted += [f"videos/{camera}/{name}" for camera in cameras for name in _OF_VIDEO]
    for file in files:
        row = 0
        with parquet_file(file) as parquet:
            columns = [name for name in wanted if name in parquet.schema_arrow.names]
            # All columns are read: what is damaged is named now, and not when a copy is written.
            for batch in parquet.iter_batches(ROWS_AT_ONCE):
                for values in batch.select(columns).to_pylist():
                    row += 1
                    yield Record(file, row, values)


_OF_DATA = ("data/chunk_index", "data/file_index")
_OF_VIDEO = ("chunk_index", "file_index", "from_timestamp", "to_timestamp")


def _episode(dataset: Dataset, record: Record, cameras: Sequence[str], files: _Files) -> Episode:
    info = dataset.info
    index, frames = record.whole("episode_index"), record.whole("length")
    tasks = tuple(text for text in record.texts("tasks") if text.strip())
    videos = {}
    if dataset.is_old:
        names = {
            "episode_chunk": index // (info.chunks_size or CHUNKS_SIZE),
            "episode_index": index,
        }
        for camera in cameras:
            file = files.of("video_path", names | {"video_key": camera})
            videos[camera] = VideoPart(file, 0.0, None)
    else:
        chunk, number = (record.whole(column) for column in _OF_DATA)
        names = {"chunk_index": chunk, "file_index": number}
        for camera in cameras if frames else ():
            columns = [f"videos/{camera}/{name}" for name in _OF_VIDEO]
            part = [record.whole(column) for column in columns[:2]]
            start_s, end_s = (record.seconds(column) for column in columns[2:])
            of_part = dict(zip(names, part, strict=True)) | {"video_key": camera}
            videos[camera] = VideoPart(files.of("video_path", of_part), start_s, end_s)
    return Episode(index, frames, tasks, files.of("data_path", names), record, videos)


class _Files:
    """Files of data and of videos, each checked once, as most of them hold many episodes."""

    def __init__(self, dataset: Dataset) -> None:
        self._dataset = dataset
        self._checked: dict[tuple[int | str, ...], Path] = {}
        self._folders: set[Path] = set()

    def of(self, kind: str, names: Mapping[str, int | str]) -> Path:
        """Return a file, by the given pattern, else by the usual one."""
        key = (kind, *names.values())
        if key not in self._checked:
            dataset = self._dataset
            usual = dict(zip(("data_path", "video_path"), PATHS[dataset.is_old], strict=True))
            pattern = getattr(dataset.info, kind) or usual[kind]
            where = f"{dataset.folder / INFO}, {kind}"
            name = filled_in(pattern, names, where=where)
            inside = file_inside(dataset.folder, name, where=where, checked=self._folders)
            self._checked[key] = inside
        return self._checked[key]
