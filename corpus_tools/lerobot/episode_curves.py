"""A robot's state and action in each episode, as curves beside its video."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby, pairwise
from operator import itemgetter
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from corpus_tools.episodes.curves import MOST_NUMBERS, named_curves
from corpus_tools.lerobot.dataset_files import (
    content_of,
    damaged,
    parquet_file,
    rows_of_size,
    whole_numbers_of,
)
from corpus_tools.lerobot.episode_frames import (
    EPISODE_INDEX,
    FRAMES_AT_ONCE,
    FramedEpisode,
    OnError,
)
from corpus_tools.lerobot.episode_reading import Dataset
from corpus_tools.runtime.parquet import import_pyarrow
from corpus_tools.runtime.progress import OnProgress
from corpus_tools.tables.curve_file import LONGEST_NAME, SUFFIX, Values, write_curves
from g3.errors import CorpusError

FEATURES = ("observation.state", "action")
MOST_APART = 100
"""Largest mean time between the frames of an episode, in frames of the dataset's rate."""

_Piece: TypeAlias = tuple[int, Values]
"""An episode's number, and some of its frames, shape (n, curves)."""


def write_episode_curves(
    dataset: Dataset,
    episodes: Sequence[FramedEpisode],
    folder: Path,
    *,
    on_error: OnError,
    on_progress: OnProgress,
) -> tuple[dict[int, Path], list[str]]:
    """Write a file of curves for each episode, some frames at a time.

    Returns
    -------
    tuple
        The files by the numbers of the episodes, and notes on features that aren't drawn. Frames
        that come at another rate than the dataset's are shown at that rate.
    """
    wanted = {one.episode.index: one for one in episodes}
    notes: dict[str, None] = {}
    curves: dict[str, int] = {}
    written: dict[int, Path] = {}
    folder.mkdir(parents=True, exist_ok=True)
    for data in dict.fromkeys(one.episode.data for one in episodes):
        features = _features(data, notes)
        if not curves:
            curves = features
        if features != curves:
            on_error(damaged(data, f"{', '.join(FEATURES)} have other numbers than before"))
            continue
        named = [
            curve
            for name, count in curves.items()
            for curve in named_curves(
                name, count, _texts(dataset.info.features.get(name, {}).get("names"))
            )
        ]
        try:
            for index, pieces in groupby(_pieces(data, curves) if named else (), itemgetter(0)):
                one = wanted.get(index)
                if one is None or index in written:
                    continue
                file = folder / f"episode-{index:06d}{SUFFIX}"
                fps, samples = dataset.info.fps, _samples(one, dataset.info.fps)
                rows = _regular(one, fps, samples, (values for _, values in pieces))
                write_curves(file, named, fps, samples, rows)
                written[index] = file
                on_progress("writing curves", len(written), len(wanted))
        except CorpusError as error:
            on_error(error)
    return written, list(notes)


def _samples(one: FramedEpisode, fps: float) -> int:
    """Return the number of samples of an episode at a rate."""
    samples = max(round(one.length_s * fps), 1)
    if samples > MOST_APART * one.episode.frames:
        raise one.episode.error(f"{one.episode.frames} frames in {one.length_s:g} s are no curves")
    return samples


def _features(data: Path, notes: dict[str, None]) -> dict[str, int]:
    """Return the features of a file that can be drawn, and how many numbers a frame has of each."""
    pa, _ = import_pyarrow()
    found: dict[str, int] = {}
    with parquet_file(data) as parquet:
        rows = parquet.metadata.num_rows
        for name in FEATURES:
            if name not in parquet.schema_arrow.names or not rows:
                continue
            kind = parquet.schema_arrow.field(name).type
            is_list = _is_list(pa, kind)
            number = kind.value_type if is_list else kind
            if not (pa.types.is_integer(number) or pa.types.is_floating(number)):
                notes[f"{name} isn't drawn: its type is {kind!s:.80}"] = None
                continue
            each = _leaves(parquet, name) / rows
            if each != int(each) or not 0 < each <= MOST_NUMBERS:
                what = f"a frame has {each:g} numbers, and 1 to {MOST_NUMBERS} are drawn"
                notes[f"{name} isn't drawn: {what}"] = None
                continue
            found[name] = int(each)
    return found


def _is_list(pa: Any, kind: Any) -> bool:
    kinds = (pa.types.is_list, pa.types.is_large_list, pa.types.is_fixed_size_list)
    return any(is_kind(kind) for is_kind in kinds)


def _leaves(parquet: Any, name: str) -> int:
    """Return the number of numbers that a file has in a column."""
    groups = [parquet.metadata.row_group(n) for n in range(parquet.num_row_groups)]
    columns = (group.column(n) for group in groups for n in range(group.num_columns))
    inside = (c for c in columns if c.path_in_schema == name or _is_inside(c.path_in_schema, name))
    return sum(column.num_values for column in inside)


def _is_inside(path: str, name: str) -> bool:
    return path.startswith(f"{name}.") and path.removeprefix(f"{name}.").count(".") == 1


def _pieces(data: Path, features: Mapping[str, int]) -> Iterator[_Piece]:
    row = 0
    with parquet_file(data) as parquet:
        rows = rows_of_size(parquet, FRAMES_AT_ONCE)
        for batch in parquet.iter_batches(rows, columns=[EPISODE_INDEX, *features]):
            episodes = whole_numbers_of(batch, EPISODE_INDEX, data, row)
            columns = [_numbers(batch, name, n, data, row) for name, n in features.items()]
            values = np.concatenate(columns, axis=1)
            edges = [0, *(np.flatnonzero(np.diff(episodes)) + 1), len(episodes)]
            for first, end in pairwise(edges):
                if end > first:
                    yield int(episodes[first]), values[first:end]
            row += len(episodes)


def _numbers(batch: Any, name: str, each: int, data: Path, row: int) -> Values:
    """Return a feature's numbers, shape (n, each); NaN where there are none."""
    pa, _ = import_pyarrow()
    from pyarrow import compute  # noqa: PLC0415 - may be missing

    column = batch.column(name)
    values: Values = np.full((len(column), each), np.nan, np.float32)
    with content_of(data), np.errstate(over="ignore"):
        is_there = np.asarray(column.is_valid())
        numbers = column.drop_null()
        if _is_list(pa, column.type):
            if not (np.asarray(compute.list_value_length(numbers)) == each).all():
                where = f"{data}, rows {row + 1} to {row + len(column)}, column {name}"
                raise damaged(where, f"not all frames have {each} numbers")
            numbers = numbers.flatten()
        flat = numbers.to_numpy(zero_copy_only=False).astype(np.float32)
        values[is_there] = flat.reshape(-1, each)
    return values


def _regular(
    one: FramedEpisode, fps: float, samples: int, pieces: Iterator[Values]
) -> Iterator[Values]:
    """Yield the frames of an episode at the dataset's rate: at each moment the last one before."""
    times = one.frames.times - one.frames.times[0]
    moments = np.arange(samples) / fps
    shown = np.searchsorted(times, moments + 0.5 / fps, "left") - 1
    row = 0
    for piece in pieces:
        here: npt.NDArray[np.int64] = shown[(shown >= row) & (shown < row + len(piece))] - row
        yield piece[here]
        row += len(piece)


def _texts(names: Any) -> list[str]:
    """Return the texts of a list, or of a group of lists, as LeRobot has had them."""
    if isinstance(names, Mapping):
        values = list(names.values())
        is_numbered = values and all(isinstance(value, int) for value in values)
        names = (
            sorted(names, key=names.__getitem__)
            if is_numbered
            else [text for value in values if isinstance(value, list) for text in value]
        )
    if not isinstance(names, list) or len(names) > MOST_NUMBERS:
        return []
    texts = [" ".join(name.split())[:LONGEST_NAME] for name in names if isinstance(name, str)]
    return texts if len(texts) == len(names) and all(texts) else []
