"""Training for inference: a corpus's examples together with those of the search's own space.

OBJECTs and PLACEs learn from the corpus's labelled examples and from the candidates of the first
pass. EVENTs and PATHs learn from the actions of the second pass alone. So each factor is trained on
what it chooses among at inference.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from g3.actions.grounding_candidates import object_groups
from g3.actions.robot_state import start_state
from g3.annotation import Annotation
from g3.features.feature_registry import FeatureSet, select
from g3.inference.problem.packed_scene import scene_of
from g3.inference.training.action_examples import action_examples
from g3.inference.training.thing_examples import thing_examples
from g3.learning.examples import examples
from g3.learning.factor_matrix import (
    FactorMatrix,
    Labelled,
    joined,
    matrix_of_examples,
    matrix_of_labelled,
)

TOLERANCE = 0.1
"""Of a `GroundingModel` that learns from `training_data`; ranking needs no more."""

WHERE = ("avs-intrinsic", "bearing")
"""Sets that places of one scene are chosen by. Of places of all scenes they learn the map."""

OnProgress = Callable[[str, int, int], object]


@dataclass(frozen=True, slots=True)
class _Task:
    """Annotations whose examples are made together, and which context they share, if they do."""

    annotations: Sequence[Annotation]
    number: int | None = None


class Each(Protocol):
    """Applies a function to each task, as :class:`map` does, maybe in several processes."""

    def __call__(
        self, function: Callable[[_Task], FactorMatrix], tasks: Sequence[_Task], /
    ) -> Iterable[FactorMatrix]:
        """What the function gives for each task, in their order."""


def search_sets(without: Iterable[str] = ()) -> tuple[FeatureSet, ...]:
    """The feature sets of models that search, some left out."""
    return select(without=without, plus=WHERE)


def training_data(
    annotations: Sequence[Annotation],
    sets: Sequence[FeatureSet],
    *,
    seed: int = 0,
    each: Each = map,
    on_progress: OnProgress | None = None,
) -> FactorMatrix:
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
    parts: list[FactorMatrix] = []
    for part in each(functools.partial(_part, sets=sets, seed=seed), tasks):
        parts.append(part)
        if on_progress:
            on_progress("trying actions", len(parts), len(tasks))
    return joined(parts, sets)


def _part(task: _Task, *, sets: Sequence[FeatureSet], seed: int) -> FactorMatrix:
    """The corpus's examples of OBJECTs and PLACEs, or a context's of the search's own space.

    The matrix says true and false instead of numbers: less to hand over to another process.
    """
    data = _examples(task, sets, seed)
    return replace(data, matrix=data.matrix.astype(np.bool_))


def _examples(task: _Task, sets: Sequence[FeatureSet], seed: int) -> FactorMatrix:
    if task.number is not None:
        rng = np.random.default_rng([seed, task.number])
        labelled = _own(task.annotations, rng)
        return joined([matrix_of_labelled(one, sets) for one in labelled], sets)
    items = [e for e in examples(task.annotations) if e.sdc.type in ("OBJECT", "PLACE")]
    return joined([matrix_of_examples(items, sets)] if items else [], sets)


def _own(positives: Sequence[Annotation], rng: np.random.Generator) -> Iterator[Labelled]:
    """Examples of the search's own space, of annotations of one context."""
    state = start_state(positives[0].context)
    scene = scene_of(state.context, object_groups(state.context))
    yield from thing_examples(positives, state, scene, rng)
    for annotation in positives:
        yield from action_examples(annotation, rng)
