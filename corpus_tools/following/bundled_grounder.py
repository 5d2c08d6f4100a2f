"""The model of the bundled corpus, which follows commands."""

from __future__ import annotations

from pathlib import Path

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.decoding import read_manifest
from corpus_tools.corpus.labelled_corpus import scenario_ids
from corpus_tools.importers.authored.bundled import resolve
from corpus_tools.runtime.progress import OnProgress
from g3.errors import ModelError
from g3.features.feature_registry import CATALOGUE_VERSION
from g3.inference.training import TOLERANCE, search_sets, training_data
from g3.learning.examples import examples
from g3.learning.grounding_model import DEFAULT_L2, GroundingModel
from g3.learning.model_file import TrainingCard
from g3.storage.cache_folder import cache_folder

DEFAULT_CORPUS = "warehouse"
TRAINING_VERSION = 5
"""Version of the training, raised whenever the bundled model has to be retrained."""


def default_model(on_progress: OnProgress | None = None) -> GroundingModel:
    """Return the model of the bundled corpus; it is trained at the first call, then kept.

    It is kept where the bundled corpora are, under a name that has the corpus's hash and the
    version of the features.
    """
    model = kept_model()
    if model is not None:
        return model
    corpus = Corpus.load(resolve(DEFAULT_CORPUS))
    path = kept_at(corpus.hash)
    path.parent.mkdir(parents=True, exist_ok=True)
    following_model(corpus, on_progress=on_progress).save(path)
    return GroundingModel.load(path)


def kept_model() -> GroundingModel | None:
    """Return the model that :func:`default_model` has kept; None if there is none yet."""
    corpus_hash = read_manifest(resolve(DEFAULT_CORPUS)).hash
    try:
        return GroundingModel.load(kept_at(corpus_hash), corpus_hash=corpus_hash)
    except ModelError:
        return None


def kept_at(corpus_hash: str) -> Path:
    """Return the path of the model that was trained on a bundled corpus."""
    digest = corpus_hash.rpartition(":")[2][:16]
    return cache_folder() / f"follow{TRAINING_VERSION}-{digest}-{CATALOGUE_VERSION}"


def following_model(
    corpus: Corpus, *, l2: float = DEFAULT_L2, on_progress: OnProgress | None = None
) -> GroundingModel:
    """Train a model that follows commands on the candidates of search in a corpus's scenes."""
    data = training_data(corpus.annotations, search_sets(), on_progress=on_progress)
    card: TrainingCard = {
        "corpus_hash": corpus.hash,
        "scenarios": tuple(sorted(scenario_ids(examples(corpus.annotations)))),
        "training": {"corpus": corpus.name},
    }
    return GroundingModel(l2=l2, tolerance=TOLERANCE, card=card).fit(data)
