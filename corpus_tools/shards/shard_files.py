"""Shards on disk: features of some examples as a Parquet file, and the manifest of a folder."""

from __future__ import annotations

import hashlib
import io
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np
import numpy.typing as npt

from corpus_tools.runtime.parquet import import_pyarrow
from g3.errors import FormatError
from g3.features.feature_registry import CATALOGUE_VERSION
from g3.features.matrix import FeatureSpace
from g3.short_repr import short_repr
from g3.storage import regular_file
from g3.storage.atomic_file import write_bytes

MANIFEST = "shards.json"
FORMAT_VERSION = 2
NAMES = b"g3"
ORIGIN = b"g3.origin"
DIGEST = b"g3.digest"
"""Keys of a file's metadata, whose values are `_Names` and an `Origin` as JSON, and the digest of
these and of all arrays."""
AGAIN = "make the shards again with: ct shards"


@short_repr
@dataclass(frozen=True, slots=True)
class Shard:
    """Examples, with those of equal features as one row and their number."""

    bases: tuple[str, ...]
    words: tuple[str, ...]
    """Names of base features and words (:class:`g3.features.matrix.FeatureSpace`)."""
    keys: npt.NDArray[np.int64]
    """The features, sorted: base index times the number of words plus word index, shape (k,)."""
    features: npt.NDArray[np.int32]
    """Those of each row, one row after the other, as indices into the keys."""
    offsets: npt.NDArray[np.int32]
    """Row i has ``features[offsets[i]:offsets[i + 1]]``, shape (n + 1,)."""
    right: npt.NDArray[np.int32]
    wrong: npt.NDArray[np.int32]
    """Numbers of examples of a row with φ true, and false, shape (n,)."""

    @property
    def space(self) -> FeatureSpace:
        """The features."""
        return FeatureSpace((), self.bases, self.words, self.keys)


class _Names(msgspec.Struct, frozen=True):
    bases: tuple[str, ...]
    words: tuple[str, ...]
    keys: list[int]


class Origin(msgspec.Struct, frozen=True):
    """Input and options of a shard; two shards of the same origin are the same."""

    corpus: str
    """The corpus's hash."""
    first: int
    examples: int
    """Number of the first one of its examples in the corpus, and their count."""
    catalogue_version: int
    sets: tuple[str, ...]
    """The features."""
    negatives: str
    seed: int
    """Arguments of :func:`corpus_tools.corpus.labelled_corpus.labelled_examples`."""


class ShardRecord(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A file of the folder: its numbers of examples and of different rows, and its digest."""

    file: str
    examples: int
    rows: int
    digest: str


class Manifest(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Content of a folder of shards."""

    format_version: int
    catalogue_version: int
    """:data:`g3.features.feature_registry.CATALOGUE_VERSION`."""
    sets: tuple[str, ...]
    ablated: tuple[str, ...]
    added: tuple[str, ...]
    """Feature sets left out of the default sets, and added to them."""
    negatives: str
    seed: int
    """Arguments of :func:`corpus_tools.corpus.labelled_corpus.labelled_examples`."""
    corpora: dict[str, str]
    """Hashes of the corpora by the names that they were given with."""
    sources: dict[str, int]
    """Number of examples of each source."""
    scenarios: tuple[str, ...]
    """:func:`corpus_tools.corpus.labelled_corpus.scenario_ids`."""
    shards: tuple[ShardRecord, ...]
    digest: str = ""
    """Digest of all other fields."""

    @property
    def examples(self) -> int:
        """Number of examples in all shards."""
        return sum(shard.examples for shard in self.shards)


def write_shard(path: Path, shard: Shard, origin: Origin) -> str:
    """Write a shard, and return its digest; the same one gives the same bytes."""
    pa, pq = import_pyarrow()
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
    with pq.ParquetWriter(content, table.schema, **settings) as writer:
        writer.write_table(table)
        digest = _digest(shard, origin)
        about = {NAMES: msgspec.json.encode(names), ORIGIN: msgspec.json.encode(origin)}
        writer.add_key_value_metadata(about | {DIGEST: digest.encode()})
    write_bytes(path, content.getvalue())
    return digest


def _digest(shard: Shard, origin: Origin) -> str:
    digest = hashlib.sha256(msgspec.json.encode((shard.bases, shard.words, origin)))
    for array in (shard.keys, shard.features, shard.offsets, shard.right, shard.wrong):
        digest.update(f"{array.shape}".encode())
        digest.update(array.tobytes())
    return f"sha256:{digest.hexdigest()}"


def known_shard(path: Path, origin: Origin) -> tuple[int, str] | None:
    """Return rows and digest of an origin's shard; None if it is missing or damaged."""
    try:
        shard, stored, digest = _read(path)
    except FormatError:
        return None
    return (len(shard.right), digest) if stored == origin else None


def read_shard(path: Path, digest: str = "") -> Shard:
    """Read a shard, which must have the digest that is given, if that is known.

    FormatError if it isn't there, isn't one, is damaged or is another one.
    """
    shard, _, stored = _read(path)
    if digest and stored != digest:
        raise FormatError(
            f"this is not the shard that {MANIFEST} names: its digest differs",
            where=str(path),
            fix=AGAIN,
        )
    return shard


def _read(path: Path) -> tuple[Shard, Origin, str]:
    """Read a shard, its origin, and its digest, which is checked."""
    _, pq = import_pyarrow()
    try:
        with pq.ParquetFile(io.BytesIO(regular_file.read_bytes(path))) as file:
            about = file.metadata.metadata
            names = msgspec.json.decode(about[NAMES], type=_Names)
            origin = msgspec.json.decode(about[ORIGIN], type=Origin)
            table = file.read()
        features = table["features"].combine_chunks()
        shard = Shard(
            names.bases,
            names.words,
            np.array(names.keys, dtype=np.int64),
            features.values.to_numpy(),
            features.offsets.to_numpy(),
            table["right"].to_numpy(),
            table["wrong"].to_numpy(),
        )
        digest = about.get(DIGEST, b"").decode()
        what = "its digest differs" if digest != _digest(shard, origin) else ""
    except Exception as error:  # a damaged file can raise anything
        what = " ".join(str(error).split()) or type(error).__name__
    if what:
        raise FormatError(f"this shard can't be read: {what}", where=str(path), fix=AGAIN)
    return shard, origin, digest


def write_manifest(folder: Path, manifest: Manifest) -> Manifest:
    """Write a folder's manifest, with its digest; the folder is complete when this is there."""
    sealed = msgspec.structs.replace(manifest, digest=_manifest_digest(manifest))
    content = msgspec.json.format(msgspec.json.encode(sealed), indent=1)
    write_bytes(folder / MANIFEST, content + b"\n")
    return sealed


def read_manifest(folder: Path) -> Manifest:
    """Read the manifest of a folder of shards.

    FormatError if it isn't one, or was made by another version of the program.
    """
    path = folder / MANIFEST
    try:
        manifest = msgspec.json.decode(regular_file.read_bytes(path), type=Manifest)
    except OSError as error:
        raise FormatError(
            "there are no shards, or they aren't complete", where=str(path), fix=AGAIN
        ) from error
    except (msgspec.MsgspecError, UnicodeDecodeError, RecursionError) as error:
        raise FormatError(str(error), where=str(path), fix=AGAIN) from error
    versions = (manifest.format_version, manifest.catalogue_version)
    if versions != (FORMAT_VERSION, CATALOGUE_VERSION):
        raise FormatError("another version of ct made them", where=str(path), fix=AGAIN)
    if manifest.digest != _manifest_digest(manifest):
        raise FormatError(
            "the content is not what was written: its digest differs",
            where=f"{path}: digest",
            fix=AGAIN,
        )
    return manifest


def _manifest_digest(manifest: Manifest) -> str:
    rest = msgspec.structs.replace(manifest, digest="")
    return f"sha256:{hashlib.sha256(msgspec.json.encode(rest, order='sorted')).hexdigest()}"
