"""Plans for a command that can be read in several ways: its SDC trees are summed over.

The share of a plan is that of what it leads to, summed over all trees. So a tree that is probably
wrong decides nothing by itself. The most probable plan is chosen, by its share, its factors and all
words of the text (:mod:`g3.inference.calibration`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from g3.actions.forklift_actions import WAIT
from g3.groundings import FloatArray
from g3.inference.calibration import fit_of_plan, same_end, share_alike
from g3.inference.search.action_search import Hypothesis

PARSES = 4
"""Trees of a text that are summed over, where the best one isn't sure."""
LOOKED_AT = 5
"""Plans of each tree that may be the best."""
PROPOSED = -1
"""Index of the tree that all words together propose (:mod:`g3.inference.ends.proposal`)."""


class Choice(NamedTuple):
    """A plan, and what its probability is calibrated from.

    Parameters
    ----------
    tree
        Index of the tree that it is for; `PROPOSED` for what all words propose.
    hypothesis
        The plan.
    fit
        How well it fits, with the share of the plans of all trees that lead to the same.
    is_first
        True if the search finds it the best one for its tree.
    """

    tree: int
    hypothesis: Hypothesis
    fit: float
    is_first: bool = False


def does_something(plan: Hypothesis) -> bool:
    """Check that a plan is more than waiting."""
    return any(action.kind is not WAIT for action in plan.actions)


def all_plans(
    found: Sequence[tuple[float, Sequence[Hypothesis]]], most: int, *, waits: bool = False
) -> list[Choice]:
    """Plans of all trees, tree by tree, the best of each first.

    Parameters
    ----------
    found
        The probability of each tree, and the plans for it, the best first.
    most
        Largest number of plans of each tree. Of several trees those that only wait are left out,
        and those that end like a better plan for the tree, or like one for a more probable tree.
    waits
        True if the command asks to wait.
    """
    choices: list[Choice] = []
    for number, (_, plans) in enumerate(found):
        for rank, plan in enumerate(plans[:most]):
            if len(found) > 1 and (
                not (waits or does_something(plan))
                or any(same_end(plan, better.hypothesis) for better in choices)
            ):
                continue
            share = _share(plan, found)
            choices.append(Choice(number, plan, fit_of_plan(plan, share), rank == 0))
    return choices


def best_plans(trees: Sequence[int], odds: FloatArray, top: int) -> list[int]:
    """Return the most probable plans of the tree that has the most probable one, the best first.

    Parameters
    ----------
    trees
        Index of the tree of each plan.
    odds
        Logarithm of the odds that each is right, shape (plans,).
    top
        Number of plans to return.

    Returns
    -------
    list of int
        Their indices.
    """
    order = np.argsort(-odds, kind="stable").tolist()
    return [i for i in order if trees[i] == trees[order[0]]][:top]


def _share(plan: Hypothesis, found: Sequence[tuple[float, Sequence[Hypothesis]]]) -> float:
    """Return the share of the plans of all trees that end like one."""
    shares = [chance * share_alike(plan, rivals) for chance, rivals in found]
    return sum(shares) / sum(chance for chance, _ in found)
