"""Judges: whatever says whether a plan does what a command asks for.

``ct eval --table 3 --judge NAME`` asks one for its first verdict. A judge is a function from what
was done to a verdict; :func:`plan_judge` registers one under a name. Modules that other
distributions name in the entry point group ``ct.judges`` register theirs when this one is imported.
What is more than a function is a :class:`PlanJudge`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Protocol

from eval.judging.execution import Execution
from eval.judging.judge import Verdict, judge
from eval.judging.outcome_judge import Expected, judge_outcome
from eval.judging.picked_up import picked_up
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
    deeds: Execution
    """What was done: the worlds before and after, the robot's way, the loads that were moved."""
    actions: tuple[Action, ...]
    """What was done as actions; none where it is known only by its log."""
    context: Context
    """The command's own world, with its log."""
    annotation: Annotation | None = None
    """The command's clauses and groundings by people; None if nobody has annotated it."""
    done: Expected | None = None
    """What is known of what was done for the command; None where the log shows it."""


class PlanJudge(Protocol):
    """What judges plans; processes hand it to each other, so that it can be pickled and hashed."""

    @property
    def name(self) -> str:
        """What tables call it."""
        ...

    @property
    def about(self) -> Mapping[str, object]:
        """What decides of its verdicts, for people who read the table."""
        ...

    @property
    def at_once(self) -> int:
        """How many plans it may be asked about at the same time, by threads."""
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
        """Judge a plan.

        Raises
        ------
        CorpusError
            If the function raises anything.
        """
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
    """The judge with a name.

    Raises
    ------
    CorpusError
        If there is none.
    """
    return JUDGES.known(name)


@plan_judge(AUTOMATIC)
def automatic(plan: JudgedPlan) -> Verdict:
    """Compare what was done with the command's own log, or with its outcome."""
    start, end = plan.deeds.start, plan.deeds.end
    if plan.done is None:
        return judge(plan.context, end)
    return judge_outcome(plan.done, picked_up(start, plan.actions, end), start, end)


JUDGES.load_others()
