"""Training and prediction for ``ct eval``: one side of each split trains, the other is tested.

Features don't depend on other examples, so they are computed once for all splits; each
model sees only the columns that are active on its own training side.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from corpus_tools.runtime.progress import OnProgress
from eval.splits import IntArray
from eval.statistics.estimates import FloatArray
from eval.table_1.correspondence import TYPES, Predictions, RowType, predicted_true
from eval.table_1.divided_examples import (
    Choices,
    DividedExamples,
    Metadata,
    chosen_sets,
    set_up,
    set_up_model,
)
from eval.table_1.error_lists import Example as ShownExample
from eval.table_1.given_predictions import OURS, read_predictions
from eval.table_1.learning_curve import CurvePoint
from g3.errors import CorpusError
from g3.learning.examples import Example, labels
from g3.learning.factor_matrix import FactorMatrix, matrix_of_examples
from g3.learning.grounding_model import GroundingModel
from g3.sdc.clauses import all_words
from g3.short_repr import short_repr

SMALLEST_SIZE = 50
"""Annotated SDCs at the first point of a learning curve; each further point has twice as many."""


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class Result:
    """Predictions for the tested examples."""

    items: Sequence[Example]
    predictions: Predictions
    metadata: Metadata

    @property
    def shown(self) -> list[ShownExample]:
        """The examples' fields in error lists."""
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
    divided, factors = _set_up(choices)
    parts = []
    for done, split in enumerate(divided.splits, start=1):
        model = GroundingModel(l2=choices.strength).fit(factors[split.train])
        parts.append(model.predict_proba(factors[split.test])[:, 1])
        if on_progress:
            on_progress("training", done, len(divided.splits))
    rows = np.concatenate([split.test for split in divided.splits])
    order = np.argsort(rows, kind="stable")
    tested = [divided.items[row] for row in rows[order]]
    return Result(tested, predictions(tested, np.concatenate(parts)[order]), divided.metadata)


def given(files: Iterable[Path], result: Result) -> dict[str, Predictions]:
    """Read other programs' predictions for the tested examples, by the names of their files."""
    predicted: dict[str, Predictions] = {}
    for file in files:
        if file.stem in {OURS, *predicted}:
            raise CorpusError(
                f"two models of Table 1 are called {file.stem}",
                where=str(file),
                fix="give the file another name",
            )
        predicted[file.stem] = predictions(result.items, read_predictions(file, result.items))
    return predicted


def tested_examples(choices: Choices) -> list[Example]:
    """Return the examples that :func:`run` tests, in its order, without training."""
    if choices.model is not None:
        return list(set_up_model(choices)[1])
    divided = set_up(choices)
    rows = np.sort(np.concatenate([split.test for split in divided.splits]), kind="stable")
    return [divided.items[row] for row in rows]


def _set_up(choices: Choices) -> tuple[DividedExamples, FactorMatrix]:
    """Return the divided examples, with the matrix of the chosen features."""
    divided = set_up(choices)
    return divided, matrix_of_examples(divided.items, chosen_sets(choices))


def predictions(items: Sequence[Example], probability: FloatArray) -> Predictions:
    """Align a model's probabilities of examples with the fields that evaluation needs."""
    return Predictions(
        type=np.array([e.sdc.type for e in items], dtype=np.str_),
        label=labels(items),
        probability=probability,
        command=np.array([e.annotation.command.id for e in items], dtype=np.str_),
        scenario=np.array([e.annotation.command.scenario for e in items], dtype=np.str_),
    )


def learning_curve(
    choices: Choices, repeats: int, on_progress: OnProgress | None = None
) -> tuple[tuple[CurvePoint, ...], Metadata]:
    """Measure the test error of models trained on more and more commands (section 4.2).

    Commands of the training side are added in a random order, each with all of its
    examples. The size is the number of different SDCs that they annotate: a command's
    negatives come with it and add nothing to the size.

    Parameters
    ----------
    choices
        Training and test sets; the errors of several splits are pooled.

    Returns
    -------
    tuple
        The mean error over the orders, with its least and its greatest value; and metadata to
        record with it.
    """
    divided, factors = _set_up(choices)
    items, splits = divided.items, divided.splits
    sizes = curve_sizes(min(_annotated(items, split.train) for split in splits))
    tested = np.concatenate([split.test for split in splits])
    errors = np.empty((repeats, len(sizes), len(TYPES) + 1))
    trained_on = np.empty((repeats, len(sizes), len(splits)))
    for repeat in range(repeats):
        rng = np.random.default_rng([choices.seed, repeat])
        orders = [_shuffled(items, split.train, rng) for split in splits]
        for step, size in enumerate(sizes):
            parts = []
            for place, (split, order) in enumerate(zip(splits, orders, strict=True)):
                train, trained_on[repeat, step, place] = _first_commands(items, order, size)
                model = GroundingModel(l2=choices.strength).fit(factors[train])
                parts.append(model.predict_proba(factors[split.test])[:, 1])
                if on_progress:
                    done = (repeat * len(sizes) + step) * len(splits) + place + 1
                    on_progress("training", done, errors.shape[0] * errors.shape[1] * len(splits))
            predicted = predictions([items[i] for i in tested], np.concatenate(parts))
            errors[repeat, step] = _errors(predicted, choices.threshold)
    kinds: tuple[RowType, ...] = (*TYPES, "overall")
    points = tuple(
        CurvePoint(
            type=kind,
            sdcs=round(float(trained_on[:, step].mean())),
            error=float(errors[:, step, row].mean()),
            low=float(errors[:, step, row].min()),
            high=float(errors[:, step, row].max()),
            reason="empty class" if np.isnan(errors[:, step, row]).any() else "",
        )
        for row, kind in enumerate(kinds)
        for step in range(len(sizes))
    )
    return points, {**divided.metadata, "repeats": repeats}


def curve_sizes(total: int) -> tuple[int, ...]:
    """Return numbers of SDCs to train on: doubling, and at last all there are."""
    sizes = []
    size = SMALLEST_SIZE
    while size < total * 0.75:  # a point close to the last would say nothing new
        sizes.append(size)
        size *= 2
    return (*sizes, total)


def _annotated(items: Sequence[Example], rows: IntArray) -> int:
    """Count the different clauses of commands in examples."""
    return len({(items[i].annotation.command.id, items[i].node) for i in rows})


def _shuffled(items: Sequence[Example], rows: IntArray, rng: np.random.Generator) -> list[IntArray]:
    """Return the rows of each command's examples, the commands in random order."""
    names = np.array([items[i].annotation.command.id for i in rows])
    commands = np.unique(names)
    return [rows[names == command] for command in rng.permutation(commands)]


def _first_commands(
    items: Sequence[Example], commands: Sequence[IntArray], size: int
) -> tuple[IntArray, int]:
    """Return rows of the first commands with a number of SDCs, and that number."""
    annotated = np.cumsum([_annotated(items, rows) for rows in commands])
    count = min(int(np.searchsorted(annotated, size)) + 1, len(commands))
    return np.sort(np.concatenate(commands[:count])), int(annotated[count - 1])


def _errors(predicted: Predictions, threshold: float) -> FloatArray:
    """Return error rates of each type and overall, shape (5,); NaN where there are none."""
    wrong = predicted_true(predicted, threshold) != predicted.label
    of_types = [wrong[predicted.type == kind] for kind in TYPES]
    return np.array([w.mean() if len(w) else np.nan for w in (*of_types, wrong)])
