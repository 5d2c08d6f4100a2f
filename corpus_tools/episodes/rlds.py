"""Episodes of RLDS datasets: folders that TensorFlow Datasets has written, without TensorFlow.

``dataset_info.json`` names the splits and their shards, ``features.json`` the features of a step.
A record of a shard is an episode; the values of a step's feature are those of all steps, one after
the other, under the name ``steps/FEATURE``.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import prod
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from corpus_tools.episodes.curves import EpisodeCurves, drawable, named_curves
from corpus_tools.episodes.films import RESTORE, Picture, decoded
from corpus_tools.episodes.study_tables import OnError, RecordedEpisode
from corpus_tools.episodes.tf_records import check_installed, example_of, records, values_of
from g3.errors import CorpusError, FormatError
from g3.storage import regular_file

INFO, FEATURES = "dataset_info.json", "features.json"
STEPS = "steps/"
FPS = 10.0
"""Frames a second at which episodes are shown: the format has no rate."""
MOST_JSON = 16 << 20
MOST_AXES = 4
"""Largest number of axes of a tensor that is drawn."""
LANGUAGE = re.compile(r"(?:(?:natural_)?language_)?instruction(?:_\d+)?|language|task")
"""Last names of features with texts of the task."""
_DRAWN = re.compile(r"(?:action|observation)(?:[_/].*)?")
"""Names of features that are drawn as curves, if they are numbers."""
_FIX = "name the folder that holds dataset_info.json, features.json and the shards"
_TEMPLATE = "{DATASET}-{SPLIT}.{FILEFORMAT}-{SHARD_X_OF_Y}"


class Split(msgspec.Struct, frozen=True, rename="camel"):
    """A split, as ``dataset_info.json`` has it."""

    name: str
    shard_lengths: tuple[int | str, ...] = ()
    filepath_template: str = _TEMPLATE


class Info(msgspec.Struct, frozen=True, rename="camel"):
    """The fields of ``dataset_info.json`` that this program needs."""

    name: str
    splits: tuple[Split, ...] = ()
    file_format: str = "tfrecord"


@dataclass(frozen=True, slots=True)
class Feature:
    """A feature of a step."""

    name: str
    """Such as ``observation/image``."""
    kind: str
    """``image``, ``text`` or ``tensor``."""
    is_depth: bool = False
    numbers: int = 0
    """How many numbers a step has of it, if it is a tensor of such with a constant size."""


@dataclass(frozen=True, slots=True)
class Shard:
    """A file, and the numbers of its episodes in the whole dataset."""

    file: Path
    episodes: range


@dataclass(frozen=True, slots=True)
class Steps:
    """A dataset's folder, its shards, and the features of its steps."""

    path: Path
    info: Info
    shards: tuple[Shard, ...]
    features: tuple[Feature, ...]
    fps: float | None = None
    """Frames a second at which it was recorded, if they are known."""
    without_cameras: str = "take a dataset whose steps have images"
    other_cameras: frozenset[str] = frozenset()

    @property
    def cameras(self) -> tuple[str, ...]:
        """The features that are images."""
        return tuple(feature.name for feature in self.features if feature.kind == "image")

    @property
    def depth_cameras(self) -> frozenset[str]:
        """The features whose pixels are distances."""
        return frozenset(feature.name for feature in self.features if feature.is_depth)

    @property
    def texts(self) -> tuple[str, ...]:
        """The features with texts of the task."""
        names = (feature.name for feature in self.features if feature.kind == "text")
        return tuple(n for n in names if LANGUAGE.fullmatch(n.rpartition("/")[2]))

    @property
    def notes(self) -> tuple[str, ...]:
        """A note, if the frame rate isn't known."""
        note = f"RLDS has no frame rate: the videos have {FPS:g} frames a second (change it: --fps)"
        return () if self.fps else (note,)

    def examples(self, on_error: OnError) -> Iterator[tuple[int, str, Any]]:
        """Yield the number, the place and the content of each episode.

        The rest of a damaged shard can't be read; `on_error` gets its error.
        """
        for shard in self.shards:
            seen, count = 0, len(shard.episodes)
            try:
                for content in records(shard.file):
                    source = f"{shard.file.name}, record {seen}"
                    if seen < count:
                        try:
                            example = example_of(content, f"{self.path}, {source}")
                            yield shard.episodes[seen], source, example
                        except CorpusError as error:
                            on_error(error)
                    seen += 1
                if seen != count:
                    what = f"the shard has {seen} records, and {INFO} has {count} of it"
                    raise FormatError(what, where=str(shard.file), fix=RESTORE)
            except CorpusError as error:
                on_error(error)

    def episodes(self, cameras: Sequence[str], on_error: OnError) -> Iterator[RecordedEpisode]:
        """Yield the episodes in the order of splits and shards."""
        for index, source, example in self.examples(on_error):
            where = f"{self.path}, {source}"
            texts = [t for name in self.texts for t in values_of(example, f"{STEPS}{name}")]
            try:
                tasks = tuple(t for text in dict.fromkeys(texts) if (t := text_of(text, where)))
            except CorpusError as error:
                on_error(error)
                continue
            pictures = {
                camera: _pictures(values, f"{where}, {camera}")
                for camera in cameras
                if (values := values_of(example, f"{STEPS}{camera}"))
            }
            curves = partial(self._curves, example, where)
            yield RecordedEpisode(index, source, tasks, self.fps or FPS, pictures, curves=curves)

    def _curves(self, example: Any, where: str, frames: int) -> EpisodeCurves | None:
        """Return actions and observations that are numbers; each step is a frame."""
        named = sorted(
            (not feature.name.startswith("action"), feature.name, feature.numbers)
            for feature in self.features
            if _DRAWN.fullmatch(feature.name)
        )
        widths = drawable((name, numbers) for _, name, numbers in named)
        columns = []
        for name, width in widths.items():
            values = values_of(example, f"{STEPS}{name}")
            if len(values) != frames * width or not all(isinstance(v, int | float) for v in values):
                what = f"{len(values)} values are no {width} numbers for each of {frames} steps"
                raise FormatError(what, where=f"{where}, {name}", fix=RESTORE)
            with np.errstate(over="ignore"):
                columns.append(np.array(values, np.float64).astype(np.float32).reshape(-1, width))
        if not columns:
            return None
        curves = [curve for name, width in widths.items() for curve in named_curves(name, width)]
        pieces = iter([np.concatenate(columns, axis=1)])
        return EpisodeCurves(curves, self.fps or FPS, frames, pieces)


def open_steps(path: Path, *, fps: float | None = None) -> Steps:
    """Read a dataset's metadata.

    Parameters
    ----------
    path
        The folder with ``dataset_info.json``, or one above it that holds a single such folder.
    fps
        Frames a second at which the dataset was recorded.
    """
    check_installed()
    folder = _folder(path.resolve())
    info = _read(folder / INFO, Info)
    if info.file_format != "tfrecord":
        raise FormatError(
            f"the records are {info.file_format[:40]}, and only tfrecord is read",
            where=str(folder / INFO),
            fix="convert the dataset: tfds convert_format --file_format=tfrecord",
        )
    shards: list[Shard] = []
    first = 0
    for split in info.splits:
        for place, length in enumerate(split.shard_lengths):
            count = _count(length, folder / INFO)
            file = folder / _shard_name(info, split, place, folder)
            shards.append(Shard(file, range(first, first + count)))
            first += count
    try:
        features = tuple(_features(_read(folder / FEATURES, dict[str, Any]), "", folder / FEATURES))
    except RecursionError as error:
        what = "features are in features without end"
        raise FormatError(what, where=str(folder / FEATURES), fix=RESTORE) from error
    steps = [f for f in features if f.name.startswith(STEPS)]
    if not steps:
        what = "there are no steps: this is no RLDS dataset"
        raise FormatError(what, where=str(folder / FEATURES), fix=_FIX)
    named = tuple(replace(f, name=f.name[len(STEPS) :]) for f in steps)
    return Steps(folder, info, tuple(shards), named, fps)


def _folder(path: Path) -> Path:
    places = [path, *sorted(path.glob("*")), *sorted(path.glob("*/*"))] if path.is_dir() else []
    found = [place for place in places if (place / INFO).is_file()]
    if len(found) == 1 or path in found:
        return found[0]
    if not found:
        raise FormatError(f"there is no {INFO}", where=str(path), fix=_FIX)
    names = ", ".join(str(place) for place in found[:8])
    raise FormatError("there are several datasets", where=str(path), fix=f"name one: {names}")


def _read(file: Path, kind: Any) -> Any:
    try:
        # In two steps: fields that `kind` doesn't have are checked, too.
        content = msgspec.json.decode(regular_file.read_bytes(file, most=MOST_JSON))
        return msgspec.convert(content, kind, strict=False)
    except (OSError, msgspec.MsgspecError, ValueError, RecursionError) as error:
        what = f"the file can't be read: {error}"
        raise FormatError(what, where=str(file), fix=RESTORE) from error


def _count(length: int | str, file: Path) -> int:
    """Return the length of a shard; JSON of protobuf has such numbers as texts."""
    if re.fullmatch(r"\d{1,9}", str(length)):
        return int(length)
    raise FormatError(f"shardLengths has {length!r:.40}", where=str(file), fix=RESTORE)


def _shard_name(info: Info, split: Split, place: int, folder: Path) -> str:
    shards = len(split.shard_lengths)
    names = {
        "DATASET": info.name,
        "SPLIT": split.name,
        "FILEFORMAT": info.file_format,
        "SHARD_INDEX": f"{place:05d}",
        "NUM_SHARDS": f"{shards:05d}",
        "SHARD_X_OF_Y": f"{place:05d}-of-{shards:05d}",
    }
    template = split.filepath_template or _TEMPLATE
    name = re.sub(r"\{(\w+)\}", lambda match: names.get(match[1], match[0]), template)
    if re.search(r"[/\\{}\x00-\x1f]", name) or name in ("", ".", ".."):
        what = f"{name[:200]!r} is no name of a file in the dataset's folder"
        raise FormatError(what, where=str(folder / INFO), fix=RESTORE)
    return name


def _features(node: Any, name: str, file: Path) -> Iterator[Feature]:
    """Yield the features below a node of ``features.json``, by their names in records."""
    if not isinstance(node, Mapping):
        raise FormatError(f"{name or 'the whole'} is no feature", where=str(file), fix=RESTORE)
    if isinstance(several := node.get("featuresDict"), Mapping):
        for part, child in (several.get("features") or {}).items():
            yield from _features(child, f"{name}/{part}" if name else str(part), file)
    elif isinstance(sequence := node.get("sequence"), Mapping):
        yield from _features(sequence.get("feature"), name, file)
    elif isinstance(image := node.get("image"), Mapping):
        is_depth = image.get("dtype", "uint8") != "uint8" or "depth" in name.rpartition("/")[2]
        yield Feature(name, "image", is_depth)
    else:
        tensor = node.get("tensor")
        is_text = "text" in node or (
            isinstance(tensor, Mapping) and tensor.get("dtype") in ("string", "object")
        )
        numbers = _numbers(tensor) if isinstance(tensor, Mapping) else 0
        yield Feature(name, "text" if is_text else "tensor", numbers=numbers)


def _numbers(tensor: Mapping[str, Any]) -> int:
    """Return the size of a tensor of numbers; 0 if it varies, or is encoded as something else."""
    shape = tensor.get("shape") or {}
    sizes = shape.get("dimensions", []) if isinstance(shape, Mapping) else None
    is_plain = tensor.get("encoding", "none") in ("none", "ENCODING_NONE")
    if not (re.match(r"u?int|float", str(tensor.get("dtype"))) and is_plain):
        return 0
    if not isinstance(sizes, list) or len(sizes) > MOST_AXES:
        return 0
    return prod(int(n) if re.fullmatch(r"\d{1,4}", str(n)) else 0 for n in sizes)


def text_of(value: Any, where: str) -> str:
    """Return a text of a record without spaces at its ends; a FormatError if it is none."""
    if not isinstance(value, bytes):
        raise FormatError(f"{value!r:.40} is no text", where=where, fix=RESTORE)
    try:
        return value.decode().strip()
    except UnicodeDecodeError as error:
        raise FormatError(f"the text is no UTF-8: {error}", where=where, fix=RESTORE) from error


def _pictures(values: list[Any], where: str) -> Iterator[Picture]:
    for number, value in enumerate(values):
        place = f"{where}, step {number}"
        if not isinstance(value, bytes):
            raise FormatError("this is no picture", where=place, fix=RESTORE)
        yield decoded(value, place)
