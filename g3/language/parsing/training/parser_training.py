"""Training of the parser from annotated trees."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from g3.annotation import Command
from g3.errors import CorpusError, ModelError
from g3.language.parsing.arc_model import ArcModel
from g3.language.parsing.clause_arcs import ROOT, Arcs, read_arcs
from g3.language.parsing.encoder import Encoder, default_encoder
from g3.language.parsing.perturbation import perturb
from g3.language.parsing.training.arc_training import BATCH, ArcExample, train
from g3.language.parsing.training.encoder_training import layer_weights, with_layers
from g3.language.parsing.words import Words, cut
from g3.sdc.clauses import SDC
from g3.short_repr import short_repr

EPOCHS, LEAST_STEPS, LEAST_STEPS_OF_LAYERS = 8, 240, 60
"""Passes through the commands, and steps that they make at least: without and with layers of the
encoder, which take longer."""
ENOUGH = 100
"""Commands from which the encoder learns, too; fewer teach the choice of arcs in less time."""
JOINED = 0.7
"""Texts of several commands for each command."""
SEED = 0
TreeOf = tuple[str | Command, tuple[SDC, ...]]
"""A command and its top-level clauses, as annotated."""
RETYPED = 3
"""One command in so many is learned from again without articles, another one without
punctuation."""


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class Lesson:
    """A command with annotated trees, ready to be learned from.

    Parameters
    ----------
    command
        The command's words.
    sdcs
        Its top-level clauses.
    arcs
        The arcs that they give the words.
    """

    command: Words
    sdcs: tuple[SDC, ...]
    arcs: Arcs


def prepare(commands: Sequence[TreeOf | Lesson]) -> list[Lesson]:
    """Cut commands that have annotated trees; what is prepared already stays as it is."""
    return [one if isinstance(one, Lesson) else _prepared(*one) for one in commands]


def _prepared(command: str | Command, sdcs: tuple[SDC, ...]) -> Lesson:
    words = cut(command.text if isinstance(command, Command) else command)
    return Lesson(words, sdcs, read_arcs(sdcs, words.spans))


def retyped(lessons: Sequence[Lesson]) -> list[Lesson]:
    """Return some lessons once more, without their articles or their punctuation."""
    ways = [
        _retyped(lesson, kind)
        for start, kind in enumerate(("articles", "run-on"))
        for lesson in lessons[start::RETYPED]
    ]
    return [again for again in ways if again]


@lru_cache(maxsize=4096)
def _retyped(lesson: Lesson, kind: str) -> Lesson | None:
    typed = perturb(lesson.command.text, kind, sdcs=lesson.sdcs)
    again = (typed.text, typed.carry(lesson.sdcs))
    return prepare([again])[0] if typed.text != lesson.command.text else None


def joined(lessons: Sequence[Lesson], rng: np.random.Generator) -> list[tuple[Words, Arcs]]:
    """Return two or three commands at a time as one text, so that long texts are learned."""
    found = []
    for _ in range(round(JOINED * len(lessons))):
        chosen = rng.choice(
            len(lessons), size=min(len(lessons), int(rng.integers(2, 4))), replace=False
        )
        parts = [lessons[i] for i in chosen]
        command = cut(" ".join(part.command.text for part in parts))
        heads: list[int] = []
        for part in parts:
            first = len(heads)
            heads += [head if head == ROOT else head + first for head in part.arcs.heads]
        labels = [label for part in parts for label in part.arcs.labels]
        if len(command.forms) == len(labels):  # no part of it is left out
            found.append((command, Arcs(tuple(heads), tuple(labels))))
    return found


def learned(
    lessons: Sequence[Lesson],
    others: Sequence[Lesson],
    *,
    start: ArcModel,
    layers: int | None,
    l2: float,
) -> tuple[ArcModel, Encoder]:
    """Train as :meth:`g3.language.parsing.sdc_parser.SDCParser.fit` says."""
    usable, besides = (
        [lesson for lesson in part if lesson.command.forms and lesson.sdcs]
        for part in (lessons, others)
    )
    if not usable:
        raise CorpusError(
            "there are no commands with annotated SDC trees", fix="take a corpus with annotations"
        )
    rng = np.random.default_rng(SEED)
    taught = [
        (command, arcs, strange)
        for part, strange in ((usable, False), (besides, True))
        for command, arcs in (
            *((lesson.command, lesson.arcs) for lesson in (*part, *retyped(part))),
            *joined(part, rng),
        )
    ]
    encoder = default_encoder()
    if layers is None:
        layers = len(encoder.layers) if len(usable) >= ENOUGH else 0
    kept = len(encoder.layers) - layers
    if not 0 <= kept <= len(encoder.layers):
        raise ModelError(
            f"there are no {layers} layers", fix=f"give at most {len(encoder.layers)} layers"
        )
    states = encoder.all_states((command for command, _, _ in taught), kept)
    examples = [
        ArcExample(state, arcs, strange)
        for state, (_, arcs, strange) in zip(states, taught, strict=True)
    ]
    least = LEAST_STEPS if not layers else LEAST_STEPS_OF_LAYERS
    batches = -(-len(examples) // BATCH)
    epochs = max(EPOCHS, -(-least // batches))
    arcs, last = train(
        examples,
        start,
        [layer_weights(encoder, kept + i) for i in range(layers)],
        l2=l2,
        epochs=epochs,
        rng=rng,
    )
    return arcs, with_layers(encoder, last)
