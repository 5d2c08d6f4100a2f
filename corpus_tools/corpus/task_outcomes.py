"""Outcomes of commands, and the contexts in which commands were given."""

from __future__ import annotations

from collections.abc import Mapping

from corpus_tools.corpus.corpus_entries import contexts_by_command, outcomes_among
from corpus_tools.corpus.corpus_model import Corpus
from g3.annotation import Command, TaskOutcome


def outcomes_of(corpus: Corpus, command: Command) -> tuple[TaskOutcome, ...]:
    """Return a command's outcomes in order: those that name it, else those of its video."""
    return outcomes_among(corpus.outcomes, command)


def is_drive(outcome: TaskOutcome) -> bool:
    """Check that the robot only drove: nothing was picked up, and that is known."""
    return not outcome.picked and not {"picked", "put"} & set(outcome.unknown)


def contexts_of_commands(corpus: Corpus) -> Mapping[str, str]:
    """Return the id of each command's context; see :func:`contexts_by_command`."""
    return contexts_by_command(
        corpus.commands, corpus.annotations, corpus.contexts, corpus.outcomes
    )
