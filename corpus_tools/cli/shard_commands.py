"""``ct shards``: the features of corpora that are larger than memory, to train on."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from corpus_tools.options import (
    FORMAT,
    NEGATIVES_SEED,
    WORKERS,
    out_folder,
    selection_options,
    tell,
)
from corpus_tools.runtime.terminal import note

if TYPE_CHECKING:
    from corpus_tools.runtime.parallel import Workers


@click.command()
@click.argument("corpora", metavar="CORPUS...", nargs=-1, required=True)
@out_folder("Folder of the shards; made if it isn't there. What was stopped there goes on.", "DIR")
@selection_options
@NEGATIVES_SEED
@WORKERS
@FORMAT
def shards(
    *,
    corpora: tuple[str, ...],
    out: Path,
    negatives: Literal["random", "hard"],
    ablate: tuple[str, ...],
    plus: tuple[str, ...],
    seed: int,
    workers: Workers,
    form: str,
) -> None:
    """Write corpora's features to files, to be trained on.

    For more examples than fit into memory: each process holds one CORPUS at a time, and training
    no more than one shard. Examples with equal features are one row with their count, which
    changes nothing in what is learned. A CORPUS that can't be read is named and left out, and the
    exit status is 2 then.

    \b
    Examples:
      ct shards warehouse simulated-1 simulated-2 --out shards --jobs 2
      ct train g3 --shards shards --jobs 2 --out g3.npz
    """
    from corpus_tools.corpus.labelled_corpus import Options
    from corpus_tools.runtime.progress import progress_bar
    from corpus_tools.shards.shard_making import write_shards

    options = Options(negatives, seed, ablate, plus)
    with progress_bar("making shards") as on_progress:
        manifest, failures = write_shards(
            corpora, out, options, workers=workers, on_progress=on_progress
        )
    rows = sum(shard.rows for shard in manifest.shards)
    record = {
        "folder": out,
        "shards": len(manifest.shards),
        "examples": manifest.examples,
        "rows": rows,
        "failed": failures,
    }
    tell(
        form,
        record,
        f"{manifest.examples} examples, {rows} different rows in their shards",
        f"wrote {len(manifest.shards)} shards into {out}",
    )
    for failure in failures:
        note(f"ct: {failure}")
    if failures:
        click.get_current_context().exit(2)
