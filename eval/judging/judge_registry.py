"""Judges of plans: verdicts on plans for commands.

``ct eval table3 --judge NAME`` takes its first verdict from one. A judge is a function from an
executed plan to a verdict; :func:`plan_judge` registers one under a name. Modules that other
distributions name in the entry point group ``ct.judges`` register theirs when this one is imported.
A judge that needs more than a function implements :class:`PlanJudge`.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Protocol

from eval.judging.execution import Execution
from eval.judging.judge import Expected, Verdict, judge, judge_outcome, picked_up
from g3.actions.action_kinds import Action
from g3.annotation import Annotation
from g3.groundings import Context
from g3.registry import Registry, blaming
from g3.short_repr import short_repr

AUTOMATIC = "automatic"


@short_repr
@dataclass(frozen=True, slots=True)
class JudgedPlan:
    """A plan for a command, carried out."""

    text: str
    execution: Execution
    """The plan's execution: the worlds before and after, the robot's path, the loads moved."""
    actions: tuple[Action, ...]
    """The executed actions; empty where the execution is known only by its log."""
    context: Context
    """The command's own world, with its log."""
    annotation: Annotation | None = None
    """The command's clauses and groundings by people; None without annotations."""
    done: Expected | None = None
    """Known outcome of the command; None where a log shows it."""

    @property
    def deeds(self) -> Execution:
        """Deprecated name of `execution`."""
        message = "JudgedPlan.deeds goes with the next version; use JudgedPlan.execution"
        warnings.warn(message, DeprecationWarning, stacklevel=2)
        return self.execution


class PlanJudge(Protocol):
    """A judge of plans; processes exchange judges, so that they can be pickled and hashed."""

    @property
    def name(self) -> str:
        """Name in tables."""
        ...

    @property
    def about(self) -> Mapping[str, object]:
        """Settings that decide its verdicts, for readers of the table."""
        ...

    @property
    def at_once(self) -> int:
        """Number of plans that threads may send to it at the same time."""
        ...

    def verdict(self, plan: JudgedPlan) -> Verdict:
        """Judge a plan."""
        ...


JudgeFunction = Callable[[JudgedPlan], Verdict]


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class RegisteredJudge:
    """A function that is registered as a judge."""

    name: str
    description: str
    function: JudgeFunction
    at_once: int = 1
    about: Mapping[str, object] = field(default_factory=dict)

    def __reduce__(self) -> tuple[Callable[[str], RegisteredJudge], tuple[str]]:
        return judge_named, (self.name,)

    def verdict(self, plan: JudgedPlan) -> Verdict:
        """Judge a plan."""
        with blaming(f"the judge {self.name}", f"command {plan.text!r}"):
            return self.function(plan)


JUDGES: Registry[RegisteredJudge] = Registry("judge", "ct.judges")


def plan_judge(name: str) -> Callable[[JudgeFunction], JudgeFunction]:
    """Register a function as a judge.

    Raises
    ------
    ValueError
        If another judge has the name.
    """

    def make(description: str, function: JudgeFunction) -> RegisteredJudge:
        return RegisteredJudge(name, description, function, about={"module": function.__module__})

    return JUDGES.adding(name, make)


def judge_named(name: str) -> RegisteredJudge:
    """Return the judge with a name."""
    return JUDGES.known(name)


@plan_judge(AUTOMATIC)
def automatic(plan: JudgedPlan) -> Verdict:
    """Compare the execution with the command's own log, or with its outcome."""
    start, end = plan.execution.start, plan.execution.end
    if plan.done is None:
        return judge(plan.context, end)
    return judge_outcome(plan.done, picked_up(start, plan.actions, end), start, end)


JUDGES.load_others()
