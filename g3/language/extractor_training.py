"""Training of the extractor from annotated trees."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from g3.errors import CorpusError
from g3.language.attachment_training import train_attachments
from g3.language.extractor import Extractor
from g3.language.lessons import written_text, written_trees
from g3.language.lexicon import WORD_CLASSES
from g3.language.mending import ALIASES, VOCABULARY
from g3.language.pipeline import Analysis, analyse
from g3.language.role_training import VECTOR_SCALE, train_roles
from g3.language.roles import Reading, read_roles
from g3.language.word_features import MOVE_TEMPLATES, TEMPLATES, Features, features
from g3.sdc import SDC

DEFAULT_L2 = 1.2
LEAST = 2
"""How often a feature must occur to have a weight."""
_SCALES = {1: 1.4, 2: 1.0}
_SMALLEST_SCALE = 0.7
SCALES = tuple(_SCALES.get(len(template), _SMALLEST_SCALE) for template in TEMPLATES)
"""Standard deviations of the priors of weights: what joins many attributes is trusted less."""


@dataclass(frozen=True, slots=True, eq=False)
class Lesson:
    """A command with annotated trees, ready to be learned from.

    Parameters
    ----------
    command
        The analysed command.
    sdcs
        Its top-level clauses.
    reading
        What they say of the command's words.
    features
        Those of the command's words.
    """

    command: Analysis
    sdcs: tuple[SDC, ...]
    reading: Reading
    features: Features


def prepare(commands: Sequence[tuple[str, tuple[SDC, ...]]]) -> list[Lesson]:
    """Analyse commands that have annotated trees."""
    lessons = []
    analyses = analyse(text for text, _ in commands)
    for (_, sdcs), command in zip(commands, analyses, strict=True):
        starts = [span.start for span in command.spans]
        reading = read_roles(sdcs, starts, [span.end for span in command.spans])
        lessons.append(Lesson(command, sdcs, reading, features([command])))
    return lessons


def recipe() -> str:
    """What decides besides the corpus what is learned, as a digest.

    A trained extractor has it in its card, so that one can tell whether it is out of date.
    """
    parts = [written_text(), WORD_CLASSES, ALIASES, VOCABULARY, TEMPLATES, MOVE_TEMPLATES]
    content = json.dumps([*parts, SCALES, VECTOR_SCALE, LEAST])
    return f"sha256:{hashlib.sha256(content.encode()).hexdigest()}"


@lru_cache(maxsize=1)
def _written() -> tuple[Lesson, ...]:
    return tuple(prepare(written_trees()))


def train_extractor(
    lessons: Sequence[Lesson],
    *,
    others: Sequence[Lesson] = (),
    l2: float = DEFAULT_L2,
    card: Mapping[str, object] | None = None,
) -> Extractor:
    """Train an extractor on some lessons and those written for all (:mod:`g3.language.lessons`).

    Parameters
    ----------
    lessons
        What to learn from.
    others
        What to learn from besides, as far as it agrees: annotators of another corpus have other
        habits.
    l2
        Strength of the regularisation.
    card
        What to record of the training.

    Raises
    ------
    CorpusError
        If there is nothing to learn from.
    """
    own, besides = (
        [lesson for lesson in part if lesson.command.lower and lesson.sdcs]
        for part in (lessons, others)
    )
    if not own:
        raise CorpusError(
            "there are no commands with annotated SDC trees", fix="take a corpus with annotations"
        )
    taught = [*own, *_written(), *besides]
    strange = np.arange(len(taught)) >= len(taught) - len(besides)
    found = Features(
        np.concatenate([lesson.features.roles for lesson in taught]),
        np.concatenate([lesson.features.moves for lesson in taught]),
        np.concatenate([lesson.features.vectors for lesson in taught]),
    )
    roles = train_roles(
        found,
        [lesson.reading.roles for lesson in taught],
        l2=l2,
        least=LEAST,
        scales=SCALES,
        strange=np.repeat(strange, [len(lesson.command.lower) for lesson in taught]),
    )
    attachments = train_attachments(
        [lesson.command for lesson in taught], [lesson.reading for lesson in taught], l2=l2
    )
    return Extractor(roles, attachments, {**(card or {}), "recipe": recipe()})
