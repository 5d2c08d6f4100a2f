"""A corpus in memory."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from g3.annotation import Annotation, Command, Judgment, TaskOutcome
from g3.groundings import Context
from g3.short_repr import short_repr


@short_repr
@dataclass(frozen=True, slots=True)
class Corpus:
    """Commands, the worlds they were given in, their annotations and judgments.

    Make one with :func:`corpus_tools.corpus.encoding.make_corpus`, which computes the
    hash, or read one with :func:`corpus_tools.corpus.corpus_reading.load_corpus`.

    Parameters
    ----------
    name
        What the corpus is called.
    contexts, commands
        By id. Every command that was typed is there, annotated or not.
    annotations
        Each shares the instances of its command and its context, and of the
        context's objects where its groundings are those objects.
    judgments
        People's ratings of commands shown with videos.
    source
        Where the data come from.
    licence
        On what terms they may be used.
    hash
        ``sha256:`` and the digest of the content, the subjects left out. It is the same
        no matter which salt hides the subjects and what the corpus is called.
    outcomes
        What the robot did, where a log shows it; a video's in the order in which it was done.
    """

    name: str
    contexts: Mapping[str, Context]
    commands: Mapping[str, Command]
    annotations: tuple[Annotation, ...]
    judgments: tuple[Judgment, ...]
    source: str
    licence: str
    hash: str
    outcomes: tuple[TaskOutcome, ...] = ()
