"""Training on corpora larger than memory: processor time for an example, and memory.

``python -m benchmarks.shards CORPUS... --folder DIR`` makes shards of corpora, such as those of
``ct simulate-workers describe``, and trains on more and more of them. Where the corpora have
fewer examples than asked for, shards are read several times.
"""

from __future__ import annotations

import argparse
import itertools
import resource
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import msgspec

from benchmarks.timing import heading, show
from corpus_tools.corpus.labelled_corpus import Options
from corpus_tools.runtime.parallel import Workers
from corpus_tools.shards.shard_files import (
    MANIFEST,
    Manifest,
    ShardRecord,
    read_manifest,
    read_shard,
)
from corpus_tools.shards.shard_making import write_shards
from corpus_tools.shards.shard_training import TOLERANCE, fit_on_shards
from g3.learning.grounding_model import GroundingModel

T = TypeVar("T")

SIZES = (10_000, 100_000, 1_000_000, 5_000_000)
SHARD = 10_000


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.shards", description=__doc__)
    parser.add_argument("corpora", nargs="*")
    parser.add_argument("--folder", type=Path, required=True, help="where shards are, or are made")
    parser.add_argument("--sizes", type=int, nargs="*", default=SIZES, help="numbers of examples")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument(
        "--tolerance",
        type=float,
        default=TOLERANCE,
        help="of the gradient of the mean over examples (default: that of `ct train`)",
    )
    arguments = parser.parse_args()
    workers = Workers(arguments.jobs)
    if not (arguments.folder / MANIFEST).exists():
        make(arguments.corpora, arguments.folder, workers)
    manifest = read_manifest(arguments.folder)
    read_shard(arguments.folder / manifest.shards[0].file)  # which imports what reading needs
    for size in arguments.sizes:
        train(arguments.folder, manifest, size, arguments.tolerance, workers)


def make(corpora: list[str], folder: Path, workers: Workers) -> None:
    heading(f"Shards of {len(corpora)} corpora")
    seconds, (manifest, failures) = timed(
        lambda: write_shards(corpora, folder, Options(), workers=workers, size=SHARD)
    )
    print(*failures, sep="\n")
    rows = sum(shard.rows for shard in manifest.shards)
    size = sum((folder / shard.file).stat().st_size for shard in manifest.shards)
    show("examples", manifest.examples, "", f"{rows} different rows in their shards")
    show("reading and features", 1e6 * seconds / manifest.examples, "µs each")
    show("on disk", size / manifest.examples, "bytes each")
    show("peak memory", peak_mib(), "MiB")


def train(folder: Path, manifest: Manifest, size: int, tolerance: float, workers: Workers) -> None:
    shards: list[ShardRecord] = []
    for shard in itertools.cycle(manifest.shards):
        if sum(s.examples for s in shards) >= size:
            break
        shards.append(shard)
    some = msgspec.structs.replace(manifest, shards=tuple(shards))
    looks = 0
    begun = prepared = used()

    def on_progress(step: str, done: int, _: int) -> None:
        nonlocal looks, prepared
        if step == "training":
            looks = done
        else:
            prepared = used()

    heading(f"Training on {some.examples} examples in {len(shards)} shards")
    if len(shards) > len(manifest.shards):
        times = len(shards) / len(manifest.shards)
        print(f"  (every shard is read {times:.1f} times on average)")
    seconds, model = timed(
        lambda: fit_on_shards(
            GroundingModel(),
            folder,
            some,
            workers=workers,
            tolerance=tolerance * some.examples,
            on_progress=on_progress,
        )
    )
    show("rows", sum(shard.rows for shard in shards), "", f"{len(model.space_)} features")
    show("training", 1e6 * seconds / some.examples, "µs each", f"{seconds:.0f} s")
    preparation = prepared - begun
    show("  finding and packing features", 1e6 * preparation / some.examples, "µs each")
    show("  Newton's method", 1e6 * (seconds - preparation) / some.examples, "µs each")
    show("    evaluations of the objective", looks, "")
    show("peak memory", peak_mib(), "MiB")


def timed(action: Callable[[], T]) -> tuple[float, T]:
    """Processor time of this process and those that it waited for, and the result."""
    before = used()
    result = action()
    return used() - before, result


def used() -> float:
    own, children = (
        resource.getrusage(w) for w in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    )
    return own.ru_utime + own.ru_stime + children.ru_utime + children.ru_stime


def peak_mib() -> float:
    """Of the largest process so far."""
    both = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    return max(resource.getrusage(who).ru_maxrss for who in both) / 1024


if __name__ == "__main__":
    main()
