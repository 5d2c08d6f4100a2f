"""Videos of episodes whose frames are pictures, a cell or a file for each."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any

from corpus_tools.episodes.films import Picture, decoded, write_film
from corpus_tools.lerobot.dataset_files import (
    check_is_file,
    damaged,
    file_inside,
    parquet_file,
    whole_numbers_of,
)
from corpus_tools.lerobot.episode_frames import EPISODE_INDEX, FramedEpisode
from corpus_tools.lerobot.episode_reading import Dataset
from corpus_tools.runtime.progress import OnProgress

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
