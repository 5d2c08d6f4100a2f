"""Entries of a corpus: commands with their annotations, contexts and outcomes."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from g3 import html_view
from g3.annotation import Annotation, Command, TaskOutcome
from g3.groundings import Context
from g3.sdc.clauses import SDC
from g3.sdc.sdc_notation import format_brackets
from g3.short_repr import short_repr

if TYPE_CHECKING:
    import pandas as pd


@short_repr
@dataclass(frozen=True, slots=True)
class Entry:
    """A command of a corpus, with its annotations, context and outcomes."""

    command: Command
    """The command as somebody typed it."""
    annotations: tuple[Annotation, ...] = ()
    """Its clauses with groundings, right and wrong ones; none where nobody annotated it."""
    context: Context | None = None
    """The world that it was given in; None if that isn't known."""
    outcomes: tuple[TaskOutcome, ...] = ()
    """Executions by the robot, where a log shows them."""

    @property
    def id(self) -> str:
        """The command's id."""
        return self.command.id

    @property
    def text(self) -> str:
        """The command as typed."""
        return self.command.text

    @property
    def annotation(self) -> Annotation | None:
        """Its right annotation, else the first; None where there is none."""
        right = (a for a in self.annotations if a.source == "positive")
        return next(right, self.annotations[0] if self.annotations else None)

    @property
    def sdcs(self) -> tuple[SDC, ...]:
        """Its clauses, as annotated; none where nobody annotated it."""
        return self.annotation.sdcs if self.annotation else ()

    def _repr_html_(self) -> str:
        """Return a drawing of the annotation, else the command's text."""
        if self.annotation is not None:
            return self.annotation._repr_html_()
        return html_view.heading(self.text, self.id, self.command.scenario, "not annotated")


def entries(
    commands: Mapping[str, Command],
    annotations: Iterable[Annotation],
    contexts: Mapping[str, Context],
    outcomes: Sequence[TaskOutcome],
) -> Iterator[Entry]:
    """Yield an entry for each command, in their order."""
    places = contexts_by_command(commands, annotations := list(annotations), contexts, outcomes)
    by_command: dict[str, list[Annotation]] = defaultdict(list)
    for annotation in annotations:
        by_command[annotation.command.id].append(annotation)
    done: dict[str, list[TaskOutcome]] = defaultdict(list)
    for outcome in outcomes:
        done[outcome.scenario].append(outcome)
    for command in commands.values():
        place = places.get(command.id)
        own_outcomes = outcomes_among(done[command.scenario], command)
        context = None if place is None else contexts[place]
        yield Entry(command, tuple(by_command[command.id]), context, own_outcomes)


def entries_table(found: Iterable[Entry]) -> pd.DataFrame:
    """Make a table with a row for each command: its text, its person, its clauses in brackets."""
    from g3.data_frames import data_frame  # noqa: PLC0415 - needs pandas

    return data_frame(
        {
            "id": entry.id,
            "text": entry.text,
            "scenario": entry.command.scenario,
            "video": entry.command.video,
            "subject": entry.command.subject,
            "context": entry.context.id if entry.context else None,
            "annotations": len(entry.annotations),
            "clauses": " ".join(format_brackets(entry.sdcs).split()),
        }
        for entry in found
    )


def belongs_to(outcome: TaskOutcome, command: Command) -> bool:
    """Check that an outcome belongs to a command or, if it names none, to the command's video."""
    if outcome.command:
        return outcome.command == command.id
    return outcome.scenario == command.scenario and outcome.video in ("", command.video)


def outcomes_among(outcomes: Iterable[TaskOutcome], command: Command) -> tuple[TaskOutcome, ...]:
    """Return a command's outcomes in order: those that name it, else those of its video."""
    matching = [o for o in outcomes if belongs_to(o, command)]
    direct = [o for o in matching if o.command]
    return tuple(direct or matching)


def contexts_by_command(
    commands: Mapping[str, Command],
    annotations: Iterable[Annotation],
    contexts: Mapping[str, Context],
    outcomes: Iterable[TaskOutcome],
) -> dict[str, str]:
    """Find in which context each command was given.

    Returns
    -------
    dict
        From a command's id to a context's: that of its annotations, else of its outcomes,
        else of its scenario's other commands, else its scenario's name.
        Commands whose context is unknown are missing.
    """
    annotated: dict[str, str] = {}
    by_scenario: dict[str, str] = {}
    for annotation in annotations:
        annotated.setdefault(annotation.command.id, annotation.context.id)
        by_scenario.setdefault(annotation.command.scenario, annotation.context.id)
    by_scenario_outcomes: dict[str, list[TaskOutcome]] = defaultdict(list)
    for outcome in outcomes:
        by_scenario_outcomes[outcome.scenario].append(outcome)
    result = {}
    for command in commands.values():
        outcome_contexts = [
            o.context for o in by_scenario_outcomes[command.scenario] if belongs_to(o, command)
        ]
        named = command.scenario if command.scenario in contexts else None
        context = annotated.get(command.id) or next(
            iter(outcome_contexts), by_scenario.get(command.scenario, named)
        )
        if context is not None:
            result[command.id] = context
    return result
