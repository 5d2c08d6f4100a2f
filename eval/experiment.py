"""What ``ct eval`` trains and predicts: one side of each split learned from, the other tested.

Features don't depend on other examples, so they are computed once for all splits; each
model sees only the columns that are active on its own training side.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from corpus_tools.progress import OnProgress
from eval.correspondence import TYPES, Predictions, RowType, predicted_true
from eval.error_lists import Example as ShownExample
from eval.learning_curve import CurvePoint
from eval.protocol import Choices, Metadata, Trial, set_up, set_up_model
from eval.splits import IntArray, Split
from eval.statistics import FloatArray
from g3.examples import Example, labels
from g3.factor_matrix import FactorMatrix, matrix_of_examples
from g3.features.registry import select
from g3.model import GroundingModel
from g3.sdc import all_words

SMALLEST_SIZE = 50
"""Annotated SDCs at the first point of a learning curve; each further point has twice as many."""


@dataclass(frozen=True, slots=True, eq=False)
class Result:
    """What was predicted of the tested examples.

    Parameters
    ----------
    items
        The examples.
    predictions
        What the models said of them, aligned.
    metadata
        What to record with the results.
    """

    items: Sequence[Example]
    predictions: Predictions
    metadata: Metadata

    @property
    def shown(self) -> list[ShownExample]:
        """What error lists show of the examples."""
        return [
            ShownExample(
                id=f"{e.annotation.id}, clause {e.node + 1}",
                words=" ".join(span.text for span in all_words(e.sdc)),
                source=e.source,
            )
            for e in self.items
        ]


def run(choices: Choices, on_progress: OnProgress | None = None) -> Result:
    """Train as chosen, or read the trained model, and predict the test side."""
    if choices.model is not None:
        model, items, metadata = set_up_model(choices)
        return Result(items, predictions(items, model.predict_proba(items)[:, 1]), metadata)
    sets = select(without=choices.ablate, plus=choices.plus)
    trial = set_up(choices)
    factors = matrix_of_examples(trial.items, sets)
    rows, probability = predict_splits(
        factors, trial.splits, l2=choices.strength, on_progress=on_progress
    )
    tested = [trial.items[row] for row in rows]
    return Result(tested, predictions(tested, probability), trial.metadata)


def curve(
    choices: Choices, repeats: int, on_progress: OnProgress | None = None
) -> tuple[tuple[CurvePoint, ...], Metadata]:
    """Measure the learning curve of what is chosen."""
    sets = select(without=choices.ablate, plus=choices.plus)
    trial = set_up(choices)
    points = learning_curve(
        trial,
        matrix_of_examples(trial.items, sets),
        l2=choices.strength,
        repeats=repeats,
        seed=choices.seed,
        threshold=choices.threshold,
        on_progress=on_progress,
    )
    return points, {**trial.metadata, "repeats": repeats}


def predict_splits(
    factors: FactorMatrix,
    splits: Sequence[Split],
    *,
    l2: float,
    on_progress: OnProgress | None = None,
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
        model = GroundingModel(l2=l2).fit(factors[split.train])
        parts.append(model.predict_proba(factors[split.test])[:, 1])
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
    trial: Trial,
    factors: FactorMatrix,
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
    trial
        The examples, and what is tested; the errors of several splits are pooled.
    factors
        The features of the examples.
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
    items, splits = trial.items, trial.splits
    sizes = curve_sizes(min(_annotated(items, split.train) for split in splits))
    tested = np.concatenate([split.test for split in splits])
    errors = np.empty((repeats, len(sizes), len(TYPES) + 1))
    trained_on = np.empty((repeats, len(sizes), len(splits)))
    for repeat in range(repeats):
        rng = np.random.default_rng([seed, repeat])
        orders = [_shuffled(items, split.train, rng) for split in splits]
        for step, size in enumerate(sizes):
            parts = []
            for place, (split, order) in enumerate(zip(splits, orders, strict=True)):
                train, trained_on[repeat, step, place] = _first_commands(items, order, size)
                model = GroundingModel(l2=l2).fit(factors[train])
                parts.append(model.predict_proba(factors[split.test])[:, 1])
                if on_progress:
                    done = (repeat * len(sizes) + step) * len(splits) + place + 1
                    on_progress("training", done, errors.shape[0] * errors.shape[1] * len(splits))
            said = predictions([items[i] for i in tested], np.concatenate(parts))
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


def _annotated(items: Sequence[Example], rows: IntArray) -> int:
    """How many different clauses of commands some examples are about."""
    return len({(items[i].annotation.command.id, items[i].node) for i in rows})


def _shuffled(items: Sequence[Example], rows: IntArray, rng: np.random.Generator) -> list[IntArray]:
    """The examples of each command, the commands in random order."""
    names = np.array([items[i].annotation.command.id for i in rows])
    commands = np.unique(names)
    return [rows[names == command] for command in rng.permutation(commands)]


def _first_commands(
    items: Sequence[Example], commands: Sequence[IntArray], size: int
) -> tuple[IntArray, int]:
    """The examples of the first commands that annotate so many SDCs, and how many they do."""
    annotated = np.cumsum([_annotated(items, rows) for rows in commands])
    count = min(int(np.searchsorted(annotated, size)) + 1, len(commands))
    return np.sort(np.concatenate(commands[:count])), int(annotated[count - 1])


def _errors(said: Predictions, threshold: float) -> FloatArray:
    """Fraction predicted wrongly of each type and overall; NaN where there are none; (5,)."""
    wrong = predicted_true(said, threshold) != said.label
    of_types = [wrong[said.type == kind] for kind in TYPES]
    return np.array([w.mean() if len(w) else np.nan for w in (*of_types, wrong)])
