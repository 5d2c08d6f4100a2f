"""Grounders: makers of plans for commands. Each can be a row of Table 3.

A grounder is a function from a task to actions. :func:`grounder` registers one under a name, for
``ct eval table3 --grounder NAME``. Modules that other distributions name in the entry point
group ``ct.grounders`` register theirs when this one is imported. A grounder that needs more than a
function implements :class:`PlanGrounder`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Protocol

from corpus_tools.runtime.progress import OnProgress
from g3.actions.action_kinds import Action
from g3.actions.robot_state import State
from g3.annotation import Annotation
from g3.groundings import PhysicalObject
from g3.language.lexicon.field_words import bare
from g3.registry import Registry, blaming
from g3.short_repr import short_repr


@short_repr
@dataclass(frozen=True)
class PlanTask:
    """A command to follow, and the world in which it is given.

    Parameters
    ----------
    start
        The world when the command is given. It holds no log, so nothing of the execution.
    loads
        Loads that could be picked up.
    command, scenario
        Ids of the command and of the scenario in its video.
    heading
        Rule of the robot's heading, where a table has several; else empty.
    """

    text: str
    start: State
    loads: Sequence[PhysicalObject]
    command: str = ""
    scenario: str = ""
    heading: str = ""

    @cached_property
    def words(self) -> list[str]:
        """The command's words in lower case, without punctuation."""
        return [w for word in self.text.split() if (w := bare(word))]

    @cached_property
    def others(self) -> tuple[PhysicalObject, ...]:
        """All things but the robot and the loads."""
        own = {self.start.context.agent_id, *(o.id for o in self.loads)}
        return tuple(o for o in self.start.context.objects if o.id not in own)


@short_repr
@dataclass(frozen=True, slots=True)
class Proposal:
    """A plan that a grounder proposes.

    Parameters
    ----------
    actions
        Actions in order; none refuses the command.
    probability
        Probability that the plan is right; 0 if unknown.
    note
        Reason for a missing plan.
    """

    actions: Sequence[Action] = ()
    probability: float = 0.0
    note: str = ""


Propose = Callable[..., Proposal | Sequence[Action]]
"""A function from a task, and a learned value if the grounder learns, to a plan."""
Fit = Callable[[Sequence[Annotation]], Any]
"""A function from annotated commands, without the tested scenario, to a learned value."""


class PlanGrounder(Protocol):
    """A maker of plans; processes exchange grounders, which can be pickled and hashed.

    By default a grounder can be run, needs no preparation and doesn't learn.
    """

    @property
    def name(self) -> str:
        """Name of its row."""

    @property
    def about(self) -> Mapping[str, object]:
        """Settings that decide its plans, for readers of the table."""

    @property
    def learns(self) -> bool:
        """True if it learns from annotated commands."""
        return False

    def missing(self) -> str:
        """Return why the grounder can't be run here; empty if it can."""
        return ""

    def prepare(self, tasks: Sequence[PlanTask], on_progress: OnProgress) -> None:
        """Get ready for all tasks at once, before they come one by one."""

    def fit(self, annotations: Sequence[Annotation]) -> Any:
        """Learn."""
        return None

    def propose(self, task: PlanTask, learned: Any) -> Proposal:
        """Make a plan."""


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class RegisteredGrounder:
    """A function that is registered as a grounder; the parameters are those of :func:`grounder`."""

    name: str
    description: str
    function: Propose
    fitting: Fit | None
    missing: Callable[[], str]
    about: Mapping[str, object] = field(default_factory=dict)

    def __reduce__(self) -> tuple[Callable[[str], RegisteredGrounder], tuple[str]]:
        return grounder_named, (self.name,)

    @property
    def learns(self) -> bool:
        """True if it learns from annotated commands."""
        return self.fitting is not None

    def prepare(self, tasks: Sequence[PlanTask], on_progress: OnProgress) -> None:
        """Do nothing: a function takes one task after the other."""

    def fit(self, annotations: Sequence[Annotation]) -> Any:
        """Learn."""
        with blaming(f"the grounder {self.name}", "learning"):
            return None if self.fitting is None else self.fitting(annotations)

    def propose(self, task: PlanTask, learned: Any) -> Proposal:
        """Make a plan."""
        with blaming(f"the grounder {self.name}", f"command {task.command}"):
            result = self.function(task, learned) if self.learns else self.function(task)
        return result if isinstance(result, Proposal) else Proposal(result)


GROUNDERS: Registry[RegisteredGrounder] = Registry("grounder", "ct.grounders")


def grounder(
    name: str, *, fit: Fit | None = None, missing: Callable[[], str] = str
) -> Callable[[Propose], Propose]:
    """Register a function as a grounder.

    Parameters
    ----------
    name
        Name of its row in Table 3.
    fit
        Function to learn with. Its result is the grounder function's second argument.
    missing
        Returns the missing requirement, such as a package; empty if there is none.

    Raises
    ------
    ValueError
        If another grounder has the name.
    """

    def make(description: str, function: Propose) -> RegisteredGrounder:
        about = {"module": getattr(function, "__module__", "")}
        return RegisteredGrounder(name, description, function, fit, missing, about)

    return GROUNDERS.adding(name, make)


def grounder_named(name: str) -> RegisteredGrounder:
    """Return the grounder with a name."""
    return GROUNDERS.known(name)
