"""Training for inference: a corpus's examples together with those of the search's own space.

OBJECTs and PLACEs learn from the corpus's labelled examples and from the candidates of the first
pass, EVENTs and PATHs from the actions of the second alone. So each factor is trained on what it
chooses among at inference.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
import numpy.typing as npt
from scipy import sparse

from g3 import crf
from g3.annotation import Annotation
from g3.examples import examples, labels, to_batch
from g3.features.batch import FactorBatch
from g3.features.matrix import FeatureSpace, fit_space, joint_space, prior_scale
from g3.features.registry import CATALOGUE_VERSION, FeatureSet
from g3.inference.action_examples import action_examples
from g3.inference.candidates import object_groups
from g3.inference.labelled import Labelled
from g3.inference.scene import scene_of
from g3.inference.state import start_state
from g3.inference.thing_examples import thing_examples
from g3.model import DEFAULT_L2, Model

TOLERANCE = 0.1
"""No component of the gradient exceeds it at the end; ranking needs no more."""

OnProgress = Callable[[str, int, int], object]


@dataclass(frozen=True, slots=True, eq=False)
class Data:
    """Labelled factors with their features.

    Parameters
    ----------
    space
        The features that are active in any of them.
    matrix
        Which are active in which, shape (n, k).
    correct
        The correspondence variables, shape (n,).
    scenario
        The scenario of each, shape (n,).
    """

    space: FeatureSpace
    matrix: sparse.csr_array
    correct: npt.NDArray[np.bool_]
    scenario: npt.NDArray[np.str_]


@dataclass(frozen=True, slots=True)
class _Task:
    """Annotations whose examples are made together, and which context they share, if they do."""

    annotations: Sequence[Annotation]
    number: int | None = None


class Each(Protocol):
    """Applies a function to each task, as :class:`map` does, maybe in several processes."""

    def __call__(
        self, function: Callable[[_Task], Data], tasks: Sequence[_Task], /
    ) -> Iterable[Data]:
        """What the function gives for each task, in their order."""


def training_data(
    annotations: Sequence[Annotation],
    sets: Sequence[FeatureSet],
    *,
    seed: int = 0,
    each: Each = map,
    on_progress: OnProgress | None = None,
) -> Data:
    """Collect what a model for inference learns from.

    Parameters
    ----------
    annotations
        Those of a corpus, of all sources.
    sets
        Feature sets.
    seed
        What negatives are drawn with; each context draws its own.
    each
        What applies a function to each of several tasks, and gives the results in their order.
    """
    of_context: dict[int, list[Annotation]] = {}
    for annotation in (a for a in annotations if a.source == "positive"):
        of_context.setdefault(id(annotation.context), []).append(annotation)
    tasks = [_Task(annotations), *(_Task(own, i) for i, own in enumerate(of_context.values()))]
    parts: list[Data] = []
    for part in each(functools.partial(_part, sets=sets, seed=seed), tasks):
        parts.append(part)
        if on_progress:
            on_progress("trying actions", len(parts), len(tasks))
    return _joined(parts, sets)


def _part(task: _Task, *, sets: Sequence[FeatureSet], seed: int) -> Data:
    """The corpus's examples of OBJECTs and PLACEs, or a context's of the search's own space.

    The matrix says true and false instead of numbers: less to hand over to another process.
    """
    data = _examples(task, sets, seed)
    return replace(data, matrix=data.matrix.astype(np.bool_))


def _examples(task: _Task, sets: Sequence[FeatureSet], seed: int) -> Data:
    if task.number is not None:
        rng = np.random.default_rng([seed, task.number])
        labelled = _own(task.annotations, rng)
        return _joined([_data(o.batch, o.correct, [o.annotation], sets) for o in labelled], sets)
    items = [e for e in examples(task.annotations) if e.sdc.type in ("OBJECT", "PLACE")]
    found = [_data(to_batch(items), labels(items), [e.annotation for e in items], sets)]
    return _joined(found if items else [], sets)


def _data(
    batch: FactorBatch,
    correct: npt.NDArray[np.bool_],
    annotations: Sequence[Annotation],
    sets: Sequence[FeatureSet],
) -> Data:
    scenario = np.array([a.command.scenario for a in annotations], dtype=np.str_)
    return Data(*fit_space(batch, sets), correct, np.broadcast_to(scenario, len(correct)))


def _joined(parts: Sequence[Data], sets: Sequence[FeatureSet]) -> Data:
    space, matrix = joint_space([(part.space, part.matrix) for part in parts], sets)
    correct = np.concatenate([np.empty(0, dtype=bool), *(part.correct for part in parts)])
    scenario = np.concatenate([np.empty(0, dtype="U1"), *(part.scenario for part in parts)])
    return Data(space, matrix, correct, scenario)


def _own(positives: Sequence[Annotation], rng: np.random.Generator) -> Iterator[Labelled]:
    """Examples of the search's own space, of annotations of one context."""
    state = start_state(positives[0].context)
    scene = scene_of(state.context, object_groups(state.context))
    yield from thing_examples(positives, state, scene, rng)
    for annotation in positives:
        yield from action_examples(annotation, rng)


def train_rows(
    data: Data, rows: npt.NDArray[np.intp], *, l2: float = DEFAULT_L2, corpus_hash: str = ""
) -> Model:
    """Train on some rows, with the features that are active in them."""
    known = data.matrix[rows]
    active = np.unique(known.indices)
    space = replace(data.space, keys=data.space.keys[active])
    weights = crf.train(
        known[:, active],
        data.correct[rows],
        l2=l2 / prior_scale(space) ** 2,
        tolerance=TOLERANCE,
    )
    return Model(space, weights, l2, CATALOGUE_VERSION, corpus_hash)
