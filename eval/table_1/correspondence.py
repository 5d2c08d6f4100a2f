"""Accuracy of predictions of the correspondence variable φ: the paper's Table 1.

An example is one SDC with groundings and a label, which is true if they are right; the model gives
the probability of φ = True (section 4.2).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal, NamedTuple, TypeAlias, get_args

import numpy as np
import numpy.typing as npt

from corpus_tools.corpus.estimate import Estimate
from corpus_tools.runtime.parallel import Executor
from eval.statistics.estimates import (
    FIGURES,
    BoolArray,
    EstimateArray,
    FloatArray,
    IntArray,
    cluster_bootstrap,
    confusion,
    figures,
)
from g3.short_repr import short_repr

StrArray: TypeAlias = npt.NDArray[np.character]

RowType = Literal["OBJECT", "PLACE", "PATH", "EVENT", "overall"]
ROW_TYPES: tuple[RowType, ...] = get_args(RowType)
"""Rows of Table 1 in the paper's order: the SDC types, then all examples together."""
TYPES = ROW_TYPES[:-1]

Cluster = Literal["command", "scenario"]
"""Unit of resampling for intervals: commands, or the coarser scenarios that they describe."""


class PaperRow(NamedTuple):
    """One row of the paper's Table 1."""

    precision: float
    recall: float
    f: float
    accuracy: float


PAPER_SOURCE = "Tellex et al. (AAAI 2011), Table 1"
PAPER_TABLE_1: Mapping[RowType, PaperRow] = MappingProxyType(
    {
        "OBJECT": PaperRow(0.93, 0.94, 0.94, 0.91),
        "PLACE": PaperRow(0.70, 0.70, 0.70, 0.70),
        "PATH": PaperRow(0.86, 0.75, 0.80, 0.81),
        "EVENT": PaperRow(0.84, 0.73, 0.78, 0.80),
        "overall": PaperRow(0.90, 0.88, 0.89, 0.86),
    }
)
"""The paper's figures (:data:`PAPER_SOURCE`), measured on its own test set."""


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class Predictions:
    """Aligned arrays of a model's predictions for n examples; copied and read-only.

    Parameters
    ----------
    type
        SDC type of each example, shape (n,).
    label
        True where the groundings are right, shape (n,), bool.
    probability
        The model's probability of φ = True, shape (n,).
    command
        Id of the command that the example comes from, shape (n,).
    scenario
        Name of the scenario that the command is about, shape (n,).

    Raises
    ------
    ValueError
        If the arrays aren't aligned or hold something else than described.
    """

    type: StrArray
    label: BoolArray
    probability: FloatArray
    command: StrArray
    scenario: StrArray

    def __post_init__(self) -> None:
        label = np.asarray(self.label)
        if label.size and label.dtype != np.bool_:
            # bool(None) is False: an example that nobody judged would pass for a negative.
            raise ValueError(f"label has type {label.dtype}, expected bool")
        arrays = {
            "type": np.array(self.type, dtype=np.str_),
            "label": np.array(label, dtype=np.bool_),
            "probability": np.array(self.probability, dtype=np.float64),
            "command": np.array(self.command, dtype=np.str_),
            "scenario": np.array(self.scenario, dtype=np.str_),
        }
        shape = (arrays["type"].size,)
        for name, array in arrays.items():
            if array.shape != shape:
                raise ValueError(f"{name} has shape {array.shape}, expected {shape}")
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        unknown = sorted(set(self.type.tolist()) - set(TYPES))
        if unknown:
            raise ValueError(f"{unknown[0]!r} is no SDC type, expected one of {', '.join(TYPES)}")
        if not ((self.probability >= 0) & (self.probability <= 1)).all():
            raise ValueError("probability holds a value outside 0 to 1")

    def __len__(self) -> int:
        return len(self.label)


@short_repr
@dataclass(frozen=True, slots=True)
class Row:
    """One row of Table 1.

    Parameters
    ----------
    type
        An SDC type, or ``overall``.
    precision, recall, f, accuracy
        Each with its 95% interval; NaN with the reason where undefined
        (:func:`eval.statistics.estimates.figures`).
    n, positives
        Numbers of examples and of those labelled true.
    commands, scenarios
        Numbers of distinct commands and scenarios among the examples.
    """

    type: RowType
    precision: Estimate
    recall: Estimate
    f: Estimate
    accuracy: Estimate
    n: int
    positives: int
    commands: int
    scenarios: int


def predicted_true(predictions: Predictions, threshold: float) -> BoolArray:
    """Return where φ is predicted true: probability at or above the threshold, shape (n,)."""
    return predictions.probability >= threshold


def table_rows(
    predictions: Predictions,
    *,
    threshold: float = 0.5,
    draws: int = 2000,
    seed: int = 0,
    cluster: Cluster = "command",
    executor: Executor | None = None,
) -> tuple[Row, ...]:
    """Compute the rows of Table 1, one per :data:`ROW_TYPES`.

    The overall row pools all examples (micro-average), as the paper's does. A type
    without examples has n = 0 and NaN figures.

    Parameters
    ----------
    threshold
        Probability from which φ counts as predicted true.
    draws, seed
        Resamples for the intervals and the seed they are drawn with.
    cluster
        Unit of resampling. Intervals over commands hold for new commands about the same scenarios,
        intervals over scenarios for new scenarios; the latter are wider and need a few dozen
        scenarios to be trusted.
    executor
        Executor of the resamples (:func:`eval.statistics.estimates.resampled_sums`).
    """
    counts = _counts_by_cluster(predictions, threshold, cluster)
    rng = np.random.default_rng(seed)
    estimates = cluster_bootstrap(counts, figures, rng=rng, draws=draws, executor=executor)
    return tuple(_row(predictions, kind, estimates[index]) for index, kind in enumerate(ROW_TYPES))


def _counts_by_cluster(predictions: Predictions, threshold: float, cluster: Cluster) -> IntArray:
    """Count confusions, shape (clusters, rows of the table, 4)."""
    ids = predictions.command if cluster == "command" else predictions.scenario
    names, cluster_index = np.unique(ids, return_inverse=True)
    group = np.zeros(len(predictions), dtype=np.int64)
    for index, kind in enumerate(TYPES):
        group[predictions.type == kind] = index
    by_type = confusion(
        predictions.label,
        predicted_true(predictions, threshold),
        cluster=cluster_index.astype(np.int64),
        group=group,
        shape=(len(names), len(TYPES)),
    )
    return np.concatenate([by_type, by_type.sum(axis=1, keepdims=True)], axis=1)


def _row(predictions: Predictions, kind: RowType, estimates: EstimateArray) -> Row:
    chosen = np.ones(len(predictions), bool) if kind == "overall" else predictions.type == kind
    return Row(
        type=kind,
        n=int(chosen.sum()),
        positives=int(predictions.label[chosen].sum()),
        commands=len(np.unique(predictions.command[chosen])),
        scenarios=len(np.unique(predictions.scenario[chosen])),
        **dict(zip(FIGURES, estimates, strict=True)),
    )
