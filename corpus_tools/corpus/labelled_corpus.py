"""The labelled examples of a corpus, with one or the other kind of negatives."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from hashlib import sha256
from typing import Literal, get_args

import numpy as np

from corpus_tools.corpus.corpus_model import Corpus
from g3.annotation import Annotation
from g3.errors import CorpusError
from g3.groundings import Context
from g3.learning.examples import Example, examples
from g3.short_repr import short_repr

Negatives = Literal["random", "hard"]
"""``random``: the corpus's own, the paper's protocol. ``hard``: other plausible groundings
in the same scene, made from the positives (:func:`g3.negatives.hard_negatives.hard_negatives`)."""
NEGATIVES: tuple[Negatives, ...] = get_args(Negatives)


@short_repr
@dataclass(frozen=True, slots=True)
class Options:
    """Choice of a model's examples and features: see `corpus_tools.options`."""

    negatives: Negatives = "random"
    seed: int = 0
    ablated: tuple[str, ...] = ()
    added: tuple[str, ...] = ()


_STREAM = 1
"""Distinguishes these random numbers from others with the same seed."""


def labelled_examples(
    corpus: Corpus, *, negatives: Negatives = "random", seed: int = 0
) -> list[Example]:
    """Collect a corpus's examples.

    Hard negatives are drawn for the whole corpus, so they don't depend on how it is split.

    Parameters
    ----------
    seed
        Seed of the hard negatives.
    """
    items = examples(_annotations(corpus, negatives, seed))
    if not items:
        raise CorpusError(
            "no clause is grounded and labelled, so there is nothing to learn from or to test on",
            where=f"corpus {corpus.name}",
            fix="take a corpus with annotations ('ct corpus stats' counts them)",
        )
    return items


def _annotations(corpus: Corpus, negatives: Negatives, seed: int) -> list[Annotation]:
    if negatives == "random":
        return list(corpus.annotations)
    from g3.negatives.hard_negatives import hard_negatives  # noqa: PLC0415 - brings the simulator of actions

    positives = [a for a in corpus.annotations if a.source == "positive"]
    return [*positives, *hard_negatives(positives, np.random.default_rng([seed, _STREAM]))]


def scenario_ids(items: Iterable[Example]) -> set[str]:
    """Name the scenarios of examples so that equal names of different worlds differ.

    Corpora of different origin may use a name such as ``go_to_truck`` for scenarios of
    their own. Only the same name with the same log is the same scenario.
    """
    contexts = {
        (e.annotation.command.scenario, id(e.annotation.context)): e.annotation.context
        for e in items
    }
    return {f"{name} {_digest(context)}" for (name, _), context in contexts.items()}


def _digest(context: Context) -> str:
    millimetres = [np.rint(1000 * o.trajectory.xyz).astype(np.int64) for o in context.objects]
    return sha256(b" ".join(array.tobytes() for array in millimetres)).hexdigest()[:16]
