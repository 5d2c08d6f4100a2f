"""Shards on disk: features of some examples as a Parquet file, and what a folder of them holds."""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

from corpus_tools.atomic_file import write_bytes
from g3.errors import CorpusError, FormatError
from g3.features.registry import CATALOGUE_VERSION

MANIFEST = "shards.json"
FORMAT_VERSION = 1
NAMES = b"g3"
ORIGIN = b"g3.origin"
"""Keys of a file's metadata, whose values are `_Names` and an `Origin` as JSON."""


@dataclass(frozen=True, slots=True)
class Shard:
    """Examples with equal features are one row, with how many of them there are.

    Parameters
    ----------
    bases, words
        Names of base features and words (:class:`g3.features.matrix.FeatureSpace`).
    keys
        The features, sorted: base index times the number of words plus word index, shape (k,).
    features
        Those of each row, one row after the other, as indices into the keys.
    offsets
        Row i has ``features[offsets[i]:offsets[i + 1]]``, shape (n + 1,).
    right, wrong
        How many examples of a row have φ true, and false, shape (n,).
    """

    bases: tuple[str, ...]
    words: tuple[str, ...]
    keys: npt.NDArray[np.int64]
    features: npt.NDArray[np.int32]
    offsets: npt.NDArray[np.int32]
    right: npt.NDArray[np.int32]
    wrong: npt.NDArray[np.int32]


class _Names(msgspec.Struct, frozen=True):
    bases: tuple[str, ...]
    words: tuple[str, ...]
    keys: list[int]


class Origin(msgspec.Struct, frozen=True):
    """What a shard was made of and how; two shards of the same origin are the same.

    Parameters
    ----------
    corpus
        The corpus's hash.
    first, examples
        Which of the corpus's examples: the first one's number, and how many.
    catalogue_version, sets
        The features.
    negatives, seed
        As :func:`corpus_tools.labelled.labelled_examples` takes them.
    """

    corpus: str
    first: int
    examples: int
    catalogue_version: int
    sets: tuple[str, ...]
    negatives: str
    seed: int


class ShardRecord(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A file of the folder, with how many examples and different rows it has."""

    file: str
    examples: int
    rows: int


class Manifest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What a folder of shards holds.

    Parameters
    ----------
    format_version
        Version of this form.
    catalogue_version
        :data:`g3.features.registry.CATALOGUE_VERSION`.
    sets
        Names of the feature sets.
    ablated, added
        What was left out of the default sets and added to them.
    negatives, seed
        As :func:`corpus_tools.labelled.labelled_examples` takes them.
    corpora
        Hashes of the corpora by the names that they were given with.
    sources
        How many examples there are of each source.
    scenarios
        :func:`corpus_tools.labelled.scenario_ids`.
    shards
        The files, in their order.
    """

    format_version: int
    catalogue_version: int
    sets: tuple[str, ...]
    ablated: tuple[str, ...]
    added: tuple[str, ...]
    negatives: str
    seed: int
    corpora: dict[str, str]
    sources: dict[str, int]
    scenarios: tuple[str, ...]
    shards: tuple[ShardRecord, ...]

    @property
    def examples(self) -> int:
        """How many there are in all shards."""
        return sum(shard.examples for shard in self.shards)


def pyarrow() -> Any:
    """The package with its module for Parquet.

    Raises
    ------
    CorpusError
        If it isn't installed.
    """
    try:
        import pyarrow as pa  # noqa: PLC0415 - large, and not always installed
        import pyarrow.parquet  # noqa: PLC0415 - as above
    except ImportError as error:
        raise CorpusError(
            "shards are Parquet files, and pyarrow isn't installed",
            fix="pip install 'corpus-tools-g3[parquet]'",
        ) from error
    return pa


def write_shard(path: Path, shard: Shard, origin: Origin) -> None:
    """Write a shard; the same one gives the same bytes."""
    pa = pyarrow()
    names = _Names(shard.bases, shard.words, shard.keys.tolist())
    table = pa.table(
        {
            "features": pa.ListArray.from_arrays(shard.offsets, shard.features),
            "right": shard.right,
            "wrong": shard.wrong,
        }
    )
    content = io.BytesIO()
    settings = {"compression": "zstd", "store_schema": False}
    with pa.parquet.ParquetWriter(content, table.schema, **settings) as writer:
        writer.write_table(table)
        about = {NAMES: names, ORIGIN: origin}
        writer.add_key_value_metadata({k: msgspec.json.encode(v) for k, v in about.items()})
    write_bytes(path, content.getvalue())


def known_rows(path: Path, origin: Origin) -> int | None:
    """How many rows the shard of an origin has, None if it isn't there."""
    pa = pyarrow()
    try:
        metadata = pa.parquet.read_metadata(path)
        found = msgspec.json.decode(metadata.metadata[ORIGIN], type=Origin)
    except (OSError, pa.ArrowException, KeyError, TypeError, msgspec.MsgspecError):
        return None
    return int(metadata.num_rows) if found == origin else None


def read_shard(path: Path) -> Shard:
    """Read a shard.

    Raises
    ------
    FormatError
        If it isn't there or isn't one.
    """
    pa = pyarrow()
    try:
        with pa.parquet.ParquetFile(path) as file:
            names = msgspec.json.decode(file.metadata.metadata[NAMES], type=_Names)
            table = file.read()
        features = table["features"].combine_chunks()
        return Shard(
            names.bases,
            names.words,
            np.array(names.keys, dtype=np.int64),
            features.values.to_numpy(),
            features.offsets.to_numpy(),
            table["right"].to_numpy(),
            table["wrong"].to_numpy(),
        )
    except (OSError, pa.ArrowException, KeyError, TypeError, msgspec.MsgspecError) as error:
        raise FormatError(
            f"this shard can't be read: {' '.join(str(error).split())}",
            where=str(path),
            fix="make the shards again with: ct shards",
        ) from error


def write_manifest(folder: Path, manifest: Manifest) -> None:
    """Write what a folder holds; it's complete when this is there."""
    content = msgspec.json.format(msgspec.json.encode(manifest), indent=1)
    write_bytes(folder / MANIFEST, content + b"\n")


def read_manifest(folder: Path) -> Manifest:
    """Read what a folder of shards holds.

    Raises
    ------
    FormatError
        If it isn't one, or was made by another version of the program.
    """
    path = folder / MANIFEST
    again = "make the shards again with: ct shards"
    try:
        manifest = msgspec.json.decode(path.read_bytes(), type=Manifest)
    except OSError as error:
        raise FormatError(
            "there are no shards, or they aren't complete", where=str(path), fix=again
        ) from error
    except msgspec.MsgspecError as error:
        raise FormatError(str(error), where=str(path), fix=again) from error
    versions = (manifest.format_version, manifest.catalogue_version)
    if versions != (FORMAT_VERSION, CATALOGUE_VERSION):
        raise FormatError("another version of ct made them", where=str(path), fix=again)
    return manifest
