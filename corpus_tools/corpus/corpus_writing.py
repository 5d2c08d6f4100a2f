"""Writing a corpus, and accepting changes that were made to it by hand."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import msgspec

from corpus_tools.corpus import corpus_records as records
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.corpus_reading import read_content, read_manifest, refuse
from corpus_tools.corpus.digests import sealed
from corpus_tools.corpus.encoding import encode
from corpus_tools.corpus.trajectory_arrays import to_bytes
from corpus_tools.runtime.atomic_folder import check_target, write_folder
from g3.storage.atomic_file import write_bytes


def write_corpus(
    corpus: Corpus,
    path: Path | str,
    *,
    force: bool = False,
    attachments: Mapping[str, bytes] | None = None,
) -> None:
    """Write a corpus: the whole folder or, on any error, nothing.

    Parameters
    ----------
    path
        The folder; its parent must be there.
    attachments
        Further files by name, such as an import's report.

    Raises
    ------
    FormatError
        If the folder holds something already and `force` isn't given, or holds
        something that is not a corpus.
    """
    files = {**corpus_files(corpus), **(attachments or {})}
    write_folder(Path(path), files, force=force, marker=records.MANIFEST)


def check_writable(path: Path | str, *, force: bool = False) -> None:
    """Raise the errors of :func:`write_corpus` before any work is done."""
    check_target(Path(path), force=force, marker=records.MANIFEST)


def corpus_files(corpus: Corpus) -> dict[str, bytes]:
    """Return the files' contents by name, the same for the same corpus."""
    tables = encode(corpus)
    manifest = records.Manifest(
        schema_version=records.SCHEMA_VERSION,
        name=corpus.name,
        source=corpus.source,
        licence=corpus.licence,
        hash="",
        counts=tables.counts(),
    )
    return {
        records.MANIFEST: manifest_to_bytes(sealed(manifest, tables)),
        **tables.lines(),
        records.TRAJECTORIES: to_bytes(tables.trajectories),
    }


def manifest_to_bytes(manifest: records.Manifest) -> bytes:
    """Return the content of corpus.json."""
    return msgspec.json.format(msgspec.json.encode(manifest), indent=2) + b"\n"


def seal(folder: Path) -> tuple[records.Manifest, records.Manifest]:
    """Write the hash, counts and digests of a corpus's present content into its corpus.json.

    Returns the manifest as it was, and as it is now. If anything else is wrong with the corpus,
    that is a FormatError, and nothing is written.
    """
    before = read_manifest(folder)
    _, tables = read_content(folder, before, refuse)
    after = sealed(before, tables)
    write_bytes(folder / records.MANIFEST, manifest_to_bytes(after))
    return before, after
