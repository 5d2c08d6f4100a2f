"""Plans for a command that can be read in several ways: its SDC trees are summed over.

The probability of a plan is that of what it leads to, summed over all trees. So a tree that is
probably wrong decides nothing by itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from g3.actions.forklift_actions import WAIT
from g3.groundings import FloatArray
from g3.inference.calibration import evidence, plan_probability, share_alike
from g3.inference.search.action_search import Hypothesis

PARSES = 3
"""How many trees of a text are summed over, where the best one isn't sure."""
LOOKED_AT = 5
"""How many plans of each tree may be the best."""


class Choice(NamedTuple):
    """A plan, and what its probability is calibrated from.

    Parameters
    ----------
    tree
        Index of the tree that it is for.
    hypothesis
        The plan.
    seen
        Its evidence (:mod:`g3.inference.calibration`).
    """

    tree: int
    hypothesis: Hypothesis
    seen: FloatArray


def does_something(plan: Hypothesis) -> bool:
    """Whether a plan is more than waiting."""
    return any(action.kind is not WAIT for action in plan.actions)


def best_plans(found: Sequence[tuple[float, Sequence[Hypothesis]]], top: int) -> list[Choice]:
    """The plans of the tree that has the best one, the best first.

    Parameters
    ----------
    found
        The probability of each tree, and the plans for it, the best first.
    top
        How many plans to give. Those of a single tree stay in their order.
    """
    choices = [
        Choice(number, plan, _evidence(plan, number, found))
        for number, (_, plans) in enumerate(found)
        for plan in plans[: top if len(found) == 1 else max(top, LOOKED_AT)]
        if len(found) == 1 or does_something(plan)
    ]
    if len(found) > 1:
        choices.sort(key=lambda choice: -plan_probability(choice.seen))
    return [choice for choice in choices if choice.tree == choices[0].tree][:top]


def _evidence(
    plan: Hypothesis, own: int, found: Sequence[tuple[float, Sequence[Hypothesis]]]
) -> FloatArray:
    """A plan's evidence, with the share of the plans of all trees that lead to the same."""
    if len(found) == 1:
        return evidence(plan, share_alike(plan, found[own][1]))
    shares = [chance * share_alike(plan, rivals) for chance, rivals in found]
    return evidence(plan, sum(shares) / sum(chance for chance, _ in found))
