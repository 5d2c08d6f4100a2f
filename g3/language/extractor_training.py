"""Training of the extractor from annotated trees."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from g3.errors import CorpusError
from g3.language.attachment_training import train_attachments
from g3.language.extractor import Extractor
from g3.language.lessons import written_trees
from g3.language.pipeline import Analysis, analyse
from g3.language.role_training import train_roles
from g3.language.roles import Reading, read_roles
from g3.language.word_features import Features, features
from g3.sdc import SDC

DEFAULT_L2 = 1.0
LEAST = 2
"""How often a feature must occur to have a weight."""


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


@lru_cache(maxsize=1)
def _written() -> tuple[Lesson, ...]:
    return tuple(prepare(written_trees()))


def train_extractor(
    lessons: Sequence[Lesson],
    *,
    l2: float = DEFAULT_L2,
    card: Mapping[str, object] | None = None,
) -> Extractor:
    """Train an extractor on some lessons and those written for all (:mod:`g3.language.lessons`).

    Parameters
    ----------
    lessons
        What to learn from.
    l2
        Strength of the regularisation.
    card
        What to record of the training.

    Raises
    ------
    CorpusError
        If there is nothing to learn from.
    """
    taught = [lesson for lesson in lessons if lesson.command.lower and lesson.sdcs]
    if not taught:
        raise CorpusError(
            "there are no commands with annotated SDC trees", fix="take a corpus with annotations"
        )
    taught += _written()
    found = Features(
        np.concatenate([lesson.features.roles for lesson in taught]),
        np.concatenate([lesson.features.moves for lesson in taught]),
        np.concatenate([lesson.features.vectors for lesson in taught]),
    )
    roles = train_roles(found, [lesson.reading.roles for lesson in taught], l2=l2, least=LEAST)
    attachments = train_attachments(
        [lesson.command for lesson in taught], [lesson.reading for lesson in taught], l2=l2
    )
    return Extractor(roles, attachments, dict(card or {}))
