"""From corpora to shards: many corpora at once, each in pieces of bounded size."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path

import numpy as np

import g3.features  # noqa: F401  (fills the catalogue)
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.labelled_corpus import Negatives, Options, labelled_examples, scenario_ids
from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.runtime.parallel import Workers, work
from corpus_tools.runtime.progress import OnProgress, no_progress
from corpus_tools.shards import shard_files
from g3.errors import CorpusError, FormatError
from g3.features.feature_registry import CATALOGUE_VERSION, select
from g3.learning.examples import Example
from g3.learning.factor_matrix import features_of_examples
from g3.storage.only_writer import only_writer
from g3.storage.system_errors import named_error

EXAMPLES = 20_000
"""Number of examples in one shard, which bounds the memory."""
SHARD_FILE = re.compile(r"\.?\d{5,}-\d{5,}\.npz(\.new-\w+)?")
"""A shard, or the remains of one by a killed process."""
PORTIONS = 8
"""For a cluster, whose size isn't known, into how many portions few corpora are divided."""


@dataclass(frozen=True, slots=True)
class Portion:
    """Every `of`-th shard of a corpus, from this number on."""

    corpus: str
    order: int
    number: int
    of: int


@dataclass(frozen=True, slots=True)
class _Made:
    hash: str
    sources: Counter[str]
    scenarios: set[str]
    shards: list[shard_files.ShardRecord]


def write_shards(
    corpora: Sequence[str],
    out: Path,
    options: Options,
    *,
    workers: Workers,
    size: int = EXAMPLES,
    on_progress: OnProgress = no_progress,
) -> tuple[shard_files.Manifest, list[str]]:
    """Write the features of corpora into a folder; each worker holds one corpus at a time.

    `corpora` are names or folders. `out` is a new folder, an empty one, or one that was left
    unfinished: its shards are kept if they are what would be made. A shard has at most `size`
    examples. Returns what the folder holds, and why corpora were left out, a line each. CorpusError
    if nothing could be read, the folder has other things in it, or another program is writing to
    it.
    """
    out.mkdir(parents=True, exist_ok=True)
    with only_writer(out.absolute()):
        _names_of_sets(options)  # an unknown name is an error before anything is read
        if not all(SHARD_FILE.fullmatch(path.name) for path in out.iterdir()):
            raise FormatError("this folder isn't empty", where=str(out), fix="name a new folder")
        portion_count = PORTIONS if workers.scheduler else workers.jobs
        of = -(-portion_count // len(corpora))
        portions = [Portion(name, i, k, of) for i, name in enumerate(corpora) for k in range(of)]
        make = partial(_write_portion, out=out.absolute(), options=options, size=size)
        made: dict[Portion, _Made] = {}
        failures: dict[str, Exception] = {}
        for done in work(make, portions, workers):
            if done.result is not None:
                made[done.item] = done.result
            elif done.error is not None:
                failures[done.item.corpus] = done.error
            on_progress("making shards", len(made) + len(failures), len(portions))
        whole = [made[p] for p in portions if p in made and p.corpus not in failures]
        if not whole:
            raise next(iter(failures.values()))
        hashes = {p.corpus: made[p].hash for p in portions if p.corpus not in failures}
        sources = sum((m.sources for m in whole), Counter())
        scenarios = set().union(*(m.scenarios for m in whole))
        shards = [shard for m in whole for shard in m.shards]
        manifest = manifest_of(hashes, sources, scenarios, shards, options)
        for path in {*out.iterdir()} - {out / shard.file for shard in manifest.shards}:
            path.unlink()
        return shard_files.write_manifest(out, manifest), [
            _line(name, error) for name, error in failures.items()
        ]


def manifest_of(
    hashes: dict[str, str],
    sources: Counter[str],
    scenarios: Iterable[str],
    shards: Iterable[shard_files.ShardRecord],
    options: Options,
) -> shard_files.Manifest:
    """Return the manifest of a folder of these shards.

    `hashes` are those of the corpora by their names; `sources` counts the examples of each source;
    `scenarios` are those of all examples.
    """
    return shard_files.Manifest(
        format_version=shard_files.FORMAT_VERSION,
        catalogue_version=CATALOGUE_VERSION,
        sets=_names_of_sets(options),
        ablated=options.ablated,
        added=options.added,
        negatives=options.negatives,
        seed=options.seed,
        corpora=hashes,
        sources=dict(sorted(sources.items())),
        scenarios=tuple(sorted(scenarios)),
        shards=tuple(sorted(shards, key=lambda s: s.file)),
    )


def _names_of_sets(options: Options) -> tuple[str, ...]:
    return tuple(s.name for s in select(without=options.ablated, plus=options.added))


def _line(corpus: str, error: Exception) -> str:
    if isinstance(error, OSError):
        error = named_error(error) or error
    if isinstance(error, CorpusError):
        return f"{corpus}: left out: {error}"
    return f"{corpus}: left out: {type(error).__name__}: {error}"


def write_scratch_shards(
    corpus: Corpus, items: Sequence[Example], out: Path, options: Options, *, size: int
) -> shard_files.Manifest:
    """Write the features of a corpus's examples, at most `size` a shard, for one training."""
    portion = Portion(corpus.name, 0, 0, 1)
    made = _write(portion, items, out, options, corpus_hash=corpus.hash, size=size, kept=False)
    return manifest_of(
        {corpus.name: corpus.hash}, made.sources, made.scenarios, made.shards, options
    )


def _write_portion(portion: Portion, *, out: Path, options: Options, size: int) -> _Made:
    digest, items = _examples(portion.corpus, options.negatives, options.seed)
    return _write(portion, items, out, options, corpus_hash=digest, size=size, kept=True)


def _write(
    portion: Portion,
    items: Sequence[Example],
    out: Path,
    options: Options,
    *,
    corpus_hash: str,
    size: int,
    kept: bool,
) -> _Made:
    """Write a portion's shards; those that are `kept` take time to become small."""
    made = _Made(corpus_hash, Counter(), set(), [])
    sets = _names_of_sets(options)
    for first in range(portion.number * size, len(items), portion.of * size):
        part = items[first : first + size]
        made.sources.update(e.source for e in part)
        made.scenarios.update(scenario_ids(part))
        path = out / f"{portion.order:05}-{first // size:05}.npz"
        features = (CATALOGUE_VERSION, sets, options.negatives, options.seed)
        origin = shard_files.Origin(corpus_hash, first, len(part), *features)
        count = shard_files.known_shard(path, origin) if kept else None
        if count is None:
            shard = to_shard(part, options)
            digest = shard_files.write_shard(path, shard, origin, compressed=kept)
            count = len(shard.right), digest
        made.shards.append(shard_files.ShardRecord(path.name, len(part), *count))
    return made


@lru_cache(maxsize=1)
def _examples(corpus: str, negatives: Negatives, seed: int) -> tuple[str, list[Example]]:
    opened = open_corpus(corpus)
    return opened.hash, labelled_examples(opened, negatives=negatives, seed=seed)


def to_shard(items: Sequence[Example], options: Options) -> shard_files.Shard:
    """Return the features of examples.

    Examples with the same words and groundings are merged before their features are computed,
    rows with the same features after. The likelihood of the rows with their counts is exactly
    that of the examples.
    """
    first: dict[tuple[object, ...], int] = {}
    place = np.array([first.setdefault(_inputs(e), len(first)) for e in items], dtype=np.intp)
    different = [items[i] for i in np.unique(place, return_index=True)[1]]
    sets = select(without=options.ablated, plus=options.added)
    space, matrix = features_of_examples(different, sets)
    features = matrix.indices.astype(np.int32)
    number: dict[bytes, int] = {}
    row = np.array(
        [
            number.setdefault(features[begin:end].tobytes(), len(number))
            for begin, end in zip(matrix.indptr[:-1], matrix.indptr[1:], strict=True)
        ],
        dtype=np.intp,
    )
    kept = matrix[np.unique(row, return_index=True)[1]]
    correct = np.array([e.correct for e in items], dtype=bool)
    right, wrong = (
        np.bincount(row[place][chosen], minlength=len(number)).astype(np.int32)
        for chosen in (correct, ~correct)
    )
    return shard_files.Shard(
        space.bases,
        space.words,
        space.keys,
        kept.indices.astype(np.int32),
        kept.indptr.astype(np.int32),
        right,
        wrong,
    )


def _inputs(example: Example) -> tuple[object, ...]:
    """Return all inputs of an example's features."""
    return (
        example.sdc.type,
        id(example.annotation.context),
        *(tuple(map(id, getattr(example, r))) for r in ("figure", "landmark", "theme", "goal")),
        tuple(example.words.values()),
    )
