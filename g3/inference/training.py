"""Training for inference: a corpus's examples together with those of the search's own space.

OBJECTs and PLACEs learn from the corpus's labelled examples and from the candidates of the first
pass, EVENTs and PATHs from the actions of the second alone. So each factor is trained on what it
chooses among at inference.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy import sparse

from g3 import crf
from g3.annotation import Annotation
from g3.examples import examples, labels, to_batch
from g3.features.matrix import FeatureSpace, fit_joint_space, prior_scale
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


def training_data(
    annotations: Sequence[Annotation],
    sets: Sequence[FeatureSet],
    *,
    seed: int = 0,
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
    """
    items = [e for e in examples(annotations) if e.sdc.type in ("OBJECT", "PLACE")]
    own: list[Labelled] = []
    of_context: dict[int, list[Annotation]] = {}
    for annotation in (a for a in annotations if a.source == "positive"):
        of_context.setdefault(id(annotation.context), []).append(annotation)
    for number, positives in enumerate(of_context.values()):
        if on_progress:
            on_progress("trying actions", number, len(of_context))
        own += _own(positives, np.random.default_rng([seed, number]))
    batches = [*([to_batch(items)] if items else []), *(o.batch for o in own)]
    space, matrix = fit_joint_space(batches, sets)
    return Data(
        space,
        matrix,
        np.concatenate([labels(items), *(o.correct for o in own)]),
        np.array(
            [
                *(e.annotation.command.scenario for e in items),
                *(o.annotation.command.scenario for o in own for _ in o.correct),
            ],
            dtype=np.str_,
        ),
    )


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
