"""Which outcomes belong to which commands, and in which contexts commands were given."""

from __future__ import annotations

from collections.abc import Mapping

from corpus_tools.corpus.corpus_entries import contexts_by_command, outcomes_among
from corpus_tools.corpus.corpus_model import Corpus
from g3.annotation import Command, TaskOutcome


def outcomes_of(corpus: Corpus, command: Command) -> tuple[TaskOutcome, ...]:
    """What was done for a command, in order: its own outcomes, else those of its video."""
    return outcomes_among(corpus.outcomes, command)


def is_drive(outcome: TaskOutcome) -> bool:
    """Whether the robot only drove: nothing was picked up, and that is known."""
    return not outcome.picked and not {"picked", "put"} & set(outcome.unknown)


def contexts_of_commands(corpus: Corpus) -> Mapping[str, str]:
    """In which context each command was given, by their ids; see :func:`contexts_by_command`."""
    return contexts_by_command(
        corpus.commands, corpus.annotations, corpus.contexts, corpus.outcomes
    )
