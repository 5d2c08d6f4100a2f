"""The grounding model: which features say that words and groundings correspond (section 3.2).

``GroundingModel().fit(examples)`` learns from annotations, and ``.predict_proba(examples)`` is
what Table 1 measures. `Grounder` follows commands with the same model.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import numpy.typing as npt

from g3.errors import ModelError
from g3.estimator import Estimator
from g3.features.feature_registry import FeatureSet, select
from g3.features.matrix import FeatureSpace, columns_in, prior_scale, transform
from g3.groundings import FloatArray
from g3.learning import crf
from g3.learning.crf import Optimizer
from g3.learning.examples import Example, labels, to_batch
from g3.learning.factor_matrix import FactorMatrix, matrix_of_examples
from g3.learning.load_choice import LoadChoice, LoadChooser
from g3.learning.model_file import TrainingCard, chooser_of, read_model, write_model
from g3.short_repr import short_repr

DEFAULT_L2 = 1.0


def _sets(features: Iterable[FeatureSet | str] | None) -> tuple[FeatureSet, ...]:
    """Feature sets by themselves, or by name as models use them, as the catalogue orders them."""
    if features is None:
        return select()
    by_name = {one if isinstance(one, str) else one.name: one for one in features}
    usual = {one.name: one for one in select()}
    return tuple(
        usual.get(one.name, one) if isinstance(chosen := by_name[one.name], str) else chosen
        for one in select(plus=by_name)
        if one.name in by_name
    )


def _checked(items: Sequence[Example]) -> Sequence[Example]:
    """Refuse texts, arrays of numbers and others than examples."""
    given: Iterable[object] = items if isinstance(items, Iterable) else [items]
    others = [type(one).__name__ for one in given if not isinstance(one, Example)]
    if others:
        raise ModelError(
            f"X has no examples, but {others[0]}",
            fix="make them of a corpus: examples(corpus.annotations), of g3.learning.examples",
        )
    return items


@short_repr
@dataclass(eq=False)
class GroundingModel(Estimator):
    """Learns p(φ | words, groundings) from labelled factors.

    Parameters
    ----------
    l2
        Strength of the regularisation.
    features
        The feature sets, or their names (`ct features list`); those that are on by default, if
        left out. Where features are computed already (`FactorMatrix`), these are taken.
    optimizer, tolerance
        As in :func:`g3.learning.crf.train`.
    card
        Description of the training in its file.

    Attributes
    ----------
    space_
        The binary features that were active in training.
    weights_
        One for each feature, shape (k,).
    load_chooser_
        Evidence of all words of a command for the load that it is about; None where no such
        commands were learned from.
    """

    l2: float = DEFAULT_L2
    features: Sequence[FeatureSet | str] | None = None
    optimizer: Optimizer = "newton"
    tolerance: float = crf.TOLERANCE
    card: TrainingCard | None = None
    space_: FeatureSpace = field(init=False, repr=False)
    weights_: FloatArray = field(init=False, repr=False)
    load_chooser_: LoadChooser | None = field(init=False, repr=False)

    classes_ = np.array([False, True])
    """The values of φ, in the order of `predict_proba`."""

    @property
    def sets(self) -> tuple[FeatureSet, ...]:
        """The feature sets that it has learned with, each for its optional types if it did so."""
        learned = {tuple(base.split("/")[:2]) for base in self.space_.bases}
        return tuple(
            feature.for_types(
                {
                    t
                    for t in feature.types
                    if t not in feature.optional or (t, feature.name) in learned
                }
            )
            for feature in select(plus=self.space_.sets)
            if feature.name in self.space_.sets
        )

    def fit(
        self,
        X: Sequence[Example] | FactorMatrix,
        y: npt.ArrayLike | None = None,
        *,
        load_choices: Sequence[LoadChoice] = (),
    ) -> GroundingModel:
        """Learn from labelled factors.

        Parameters
        ----------
        X
            Examples (:func:`g3.learning.examples.examples`), or factors whose features are
            computed.
        y
            Their labels φ, shape (n,); those that `X` has, if left out.
        load_choices
            Commands with the loads that they were about, of which no clauses need be known.

        Raises
        ------
        ModelError
            If there is nothing to learn from, or there aren't as many labels as examples.
        """
        sets = _sets(self.features)
        matrix = X if isinstance(X, FactorMatrix) else matrix_of_examples(_checked(X), sets)
        correct = matrix.correct if y is None else np.asarray(y, dtype=bool)
        if not len(matrix.correct):
            raise ModelError("there is nothing to learn from", fix="give labelled examples")
        if correct.shape != matrix.correct.shape:
            raise ModelError(
                f"there are {len(matrix.correct)} examples, "
                f"and labels of the shape {correct.shape}",
                fix="give a label for each example",
            )
        matrix = matrix.trimmed()
        weights = crf.train(
            matrix.matrix,
            correct,
            l2=self.l2 / prior_scale(matrix.space) ** 2,
            tolerance=self.tolerance,
            optimizer=self.optimizer,
        )
        chooser = LoadChooser.fit(load_choices) if load_choices else None
        return self.with_weights(matrix.space, weights, chooser)

    def with_weights(
        self, space: FeatureSpace, weights: FloatArray, chooser: LoadChooser | None = None
    ) -> GroundingModel:
        """Take what was learned elsewhere: in a file, or on shards."""
        self.space_, self.weights_, self.load_chooser_ = space, weights, chooser
        return self

    def predict(self, X: Sequence[Example] | FactorMatrix) -> npt.NDArray[np.bool_]:
        """Predict φ: true where that is more probable than not, shape (n,)."""
        return self.predict_proba(X)[:, 1] >= 0.5

    def predict_proba(self, X: Sequence[Example] | FactorMatrix) -> FloatArray:
        """p(φ = False) and p(φ = True) of each factor, shape (n, 2)."""
        true = self._probability(X)
        return np.column_stack((1 - true, true))

    def score(self, X: Sequence[Example] | FactorMatrix, y: npt.ArrayLike | None = None) -> float:
        """Return the accuracy of the predictions.

        Parameters
        ----------
        X
            Examples, or factors whose features are computed.
        y
            Their labels φ, shape (n,); those that `X` has, if left out.
        """
        correct = y
        if correct is None:
            correct = X.correct if isinstance(X, FactorMatrix) else labels(_checked(X))
        return float(np.mean(self.predict(X) == np.asarray(correct, dtype=bool)))

    def _probability(self, X: Sequence[Example] | FactorMatrix) -> FloatArray:
        space, weights = self.space_, self.weights_
        if not isinstance(X, FactorMatrix):
            return crf.probabilities(transform(to_batch(_checked(X)), self.sets, space), weights)
        missing = sorted(set(space.sets) - set(X.space.sets))
        if missing:
            raise ModelError(f"the features {missing[0]!r} were not computed", where="predict")
        return crf.probabilities(X.matrix, np.append(weights, 0.0)[columns_in(X.space, space)])

    def save(self, path: Path | str) -> None:
        """Write it to ``NAME.npz`` and ``NAME.json``; the same model gives the same bytes.

        Parameters
        ----------
        path
            ``NAME``, ``NAME.npz`` or ``NAME.json``; what is there is replaced.

        Raises
        ------
        FormatError
            If another program is writing this model, or there is no such folder.
        """
        write_model(
            path,
            self.space_,
            self.weights_,
            l2=self.l2,
            about=self.card or {},
            chooser=self.load_chooser_,
        )

    @classmethod
    def load(cls, path: Path | str, *, corpus_hash: str | None = None) -> GroundingModel:
        """Read what `save` wrote.

        Parameters
        ----------
        path
            ``NAME``, ``NAME.npz`` or ``NAME.json``.
        corpus_hash
            Hash of the corpus that it must have been trained on, if that matters.

        Raises
        ------
        ModelError
            If it is missing or damaged, needs other features or other data than there are, or
            was trained on another corpus.
        """
        card, space, weights = read_model(path, corpus_hash=corpus_hash)
        about: TrainingCard = {
            "corpus_hash": card.corpus_hash,
            "scenarios": card.scenarios,
            "training": card.training,
        }
        model = cls(l2=card.l2, features=card.sets, card=about)
        return model.with_weights(space, weights, chooser_of(card))
