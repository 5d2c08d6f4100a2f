"""Running what the choices of ``ct eval`` describe."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from corpus_tools.progress import OnProgress
from eval.correspondence import Predictions
from eval.error_lists import Example as ShownExample
from eval.experiment import learning_curve, predict_splits, predictions, prepare
from eval.learning_curve import CurvePoint
from eval.protocol import Choices, Metadata, chosen_sets, set_up, set_up_model
from g3.examples import Example
from g3.model import predict
from g3.sdc import all_words


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
        return Result(items, predictions(items, predict(model, items)), metadata)
    sets = chosen_sets(choices)
    trial = set_up(choices)
    rows, probability = predict_splits(
        prepare(trial.items, sets), trial.splits, l2=choices.strength, on_progress=on_progress
    )
    tested = [trial.items[row] for row in rows]
    return Result(tested, predictions(tested, probability), trial.metadata)


def curve(
    choices: Choices, repeats: int, on_progress: OnProgress | None = None
) -> tuple[tuple[CurvePoint, ...], Metadata]:
    """Measure the learning curve of what is chosen."""
    sets = chosen_sets(choices)
    trial = set_up(choices)
    points = learning_curve(
        prepare(trial.items, sets),
        trial.splits,
        l2=choices.strength,
        repeats=repeats,
        seed=choices.seed,
        threshold=choices.threshold,
        on_progress=on_progress,
    )
    return points, {**trial.metadata, "repeats": repeats}
