"""Training on one side of a split and predicting the other.

Features don't depend on other examples, so they are computed once for all splits; each
model sees only the columns that are active on its own training side.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse

from corpus_tools.progress import OnProgress
from eval.correspondence import TYPES, Predictions, RowType, predicted_true
from eval.learning_curve import CurvePoint
from eval.splits import IntArray, Split
from eval.statistics import BoolArray, FloatArray
from g3 import crf
from g3.examples import Example, labels, to_batch
from g3.features.matrix import FeatureSpace, fit_space, prior_scale
from g3.features.registry import FeatureSet

SMALLEST_SIZE = 50
"""Annotated SDCs at the first point of a learning curve; each further point has twice as many."""


@dataclass(frozen=True, slots=True, eq=False)
class Data:
    """Examples with their features.

    Parameters
    ----------
    items
        The n examples.
    space
        The features that are active in any of them.
    matrix
        Which are active in which, shape (n, k).
    correct
        The correspondence variables, shape (n,).
    """

    items: Sequence[Example]
    space: FeatureSpace
    matrix: sparse.csr_array
    correct: BoolArray


def prepare(items: Sequence[Example], sets: Sequence[FeatureSet]) -> Data:
    """Compute the features of examples."""
    space, matrix = fit_space(to_batch(items), sets)
    return Data(items, space, matrix, labels(items))


def train_and_predict(data: Data, train: IntArray, test: IntArray, *, l2: float) -> FloatArray:
    """Train on some examples and give p(φ = True) of others.

    The result is that of :func:`g3.model.train_model` and :func:`g3.model.predict`.

    Parameters
    ----------
    data
        All examples.
    train, test
        Indices of the examples to train on and of those to predict.
    l2
        Strength of the regularisation.

    Returns
    -------
    ndarray
        Shape (len(test),).
    """
    known = data.matrix[train]
    active = np.unique(known.indices)
    space = replace(data.space, keys=data.space.keys[active])
    weights = crf.train(known[:, active], data.correct[train], l2=l2 / prior_scale(space) ** 2)
    return crf.probabilities(data.matrix[test][:, active], weights)


def predict_splits(
    data: Data, splits: Sequence[Split], *, l2: float, on_progress: OnProgress | None = None
) -> tuple[IntArray, FloatArray]:
    """Predict the test side of each split with a model of its training side.

    Returns
    -------
    rows, probability : ndarray
        Indices of all tested examples, ascending, and their p(φ = True); both (m,).
    """
    rows = np.concatenate([split.test for split in splits])
    parts = []
    for done, split in enumerate(splits, start=1):
        parts.append(train_and_predict(data, split.train, split.test, l2=l2))
        if on_progress:
            on_progress("training", done, len(splits))
    order = np.argsort(rows, kind="stable")
    return rows[order], np.concatenate(parts)[order]


def predictions(items: Sequence[Example], probability: FloatArray) -> Predictions:
    """Align what a model said of examples with what evaluation needs of them."""
    return Predictions(
        type=np.array([e.sdc.type for e in items], dtype=np.str_),
        label=labels(items),
        probability=probability,
        command=np.array([e.annotation.command.id for e in items], dtype=np.str_),
        scenario=np.array([e.annotation.command.scenario for e in items], dtype=np.str_),
    )


def learning_curve(
    data: Data,
    splits: Sequence[Split],
    *,
    l2: float,
    repeats: int,
    seed: int,
    threshold: float = 0.5,
    on_progress: OnProgress | None = None,
) -> tuple[CurvePoint, ...]:
    """Measure the test error of models trained on more and more commands (section 4.2).

    Commands of the training side are added in a random order, each with all of its
    examples. The size is the number of different SDCs that they annotate: a command's
    negatives come with it and add nothing to the size.

    Parameters
    ----------
    data
        All examples.
    splits
        What is tested; the errors of several splits are pooled.
    l2
        Strength of the regularisation.
    repeats
        Number of random orders.
    seed
        What the orders are drawn with.
    threshold
        Probability from which φ counts as predicted true.
    on_progress
        Told how many models have been trained.

    Returns
    -------
    tuple of CurvePoint
        The mean error over the orders, with its least and its greatest value.
    """
    sizes = curve_sizes(min(_annotated(data, split.train) for split in splits))
    tested = np.concatenate([split.test for split in splits])
    errors = np.empty((repeats, len(sizes), len(TYPES) + 1))
    trained_on = np.empty((repeats, len(sizes), len(splits)))
    for repeat in range(repeats):
        rng = np.random.default_rng([seed, repeat])
        orders = [_shuffled(data, split.train, rng) for split in splits]
        for step, size in enumerate(sizes):
            parts = []
            for place, (split, order) in enumerate(zip(splits, orders, strict=True)):
                train, trained_on[repeat, step, place] = _first_commands(data, order, size)
                parts.append(train_and_predict(data, train, split.test, l2=l2))
                if on_progress:
                    done = (repeat * len(sizes) + step) * len(splits) + place + 1
                    on_progress("training", done, errors.shape[0] * errors.shape[1] * len(splits))
            said = predictions([data.items[i] for i in tested], np.concatenate(parts))
            errors[repeat, step] = _errors(said, threshold)
    kinds: tuple[RowType, ...] = (*TYPES, "overall")
    return tuple(
        CurvePoint(
            type=kind,
            sdcs=round(float(trained_on[:, step].mean())),
            error=float(errors[:, step, row].mean()),
            low=float(errors[:, step, row].min()),
            high=float(errors[:, step, row].max()),
        )
        for row, kind in enumerate(kinds)
        for step in range(len(sizes))
    )


def curve_sizes(total: int) -> tuple[int, ...]:
    """Numbers of SDCs to train on: doubling, and at last all there are."""
    sizes = []
    size = SMALLEST_SIZE
    while size < total * 0.75:  # a point close to the last would say nothing new
        sizes.append(size)
        size *= 2
    return (*sizes, total)


def _annotated(data: Data, rows: IntArray) -> int:
    """How many different clauses of commands some examples are about."""
    return len({(data.items[i].annotation.command.id, data.items[i].node) for i in rows})


def _shuffled(data: Data, rows: IntArray, rng: np.random.Generator) -> list[IntArray]:
    """The examples of each command, the commands in random order."""
    names = np.array([data.items[i].annotation.command.id for i in rows])
    commands = np.unique(names)
    return [rows[names == command] for command in rng.permutation(commands)]


def _first_commands(data: Data, commands: Sequence[IntArray], size: int) -> tuple[IntArray, int]:
    """The examples of the first commands that annotate so many SDCs, and how many they do."""
    annotated = np.cumsum([_annotated(data, rows) for rows in commands])
    count = min(int(np.searchsorted(annotated, size)) + 1, len(commands))
    return np.sort(np.concatenate(commands[:count])), int(annotated[count - 1])


def _errors(said: Predictions, threshold: float) -> FloatArray:
    """Fraction predicted wrongly of each type and overall; NaN where there are none; (5,)."""
    wrong = predicted_true(said, threshold) != said.label
    of_types = [wrong[said.type == kind] for kind in TYPES]
    return np.array([w.mean() if len(w) else np.nan for w in (*of_types, wrong)])
