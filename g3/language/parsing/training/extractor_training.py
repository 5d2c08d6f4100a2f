"""Training of the extractor from annotated trees."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from g3.annotation import Command
from g3.errors import CorpusError
from g3.language.lexicon.word_sets import MENDED, WORD_CLASSES
from g3.language.parsing.attachment import AttachmentModel
from g3.language.parsing.mending import ALIASES
from g3.language.parsing.perturbation import perturb
from g3.language.parsing.role_model import RoleModel
from g3.language.parsing.spacy_pipeline import Analysis, analyse
from g3.language.parsing.training.attachment_training import train_attachments
from g3.language.parsing.training.lessons import written_text, written_trees
from g3.language.parsing.training.role_training import VECTOR_SCALE, train_roles
from g3.language.parsing.word_features import MOVE_TEMPLATES, TEMPLATES, Features, features
from g3.language.parsing.word_roles import Reading, read_roles
from g3.sdc.clauses import SDC
from g3.short_repr import short_repr

LEAST = 2
"""How often a feature must occur to have a weight."""
TreeOf = tuple[str | Command, tuple[SDC, ...]]
"""A command and its top-level clauses, as annotated."""
RETYPED = 3
"""One command in so many is learned from again without articles, another one without
punctuation."""
_SCALES = {1: 1.4, 2: 1.0}
_SMALLEST_SCALE = 0.7
SCALES = tuple(_SCALES.get(len(template), _SMALLEST_SCALE) for template in TEMPLATES)
"""Standard deviations of the priors of weights: what joins many attributes is trusted less."""


@short_repr
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


def prepare(commands: Sequence[TreeOf | Lesson]) -> list[Lesson]:
    """Analyse commands that have annotated trees; what is analysed already stays as it is."""
    known = [one for one in commands if isinstance(one, Lesson)]
    trees = [one for one in commands if not isinstance(one, Lesson)]
    texts = (c.text if isinstance(c, Command) else c for c, _ in trees)
    for (_, sdcs), command in zip(trees, analyse(texts), strict=True):
        starts = [span.start for span in command.spans]
        reading = read_roles(sdcs, starts, [span.end for span in command.spans])
        known.append(Lesson(command, sdcs, reading, features([command])))
    return known


def recipe() -> str:
    """What decides besides the corpus what is learned, as a digest.

    A trained extractor has it in its card, so that one can tell whether it is out of date.
    """
    parts = [written_text(), WORD_CLASSES, ALIASES, sorted(MENDED), TEMPLATES, MOVE_TEMPLATES]
    content = json.dumps([*parts, SCALES, VECTOR_SCALE, LEAST, RETYPED])
    return f"sha256:{hashlib.sha256(content.encode()).hexdigest()}"


def retyped(lessons: Sequence[Lesson]) -> list[Lesson]:
    """Some lessons once more, as people type them who leave out articles, or punctuation."""
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


@lru_cache(maxsize=1)
def _written() -> tuple[Lesson, ...]:
    return tuple(prepare(written_trees()))


def learned(
    lessons: Sequence[Lesson], others: Sequence[Lesson], *, l2: float
) -> tuple[RoleModel, AttachmentModel]:
    """Train as :meth:`g3.language.parsing.extractor.SDCExtractor.fit` says."""
    own, besides = (
        [lesson for lesson in part if lesson.command.lower and lesson.sdcs]
        for part in (lessons, others)
    )
    own, besides = ([*part, *retyped(part)] for part in (own, besides))
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
    return roles, attachments
