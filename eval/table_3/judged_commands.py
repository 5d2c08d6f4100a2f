"""A corpus's commands for which plans can be judged, with their facts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

from corpus_tools.corpus.annotated_trees import annotated_commands
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.start_headings import parse_heading, with_headings
from corpus_tools.corpus.task_outcomes import contexts_of_commands, outcomes_of
from eval.judging.judge import Expected, expected, picked_in_log
from g3.actions.robot_state import loads_of_context
from g3.annotation import Annotation, Command
from g3.errors import CorpusError
from g3.groundings import Context, PhysicalObject
from g3.short_repr import short_repr

Subset: TypeAlias = Literal["all", "determined", "two-or-more"]
SUBSETS: tuple[Subset, ...] = get_args(Subset)
LOGS, OUTCOMES, BOTH = "logs", "outcomes", "logs and outcomes"
"""References that plans are compared with."""


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class JudgedCommand:
    """A command for which plans can be judged.

    Parameters
    ----------
    annotation
        Clauses and groundings by people; None without annotations.
    done
        The combined outcomes; None where a log replaces them.
    loads
        Loads that could be picked up.
    """

    command: Command
    context: Context
    annotation: Annotation | None
    done: Expected | None
    loads: tuple[PhysicalObject, ...]

    @property
    def picked(self) -> frozenset[str] | None:
        """Ids of the objects picked up; None if they aren't all known."""
        if self.done is None:
            return picked_in_log(self.context)
        return self.done.picked if self.done.is_whole else None


@dataclass(frozen=True, slots=True)
class Facts:
    """A command's facts for rows of Table 3.

    Parameters
    ----------
    person
        Person who typed the command; empty if unknown.
    chance
        Probability that a load drawn at random is exactly the set of loads picked up.
    is_determined
        True if the outcome is fully known.
    has_choice
        True if there are two loads or more.
    """

    person: str = ""
    chance: float = float("nan")
    is_determined: bool = True
    has_choice: bool = False

    def is_in(self, subset: Subset) -> bool:
        """Check that the command belongs to a part of the table."""
        if subset == "all":
            return True
        return self.is_determined if subset == "determined" else self.has_choice


def judged_commands(corpus: Corpus, most: int = 0) -> list[JudgedCommand]:
    """Return commands with known outcomes, and annotated ones, in worlds with things.

    Commands with unknown outcomes are left out.

    Parameters
    ----------
    most
        Number of commands of each scenario; 0 for all.
    """
    result = list(_known(corpus))
    if not result:
        raise CorpusError(
            "no command has an annotation or an outcome in a world with things",
            where=f"corpus {corpus.name}",
            fix="take a corpus with logs and annotations, or one with outcomes.jsonl",
        )
    seen: Counter[str] = Counter()
    kept = []
    for tested in result:
        seen[tested.command.scenario] += 1
        if not most or seen[tested.command.scenario] <= most:
            kept.append(tested)
    return kept


def _known(corpus: Corpus) -> Iterator[JudgedCommand]:
    annotated, contexts = annotated_commands(corpus.annotations), contexts_of_commands(corpus)
    of_context: dict[str, tuple[PhysicalObject, ...]] = {}
    # Annotated commands come in the order of their annotations.
    others = (c for c in corpus.commands.values() if c.id not in annotated)
    for command in (*(a.command for a in annotated.values()), *others):
        annotation, outcomes = annotated.get(command.id), outcomes_of(corpus, command)
        if annotation is None and (not outcomes or command.id not in contexts):
            continue
        if not command.text.strip():
            continue
        done = expected(outcomes) if outcomes else None
        if done is not None and not done.tells:
            continue
        context = annotation.context if annotation else corpus.contexts[contexts[command.id]]
        if len(context.objects) < 2:  # the robot alone, as in a treebank
            continue
        own = of_context.setdefault(context.id, loads_of_context(context))
        yield JudgedCommand(command, context, annotation, done, own)


def facts(tested: JudgedCommand) -> Facts:
    """Return a command's facts for rows of Table 3."""
    count, picked = len(tested.loads), tested.picked
    chance = float("nan")
    if picked is not None:
        chance = 1 / count if len(picked) == 1 and count else 0.0
    is_determined = tested.done is None or tested.done.is_determined
    return Facts(tested.command.subject, chance, is_determined, count > 1)


def compared_with(commands: Sequence[JudgedCommand]) -> str:
    """Return the references of plans for commands: `LOGS`, `OUTCOMES`, or `BOTH`."""
    with_outcomes = sum(c.done is not None for c in commands)
    if with_outcomes == len(commands):
        return OUTCOMES
    return BOTH if with_outcomes else LOGS


def in_headings(corpus: Corpus, headings: Sequence[str]) -> Mapping[str, Corpus]:
    """Return the corpus turned by each rule; unchanged, by the name "", without rules."""
    if not headings:
        return {"": corpus}
    turned = {name: with_headings(corpus, parse_heading(name)) for name in headings}
    if not any((c.agent_id, "heading") in c.assumed for c in corpus.contexts.values()):
        raise CorpusError(
            "the robot's headings are recorded in all of its worlds",
            where=f"corpus {corpus.name}",
            fix="leave --heading out",
        )
    return turned
