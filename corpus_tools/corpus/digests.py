"""The digests of corpus.json, by which damage to any file of a corpus is found.

They are over the records, not over the bytes: other line ends or another indentation change
nothing, and every other change is found.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping

import msgspec

from corpus_tools.corpus.corpus_records import (
    MANIFEST,
    SCHEMA_VERSION,
    TRAJECTORIES,
    Manifest,
)
from corpus_tools.corpus.encoding import Tables, content_hash
from corpus_tools.corpus.trajectory_arrays import Arrays
from g3.errors import FormatError


def sealed(manifest: Manifest, tables: Tables) -> Manifest:
    """Return a manifest with the hash, the counts and the digests of the tables."""
    counted = msgspec.structs.replace(
        manifest,
        schema_version=SCHEMA_VERSION,
        hash=content_hash(tables),
        counts=tables.counts(),
    )
    return msgspec.structs.replace(counted, digests=_digests(counted, tables))


def problems(manifest: Manifest, tables: Tables, folder: str) -> Iterator[FormatError]:
    """Yield an error for each difference between corpus and manifest; errors name `folder`."""
    accept = f"accept the change with: ct corpus seal {folder}"
    counted = msgspec.structs.asdict(tables.counts())
    for name, promised in msgspec.structs.asdict(manifest.counts).items():
        if counted[name] != promised:
            yield FormatError(
                f"{promised} {name} are promised, {counted[name]} are there",
                where=f"{folder}/{MANIFEST}: counts.{name}",
                fix=f"restore the file, or {accept}",
            )
    expected = _digests(manifest, tables) if manifest.schema_version == SCHEMA_VERSION else {}
    for name in sorted(expected.keys() | manifest.digests.keys()):
        if manifest.digests.get(name) != expected.get(name):
            yield FormatError(
                f"the content is not what was written: its digest differs from {MANIFEST}'s",
                where=f"{folder}/{name}",
                fix=f"restore the file, or {accept}",
            )
    if manifest.hash != content_hash(tables):
        yield FormatError(
            "the content is not what was written: its hash differs",
            where=f"{folder}/{MANIFEST}: hash",
            fix=f"restore the files, or {accept}",
        )


def is_as_written(manifest: Manifest, found: Mapping[str, str], arrays: Arrays) -> bool:
    """Check that files are byte by byte those that a manifest was written with.

    `found` has for the name of each JSONL file the digest of its bytes.
    """
    whole = {MANIFEST: _of_manifest(manifest), TRAJECTORIES: _of_arrays(arrays)}
    digests = {**found, **{name: _digest(parts) for name, parts in whole.items()}}
    return manifest.schema_version == SCHEMA_VERSION and manifest.digests == digests


def _of_manifest(manifest: Manifest) -> list[bytes]:
    return [msgspec.json.encode(msgspec.structs.replace(manifest, digests={}))]


def _of_arrays(arrays: Arrays) -> list[bytes]:
    return [
        part
        for name, array in arrays.items()
        for part in (f"{name} {array.shape}\n".encode(), array.tobytes())
    ]


def _digests(manifest: Manifest, tables: Tables) -> dict[str, str]:
    contents = {
        MANIFEST: _of_manifest(manifest),
        **{name: [content] for name, content in tables.lines().items()},
        TRAJECTORIES: _of_arrays(tables.trajectories),
    }
    return {name: _digest(parts) for name, parts in contents.items()}


def _digest(parts: list[bytes]) -> str:
    digest = hashlib.sha256()
    for part in parts:
        digest.update(part)
    return f"sha256:{digest.hexdigest()}"
