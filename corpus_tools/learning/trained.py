"""Models of the grounding trained on a corpus or on shards, with what is recorded of it."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from corpus_tools.corpus.annotated_trees import annotated_trees
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.labelled_corpus import Options, labelled_examples, scenario_ids
from corpus_tools.corpus.load_choices import load_choices_of
from corpus_tools.runtime.parallel import Workers
from corpus_tools.runtime.progress import progress_bar
from g3.features.feature_registry import select
from g3.learning.grounding_model import GroundingModel
from g3.learning.optimum import Optimizer

if TYPE_CHECKING:
    from corpus_tools.shards.shard_files import Manifest
    from g3.language.parsing.extractor import SDCExtractor


class Trained(NamedTuple):
    """A model, the corpus or the shards that it was trained on, and its examples by source."""

    model: GroundingModel
    name: str
    sources: Mapping[str, int]


def from_corpus(
    corpus: Corpus, l2: float, options: Options, optimizer: Optimizer = "newton"
) -> Trained:
    """Train on a corpus, in memory."""
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
    model.fit(items, load_choices=load_choices_of([corpus]))
    return Trained(model, f"corpus {corpus.name}", sources)


def extractor_from(corpora: Sequence[Corpus], l2: float | None = None) -> SDCExtractor:
    """Train the extractor of clauses on annotated trees; the first corpus's ways are followed."""
    from g3.language.parsing import extractor as parsing  # noqa: PLC0415 - brings spaCy
    from g3.language.parsing.training.extractor_training import prepare  # noqa: PLC0415 - as above

    first, *others = [annotated_trees(corpus) for corpus in corpora]
    items = [*first, *(item for part in others for item in part)]
    strength = parsing.DEFAULT_L2 if l2 is None else l2
    card = {
        "corpora": {corpus.name: corpus.hash for corpus in corpora},
        "commands": len(items),
        "l2": strength,
        "scenarios": sorted({item.command.scenario for item in items}),
    }
    lessons = prepare(items)
    own, besides = lessons[: len(first)], lessons[len(first) :]
    return parsing.SDCExtractor(l2=strength, card=card).fit(own, others=besides)


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
    """Which examples and features were chosen."""
    return {
        "negatives": by.negatives,
        "seed": by.seed,
        "ablated": list(by.ablated),
        "added": list(by.added),
    }
