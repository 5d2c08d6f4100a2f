"""Which outcomes belong to which commands, and in which contexts commands were given."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping

from corpus_tools.corpus.corpus_model import Corpus
from g3.annotation import Command, TaskOutcome


def belongs_to(outcome: TaskOutcome, command: Command) -> bool:
    """Whether an outcome is a command's: its own, or that of its video."""
    if outcome.command:
        return outcome.command == command.id
    return outcome.scenario == command.scenario and outcome.video in ("", command.video)


def outcomes_of(corpus: Corpus, command: Command) -> tuple[TaskOutcome, ...]:
    """What was done for a command, in order: its own outcomes, else those of its video."""
    found = [o for o in corpus.outcomes if belongs_to(o, command)]
    own = [o for o in found if o.command]
    return tuple(own or found)


def is_drive(outcome: TaskOutcome) -> bool:
    """Whether the robot only drove: nothing was picked up, and that is known."""
    return not outcome.picked and not {"picked", "put"} & set(outcome.unknown)


def contexts_of_commands(corpus: Corpus) -> Mapping[str, str]:
    """Find in which context each command was given.

    Returns
    -------
    mapping
        From a command's id to a context's: that of its annotations, else of its outcomes,
        else of its scenario's other commands, else the one with its scenario's name.
        Commands whose context is unknown are missing.
    """
    annotated: dict[str, str] = {}
    by_scenario: dict[str, str] = {}
    for annotation in corpus.annotations:
        annotated.setdefault(annotation.command.id, annotation.context.id)
        by_scenario.setdefault(annotation.command.scenario, annotation.context.id)
    told: dict[str, list[TaskOutcome]] = defaultdict(list)
    for outcome in corpus.outcomes:
        told[outcome.scenario].append(outcome)
    found = {}
    for command in corpus.commands.values():
        own = [o.context for o in told[command.scenario] if belongs_to(o, command)]
        named = command.scenario if command.scenario in corpus.contexts else None
        context = annotated.get(command.id) or next(
            iter(own), by_scenario.get(command.scenario, named)
        )
        if context is not None:
            found[command.id] = context
    return found
