"""Shards for the time of one training: arrays as they are, which are read and written at once.

Parquet is smaller and outlives the program, but takes the package pyarrow and 120 MiB of memory.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.labelled_corpus import Options, scenario_ids
from corpus_tools.shards.shard_files import Manifest, Shard, ShardRecord
from corpus_tools.shards.shard_making import manifest_of, to_shard
from g3.errors import FormatError
from g3.learning.examples import Example
from g3.storage.array_file import Field, read_arrays, write_arrays
from g3.storage.system_errors import about

_FIELDS = {
    "bases": Field("U"),
    "words": Field("U"),
    "keys": Field("<i8"),
    "features": Field("<i4"),
    "offsets": Field("<i4"),
    "right": Field("<i4"),
    "wrong": Field("<i4"),
}


def write_scratch_shards(
    corpus: Corpus, items: Sequence[Example], out: Path, options: Options, *, size: int
) -> Manifest:
    """Write the features of a corpus's examples, at most `size` a shard, to an empty folder."""
    shards = []
    for first in range(0, len(items), size):
        part = items[first : first + size]
        shard = to_shard(part, options)
        file = f"{first // size:05}.npz"
        arrays = {n: np.array(getattr(shard, n), dtype=f.dtype) for n, f in _FIELDS.items()}
        with about(out / file):
            (out / file).write_bytes(write_arrays(arrays, compressed=False))
        shards.append(ShardRecord(file, len(part), len(shard.right), digest=""))
    sources = Counter[str](e.source for e in items)
    return manifest_of({corpus.name: corpus.hash}, sources, scenario_ids(items), shards, options)


def read_scratch_shard(path: Path, digest: str = "") -> Shard:
    """Read one of these shards, which have no digest; FormatError if it is missing or damaged."""
    found = read_arrays(path, _FIELDS, where=str(path), fix="train again", error=FormatError)
    bases, words = (tuple(found.pop(name).tolist()) for name in ("bases", "words"))
    return Shard(bases, words, **found)
