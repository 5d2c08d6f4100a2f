"""Videos of episodes that have none: pictures, a cell or a file for each frame, and depth maps."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby, islice
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from corpus_tools.episodes.depth import (
    DepthScale,
    Metres,
    false_colours,
    measured,
    quantization,
    scale_of,
)
from corpus_tools.episodes.films import Picture, decoded, write_film
from corpus_tools.lerobot.dataset_files import (
    check_is_file,
    damaged,
    file_inside,
    parquet_file,
    whole_numbers_of,
)
from corpus_tools.lerobot.episode_frames import EPISODE_INDEX, FramedEpisode
from corpus_tools.lerobot.episode_reading import INFO, Dataset
from corpus_tools.runtime.progress import OnProgress
from corpus_tools.video.picture_file import are_distances, decoded_distances

FILES = (
    "images/{key}/episode_{episode:06d}/frame_{frame:06d}.png",
    "images/{key}/episode-{episode:06d}/frame-{frame:06d}.png",
    "images/{key}/episode-{episode:06d}/frame-{frame:06d}.tiff",
)
"""The files of pictures, as LeRobot has them in version 2 and in version 3, and of depth maps."""
ROWS_AT_ONCE = 16
_SAMPLED_FRAMES = 16
LARGEST_FILE = 256 << 20


def write_films(
    dataset: Dataset,
    episodes: Sequence[FramedEpisode],
    camera: str,
    folder: Path,
    *,
    on_progress: OnProgress,
) -> dict[int, Path]:
    """Write a video of each episode into a folder, by the numbers of the episodes."""
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


def has_distances(dataset: Dataset, one: FramedEpisode, camera: str) -> bool:
    """Return True for a depth camera whose pixels are distances that people can't see as they are.

    Others have grey or colours, which are shown unchanged.

    Parameters
    ----------
    one
        An episode with frames, which stands for all.
    """
    if camera not in dataset.depth_cameras:
        return False
    if camera in dataset.cameras:
        from corpus_tools.video.probe import probe  # noqa: PLC0415 - PyAV may be missing

        is_stated = any(name.endswith("depth_max") for name in _info(dataset, camera))
        return is_stated or not probe(one.episode.videos[camera].file).is_playable
    cells = (c for c in _cells(one.episode.data, camera) if c.episode == one.episode.index)
    return are_distances(_content(dataset, camera, next(cells)))


def write_depth_films(
    dataset: Dataset,
    episodes: Sequence[FramedEpisode],
    camera: str,
    folder: Path,
    *,
    on_progress: OnProgress,
) -> tuple[dict[int, Path], DepthScale]:
    """Write a video in false colours of each episode's depth maps, all on one scale.

    Returns
    -------
    tuple
        The videos by the numbers of the episodes, and the scale, which is that of the first one.
    """
    of_episodes = _of_videos if camera in dataset.cameras else _of_pictures
    every = max(episodes[0].episode.frames // _SAMPLED_FRAMES, 1)
    _, _, first_maps = next(of_episodes(dataset, episodes[:1], camera))
    scale = scale_of(metres for metres, _ in islice(first_maps, 0, None, every))
    films: dict[int, Path] = {}
    for index, rate, maps in of_episodes(dataset, episodes, camera):
        films[index] = folder / f"episode-{index:06d}.mp4"
        pictures = (false_colours(metres, scale, where) for metres, where in maps)
        write_film(pictures, films[index], rate, f"{camera}, episode {index}")
        on_progress("making videos of depth maps", len(films), len(episodes))
    return films, scale


_Maps: TypeAlias = Iterator[tuple[Metres, str]]
"""The depth maps of an episode, each with its place."""
_OfEpisode: TypeAlias = tuple[int, float, _Maps]
"""The number of an episode, its frames a second, and its depth maps."""


def _of_pictures(
    dataset: Dataset, episodes: Sequence[FramedEpisode], camera: str
) -> Iterator[_OfEpisode]:
    unit = _info(dataset, camera).get("depth_unit")
    wanted = {one.episode.index for one in episodes}
    seen: set[int] = set()
    for file in dict.fromkeys(one.episode.data for one in episodes):
        for index, cells in groupby(_cells(file, camera), key=lambda cell: cell.episode):
            if index in wanted - seen:
                seen.add(index)
                contents = ((_content(dataset, camera, cell), cell.where) for cell in cells)
                maps = (
                    (measured(decoded_distances(content, where=where), unit), where)
                    for content, where in contents
                )
                yield index, dataset.info.fps, maps


def _of_videos(
    dataset: Dataset, episodes: Sequence[FramedEpisode], camera: str
) -> Iterator[_OfEpisode]:
    from corpus_tools.video.cutting import frames, span  # noqa: PLC0415 - PyAV may be missing
    from corpus_tools.video.probe import probe  # noqa: PLC0415 - as above

    grey = quantization(_info(dataset, camera), f"{dataset.folder / INFO}, {camera}")
    for one in episodes:
        part = one.episode.videos[camera]
        info = probe(part.file)
        start_s = part.start_s + float(one.frames.times[0])
        shown = frames(part.file, info, span(info, start_s, start_s + one.length_s))
        maps = ((grey.metres(*_grey(frame)), str(part.file)) for frame in shown)
        yield one.episode.index, info.fps, maps


def _grey(frame: Any) -> tuple[npt.NDArray[np.unsignedinteger[Any]], int]:
    """Return the brightness of a frame's pixels, and the largest that there may be."""
    bits = frame.format.components[0].bits
    kind = np.dtype(np.uint8 if bits <= 8 else ">u2" if frame.format.is_big_endian else "<u2")
    plane = frame.planes[0]
    rows: npt.NDArray[Any] = np.frombuffer(plane, kind)
    rows = rows.reshape(plane.height, plane.line_size // kind.itemsize)
    return rows[:, : frame.width], int(2**bits - 1)


def _info(dataset: Dataset, camera: str) -> Mapping[str, Any]:
    """Return what the metadata say of a camera's pictures."""
    feature = dataset.info.features[camera]
    both = (feature.get(name) for name in ("video_info", "info"))
    return {name: value for one in both if isinstance(one, Mapping) for name, value in one.items()}


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
