"""Plans carried out: checked before anything moves, then in physics."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from corpus_tools.following.bundled_grounder import to_script
from corpus_tools.world.physics.rehearsal import rehearse
from g3.actions.action_kinds import Action
from g3.actions.robot_state import State
from g3.errors import CorpusError
from g3.inference.grounder import Result

if TYPE_CHECKING:
    from corpus_tools.world.physics.execute import Execution


def why_not(start: State, actions: Sequence[Action]) -> str:
    """Return the reason why a plan can't be carried out; empty if it can.

    The plan is rehearsed with the behaviours of the simulated robot: their tests of free space say
    what the forks reach, where there is room, and where a way leads. This needs no simulator.

    Parameters
    ----------
    start
        The state that the plan begins in.
    actions
        The plan.
    """
    plan = to_script(start, actions)
    problem = rehearse(start.context, plan.script, places=plan.places, forks_m=start.forks_m)
    return "" if problem is None else str(problem)


def checked(result: Result) -> Result:
    """Return the result with the reason of each plan that can't be carried out."""
    start = result.start
    if start is None:
        return result
    plans = (replace(plan, why_not=why_not(start, plan.actions)) for plan in result.plans)
    return replace(result, plans=tuple(plans))


def perform(start: State, actions: Sequence[Action]) -> Execution:
    """Carry a plan out in physics.

    Raises
    ------
    CorpusError
        If MuJoCo isn't installed, or the world can't be simulated.
    """
    try:
        from corpus_tools.world.physics.execute import execute  # noqa: PLC0415 - brings MuJoCo
    except ModuleNotFoundError as error:
        raise CorpusError(
            f"carrying plans out needs the package {error.name}",
            fix="pip install 'corpus-tools-g3[render]', or only plan (ct follow --plan-only)",
        ) from error
    plan = to_script(start, actions)
    return execute(start.context, plan.script, places=plan.places, forks_m=start.forks_m)
