"""Shards on disk: features of some examples as a file of arrays, and the manifest of a folder."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np
import numpy.typing as npt

from g3.errors import FormatError
from g3.features.feature_registry import CATALOGUE_VERSION
from g3.features.matrix import FeatureSpace
from g3.short_repr import short_repr
from g3.storage import regular_file
from g3.storage.array_file import DIGEST, Field, digest_of, read_arrays, write_arrays
from g3.storage.atomic_file import write_bytes

MANIFEST = "shards.json"
FORMAT_VERSION = 3
_ORIGIN = "origin"
_FIELDS = {
    "bases": Field("U"),
    "words": Field("U"),
    "keys": Field("<i8"),
    "features": Field("<i4"),
    "offsets": Field("<i4"),
    "right": Field("<i4"),
    "wrong": Field("<i4"),
}
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


def write_shard(path: Path, shard: Shard, origin: Origin, *, compressed: bool = True) -> str:
    """Write a shard, and return its digest; the same one gives the same bytes."""
    arrays = {name: np.array(getattr(shard, name), f.dtype) for name, f in _FIELDS.items()}
    arrays[_ORIGIN] = np.frombuffer(msgspec.json.encode(origin), dtype=np.uint8)
    digest = digest_of(arrays)
    write_bytes(path, write_arrays({DIGEST: digest, **arrays}, compressed=compressed))
    return _named(digest)


def _named(digest: npt.NDArray[np.uint8]) -> str:
    return f"sha256:{digest.tobytes().hex()}"


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
    fields, where = {**_FIELDS, _ORIGIN: Field("|u1")}, str(path)
    arrays = read_arrays(path, fields, where=where, fix=AGAIN, error=FormatError)
    try:
        digest = _named(arrays.pop(DIGEST))
        origin = msgspec.json.decode(arrays.pop(_ORIGIN).tobytes(), type=Origin)
    except (KeyError, msgspec.MsgspecError) as error:
        raise FormatError(f"this is no shard: {error}", where=where, fix=AGAIN) from error
    bases, words = (tuple(arrays.pop(name).tolist()) for name in ("bases", "words"))
    return Shard(bases, words, **arrays), origin, digest


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
