"""A grounding model on disk: ``NAME.npz`` holds the arrays, ``NAME.json`` says what they mean.

A model that can't be saved is of little use, so its file belongs to the model. All that it needs of
the world outside is a path. Both files are written so that nobody reads half a model.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import TypedDict

import msgspec
import numpy as np
import numpy.typing as npt

from g3 import __version__
from g3.errors import ModelError
from g3.estimator import read_bytes
from g3.features.feature_registry import CATALOGUE_VERSION, FEATURES, catalogue
from g3.features.matrix import FeatureSpace
from g3.groundings import FloatArray
from g3.language.similarity.learned_lexicon import Lexicon, NamingCounts, likeness_identity
from g3.learning.load_choice import PARAMETERS, LoadChooser
from g3.storage.array_file import Field, read_arrays, write_arrays
from g3.storage.atomic_file import write_bytes
from g3.storage.only_writer import only_writer

SCHEMA_VERSION = 2
FIELDS = {"keys": Field("<i8"), "weights": Field("<f8", finite=True)}
RETRAIN = "train the model again"
RESTORE = f"restore both files of the model, or {RETRAIN}"
NAMED = "give the name that 'ct train g3 --out' was given; a model is a .npz and a .json"


class TrainingCard(TypedDict, total=False):
    """Facts about a model's training, as :class:`ModelCard` describes them."""

    corpus_hash: str
    scenarios: tuple[str, ...]
    training: Mapping[str, object]


class LoadCard(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A model's knowledge of the loads that commands are about.

    Parameters
    ----------
    features, weights
        Names of parameters (:mod:`g3.learning.load_choice`), and the value of each.
    lexicon
        What was counted of words and labels, by corpus.
    likeness
        What measured how alike words and labels are.
    unrelated
        How probably a command of somebody unknown has nothing to do with what was done.
    """

    features: tuple[str, ...]
    weights: tuple[float, ...]
    lexicon: dict[str, NamingCounts]
    likeness: str
    unrelated: float


class ModelCard(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Content of the JSON file.

    Parameters
    ----------
    schema_version
        Version of this form.
    program
        Version of the program that trained the model.
    catalogue_version
        Version of the features' catalogue that it was trained with.
    corpus_hash
        Hash of the corpus that it was trained on.
    l2
        Strength of the regularisation.
    features
        Number of features.
    arrays
        ``sha256:`` and the digest of the other file.
    sets, bases, words
        Names in the feature space (:class:`g3.features.matrix.FeatureSpace`).
    data
        What identifies the data that feature sets read (WordNet, a tag table), by the name of the
        set.
    scenarios
        The scenarios that it was trained on, which it can't be tested on
        (:func:`corpus_tools.corpus.labelled_corpus.scenario_ids`).
    training
        What else is known of the training, for people.
    loads
        What it knows of the loads that commands are about; unset if it was trained without
        outcomes.
    digest
        ``sha256:`` and the digest of all other fields, and so of both files.
    """

    schema_version: int
    program: str
    catalogue_version: int
    corpus_hash: str
    l2: float
    features: int
    arrays: str
    sets: tuple[str, ...]
    bases: tuple[str, ...]
    words: tuple[str, ...]
    data: dict[str, str] = {}
    scenarios: tuple[str, ...] = ()
    training: dict[str, object] = {}
    loads: LoadCard | msgspec.UnsetType = msgspec.UNSET
    digest: str = ""


def model_files(path: Path | str) -> tuple[Path, Path]:
    """Return the two files of a model, named with either suffix or with none: arrays and card."""
    path = Path(path)
    stem = path.name.removesuffix(".npz").removesuffix(".json")
    return path.with_name(f"{stem}.npz"), path.with_name(f"{stem}.json")


def write_model(
    path: Path | str,
    space: FeatureSpace,
    weights: FloatArray,
    *,
    l2: float,
    about: TrainingCard,
    chooser: LoadChooser | None = None,
) -> None:
    """Write what :meth:`g3.learning.grounding_model.GroundingModel.save` keeps."""
    arrays_path, card_path = model_files(path)
    arrays = write_arrays({"keys": space.keys, "weights": weights})
    card = ModelCard(
        schema_version=SCHEMA_VERSION,
        program=__version__,
        catalogue_version=CATALOGUE_VERSION,
        corpus_hash=about.get("corpus_hash", ""),
        l2=l2,
        features=len(space),
        arrays=_digest(arrays),
        sets=space.sets,
        bases=space.bases,
        words=space.words,
        data={s.name: s.data() for s in catalogue() if s.name in space.sets and s.data is not None},
        scenarios=about.get("scenarios", ()),
        training=dict(about.get("training", {})),
        loads=msgspec.UNSET if chooser is None else _load_card(chooser),
    )
    card = msgspec.structs.replace(card, digest=card_digest(card))
    content = msgspec.json.format(msgspec.json.encode(card), indent=1) + b"\n"
    with only_writer(arrays_path):  # or the card of one would stand by the arrays of another
        write_bytes(arrays_path, arrays)
        write_bytes(card_path, content)


def read_model(
    path: Path | str, *, corpus_hash: str | None = None
) -> tuple[ModelCard, FeatureSpace, FloatArray]:
    """Read what :meth:`g3.learning.grounding_model.GroundingModel.load` needs."""
    arrays_path, card_path = model_files(path)
    card = read_card(path)
    if corpus_hash is not None and card.corpus_hash != corpus_hash:
        raise ModelError(
            f"it was trained on another corpus ({card.corpus_hash or 'unnamed'})",
            where=f"{card_path}: corpus_hash",
            fix=f"{RETRAIN} on the corpus {corpus_hash}",
        )
    keys, weights = _read_arrays(arrays_path, card)
    return card, FeatureSpace(card.sets, card.bases, card.words, keys), weights


def chooser_of(card: ModelCard) -> LoadChooser | None:
    """Return the load chooser in a model's file."""
    if isinstance(card.loads, msgspec.UnsetType):
        return None
    stored = card.loads
    return LoadChooser(Lexicon(stored.lexicon), np.array(stored.weights), stored.unrelated)


def _load_card(chooser: LoadChooser) -> LoadCard:
    weights = tuple(chooser.weights.tolist())
    corpora = dict(chooser.lexicon.corpora)
    return LoadCard(PARAMETERS, weights, corpora, likeness_identity(), chooser.unrelated)


def _check_loads(loads: LoadCard, where: str) -> None:
    """Refuse what was learned of loads with other features or measures than there are here."""
    if (loads.features, len(loads.weights)) != (PARAMETERS, len(PARAMETERS)):
        needed = ", ".join(loads.features)
        raise ModelError(f"it needs other features of loads: {needed}", where=where, fix=RETRAIN)
    if loads.likeness != likeness_identity():
        raise ModelError(
            f"words were compared by {loads.likeness} in training, here by {likeness_identity()}",
            where=where,
            fix=f"install what it was trained with (embeddings are an extra), or {RETRAIN}",
        )


def read_card(path: Path | str) -> ModelCard:
    """Read what a model's JSON file holds.

    Raises
    ------
    ModelError
        If it is missing or damaged, or needs other features or other data than there are.
    """
    card_path = model_files(path)[1]
    content = read_bytes(card_path, fix=NAMED)
    try:
        version = msgspec.json.decode(content, type=dict[str, msgspec.Raw]).get("schema_version")
        if version is None or bytes(version) != str(SCHEMA_VERSION).encode():
            found_version = "none" if version is None else bytes(version).decode(errors="replace")
            raise ModelError(
                f"the file's version is {found_version}, this program reads {SCHEMA_VERSION}",
                where=f"{card_path}: schema_version",
                fix=f"{RETRAIN}, or use the program's version that wrote it",
            )
        card = msgspec.json.decode(content, type=ModelCard)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise ModelError(
            f"the file is damaged: {error}", where=str(card_path), fix=RETRAIN
        ) from error
    if card.digest != card_digest(card):
        raise _damaged(
            card_path, "the content is not what was written: its digest differs", "digest"
        )
    if card.catalogue_version != CATALOGUE_VERSION:
        raise ModelError(
            f"it needs version {card.catalogue_version} of the features, "
            f"this program has {CATALOGUE_VERSION}",
            where=f"{card_path}: catalogue_version",
            fix=RETRAIN,
        )
    if card.loads:
        _check_loads(card.loads, f"{card_path}: loads")
    more, where = f"install what registers it, or {RETRAIN}", f"{card_path}: sets"
    for name in sorted(set(card.sets) - set(FEATURES)):
        raise ModelError.unknown("feature set", name, (), where=where, more=more)
    _check_data(card, card_path)
    return card


def card_digest(card: ModelCard) -> str:
    """Return the digest of a card without its own digest, independent of indentation."""
    rest = msgspec.structs.replace(card, digest="")
    return _digest(msgspec.json.encode(rest, order="sorted"))


def _check_data(card: ModelCard, path: Path) -> None:
    """Refuse a model whose feature sets would read other data than it was trained with."""
    for feature in catalogue():
        if feature.name not in card.sets or feature.data is None:
            continue
        where = f"{path}: sets: {feature.name}"
        try:
            data = feature.data()
        except ModelError as error:
            raise ModelError(
                f"it needs data that are missing here: {error.what}",
                where=where,
                fix=f"{error.fix}; or {RETRAIN} with --ablate {feature.name}",
            ) from error
        if data != card.data.get(feature.name, data):
            raise ModelError(
                "it was trained with other data than are there now",
                where=where,
                fix=f"set CT_WORDNET, CT_TAGS and CT_VECTORS as they were, or {RETRAIN}",
            )


def _read_arrays(path: Path, card: ModelCard) -> tuple[npt.NDArray[np.int64], FloatArray]:
    content = read_bytes(path, fix=NAMED)
    if _digest(content) != card.arrays:
        raise _damaged(path, "the content is not what was written with the JSON file")
    arrays = read_arrays(content, FIELDS, where=str(path), fix=RESTORE, error=ModelError)
    keys, weights = arrays["keys"], arrays["weights"]
    for name, array in arrays.items():
        if array.shape != (card.features,):
            raise _damaged(
                path, f"the array has the shape {array.shape}, expected ({card.features},)", name
            )
    products = len(card.bases) * len(card.words)
    if np.any(keys[1:] <= keys[:-1]) or np.any((keys < 0) | (keys >= products)):
        raise _damaged(path, "they are not ascending products of the bases and words", "keys")
    return keys, weights


def _digest(content: bytes) -> str:
    return f"sha256:{hashlib.sha256(content).hexdigest()}"


def _damaged(path: Path, what: str, field: str = "") -> ModelError:
    return ModelError(what, where=f"{path}: {field}" if field else str(path), fix=RESTORE)
