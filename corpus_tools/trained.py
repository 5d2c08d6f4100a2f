"""Models of the grounding trained on a corpus or on shards, with what is recorded of it."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from corpus_tools.bundled import open_corpus
from corpus_tools.labelled import Options, labelled_examples, scenario_ids
from corpus_tools.parallel import Workers
from corpus_tools.progress import progress_bar
from g3.crf import Optimizer
from g3.features.registry import select
from g3.model import Model, train_model


@dataclass(frozen=True, slots=True)
class Trained:
    """A model, and what it was trained on.

    Parameters
    ----------
    name
        Of the corpus or the shards, for people.
    sources
        How many examples of each source there were.
    scenarios
        :func:`corpus_tools.labelled.scenario_ids`.
    card
        What is recorded with the model.
    """

    model: Model
    name: str
    sources: Mapping[str, int]
    scenarios: tuple[str, ...]
    card: Mapping[str, object]


def from_corpus(name: str, l2: float, options: Options, optimizer: Optimizer = "newton") -> Trained:
    """Train on a corpus, in memory."""
    sets = select(without=options.ablated, plus=options.added)
    corpus = open_corpus(name)
    items = labelled_examples(corpus, negatives=options.negatives, seed=options.seed)
    model = train_model(items, sets, l2=l2, corpus_hash=corpus.hash, optimizer=optimizer)
    sources: dict[str, int] = dict(sorted(Counter(e.source for e in items).items()))
    card = {
        "corpus": corpus.name,
        "examples": sources,
        "negatives": options.negatives,
        "seed": options.seed,
        "ablated": list(options.ablated),
        "added": list(options.added),
        "optimizer": optimizer,
    }
    scenarios = tuple(sorted(scenario_ids(items)))
    return Trained(model, f"corpus {corpus.name}", sources, scenarios, card)


def from_shards(
    folder: Path, l2: float, workers: Workers, optimizer: Optimizer = "newton"
) -> Trained:
    """Train on a folder of shards."""
    from corpus_tools.shards.files import read_manifest  # noqa: PLC0415 - small case stays light
    from corpus_tools.shards.training import train_on_shards  # noqa: PLC0415 - as above

    manifest = read_manifest(folder)
    hashes = sorted(manifest.corpora.values())
    joined = f"sha256:{hashlib.sha256(' '.join(hashes).encode()).hexdigest()}"
    with progress_bar("training") as on_progress:
        model = train_on_shards(
            folder,
            manifest,
            l2=l2,
            workers=workers,
            corpus_hash=hashes[0] if len(hashes) == 1 else joined,
            optimizer=optimizer,
            on_progress=on_progress,
        )
    card = {
        "corpora": manifest.corpora,
        "examples": manifest.sources,
        "negatives": manifest.negatives,
        "seed": manifest.seed,
        "ablated": list(manifest.ablated),
        "added": list(manifest.added),
        "optimizer": optimizer,
    }
    return Trained(model, f"shards {folder}", manifest.sources, manifest.scenarios, card)
