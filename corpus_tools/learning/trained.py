"""Models of the grounding trained on a corpus or on shards, with what is recorded of it."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, NamedTuple

from corpus_tools.corpus.annotated_trees import Annotated, annotated_trees
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.labelled_corpus import Options, labelled_examples, scenario_ids
from corpus_tools.corpus.load_choices import load_choices_of
from corpus_tools.runtime.parallel import Workers
from corpus_tools.runtime.progress import progress_bar
from g3.features.feature_registry import select
from g3.learning.crf import Optimizer
from g3.learning.examples import Example
from g3.learning.grounding_model import GroundingModel
from g3.learning.load_choice import LoadChooser

if TYPE_CHECKING:
    from corpus_tools.shards.shard_files import Manifest
    from g3.language.parsing.sdc_parser import SDCParser

IN_MEMORY = 20_000
"""Number of examples whose features take 50 MiB, and four times as much during training."""
IN_A_FILE = 5_000
"""Number of examples whose features share a file, and are in memory at a time, where features are
in files."""


class Trained(NamedTuple):
    """A model, the corpus or the shards that it was trained on, and its examples by source.

    `on_disk` is true if features were kept in files meanwhile, as there are many examples.
    """

    model: GroundingModel
    name: str
    sources: Mapping[str, int]
    on_disk: bool = False


def from_corpus(
    corpus: Corpus, l2: float, options: Options, optimizer: Optimizer = "newton"
) -> Trained:
    """Train on a corpus, in memory.

    Features of more than `IN_MEMORY` examples are kept in a scratch folder as shards. The optimum
    is the same.
    """
    sets = select(without=options.ablated, plus=options.added)
    items = labelled_examples(corpus, negatives=options.negatives, seed=options.seed)
    sources: dict[str, int] = dict(sorted(Counter(e.source for e in items).items()))
    model = GroundingModel(
        l2=l2,
        features=sets,
        optimizer=optimizer,
        card={
            "corpus_hash": corpus.hash,
            "scenarios": tuple(sorted(scenario_ids(items))),
            "training": {
                "corpus": corpus.name,
                "examples": sources,
                **_chosen(options),
                "optimizer": optimizer,
            },
        },
    )
    choices = load_choices_of([corpus])
    on_disk = len(items) > IN_MEMORY
    if on_disk:
        _fit_on_disk(model, corpus, items, options)
        model.load_chooser_ = LoadChooser.fit(choices) if choices else None
    else:
        model.fit(items, load_choices=choices)
    return Trained(model, f"corpus {corpus.name}", sources, on_disk)


def _fit_on_disk(
    model: GroundingModel, corpus: Corpus, items: Sequence[Example], options: Options
) -> None:
    from corpus_tools.shards.shard_making import (  # noqa: PLC0415 - small case stays light
        write_scratch_shards,
    )
    from corpus_tools.shards.shard_training import fit_on_shards  # noqa: PLC0415 - as above

    with TemporaryDirectory(prefix="ct-shards-") as name, progress_bar("training") as on_progress:
        folder = Path(name)
        manifest = write_scratch_shards(corpus, items, folder, options, size=IN_A_FILE)
        fit_on_shards(
            model,
            folder,
            manifest,
            workers=Workers(),
            tolerance=model.tolerance,
            on_progress=on_progress,
        )


def parser_from(corpora: Sequence[Corpus], l2: float | None = None) -> SDCParser:
    """Teach the bundled parser annotated trees; the first corpus's ways are followed."""
    from g3.language.parsing import sdc_parser as parsing  # noqa: PLC0415 - slow to import

    items, first, card = _annotated(corpora, parsing.DEFAULT_L2 if l2 is None else l2)
    return parsing.SDCParser(l2=card["l2"], card=card).fit(items[:first], others=items[first:])


def _annotated(corpora: Sequence[Corpus], l2: float) -> tuple[list[Annotated], int, dict[str, Any]]:
    """Annotated commands, how many of them are the first corpus's, and notes on them."""
    parts = [annotated_trees(corpus) for corpus in corpora]
    items = [item for part in parts for item in part]
    card = {
        "corpora": {corpus.name: corpus.hash for corpus in corpora},
        "commands": len(items),
        "l2": l2,
        "scenarios": sorted({item.command.scenario for item in items}),
    }
    return items, len(parts[0]), card


def from_shards(
    folder: Path, l2: float, workers: Workers, optimizer: Optimizer = "newton"
) -> Trained:
    """Train on a folder of shards."""
    from corpus_tools.shards.shard_files import read_manifest  # noqa: PLC0415 - small case stays light
    from corpus_tools.shards.shard_training import fit_on_shards  # noqa: PLC0415 - as above

    manifest = read_manifest(folder)
    hashes = sorted(manifest.corpora.values())
    joined = f"sha256:{hashlib.sha256(' '.join(hashes).encode()).hexdigest()}"
    model = GroundingModel(
        l2=l2,
        features=manifest.sets,
        optimizer=optimizer,
        card={
            "corpus_hash": hashes[0] if len(hashes) == 1 else joined,
            "scenarios": manifest.scenarios,
            "training": {
                "corpora": manifest.corpora,
                "examples": manifest.sources,
                **_chosen(manifest),
                "optimizer": optimizer,
            },
        },
    )
    with progress_bar("training") as on_progress:
        fit_on_shards(model, folder, manifest, workers=workers, on_progress=on_progress)
    return Trained(model, f"shards {folder}", manifest.sources)


def _chosen(by: Options | Manifest) -> dict[str, object]:
    """Return the choice of examples and features."""
    return {
        "negatives": by.negatives,
        "seed": by.seed,
        "ablated": list(by.ablated),
        "added": list(by.added),
    }
