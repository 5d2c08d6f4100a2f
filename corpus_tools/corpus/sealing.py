"""Accepting changes that were made to a corpus by hand."""

from __future__ import annotations

from pathlib import Path

from corpus_tools.corpus.corpus_reading import read_content, read_manifest, refuse
from corpus_tools.corpus.corpus_records import MANIFEST, Manifest
from corpus_tools.corpus.corpus_writing import manifest_to_bytes
from corpus_tools.corpus.digests import sealed
from g3.storage.atomic_file import write_bytes


def seal(folder: Path) -> tuple[Manifest, Manifest]:
    """Write the hash, counts and digests of what a corpus holds now into its corpus.json.

    Returns the manifest as it was, and as it is now. If anything else is wrong with the corpus,
    that is a FormatError, and nothing is written.
    """
    before = read_manifest(folder)
    _, tables = read_content(folder, before, refuse)
    after = sealed(before, tables)
    write_bytes(folder / MANIFEST, manifest_to_bytes(after))
    return before, after
