"""Calibrated probability that a plan does as the words say.

Factors are not independent, and the search takes the best of many: the product of their
probabilities says less than it seems. A logistic model of a plan's evidence is fitted to all plans
that are compared for commands that imitate people. It also chooses among the trees of a text. All
of these commands can be followed, so what makes no sense at all is less probable than the model
says.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.special import expit, log_expit, logsumexp

from g3.actions.forklift_actions import TURN, WAIT
from g3.actions.grounding_candidates import beneath
from g3.actions.robot_state import State
from g3.geometry.footprints import centre
from g3.geometry.plane import BoolArray, wrap
from g3.geometry.relations import OTHER_PLACE_M
from g3.groundings import FloatArray, PhysicalObject, Place
from g3.inference.search.action_search import Hypothesis

WEIGHTS = {
    "one": 2.30,
    "fit": 0.56,
    "left aside": -0.64,
    "ambiguous": -0.16,
    "untaught": -5.00,
    "end": 0.40,
    "first": 0.72,
}
"""Weights of the evidence.

They are those of a grid by which most plans are right for a third of the commands of `CHOICE`
(`benchmarks.written_commands`), half of those of aaai11, and half of those of its automatic part.
Their scale is set by hand, so that .93 of the plans of .9 and more are right there; and the weight
of "untaught", with few such plans: a plan that ignores a relation must not seem sure.
``python -m benchmarks.plan_weights`` fits weights to other names.
"""
LEAST_FIT = 0.047
"""A plan that fits its tree less well than this is no answer by itself."""
SLOPES_L2 = 1.0
"""Penalty that keeps slopes small where a curve is fitted to few plans."""

SAME_HEADING_RAD, SAME_HEIGHT_M = np.deg2rad(20), 0.2
"""Largest differences of equal headings and of equal heights of the forks, if a command specifies
these."""


def fit_of_plan(hypothesis: Hypothesis, share: float) -> float:
    """Return how well a plan fits its tree, from 0 to 1.

    It is the share of all plans that lead to the same, times the square root of the factors' mean
    probability (geometric).

    Parameters
    ----------
    hypothesis
        The plan.
    share
        Share of all plans that lead to the same.
    """
    scores = np.array([score for _, score in hypothesis.nodes.values()] or [0.0])
    return float(np.exp(scores.mean() / 2) * share)


def evidence(
    fit: float,
    *,
    aside: int = 0,
    is_ambiguous: bool = False,
    untaught: float = 0.0,
    end: float = 0.0,
    is_first: bool = False,
) -> FloatArray:
    """Return the evidence of a plan, one value for each of `WEIGHTS`.

    Parameters
    ----------
    fit
        How well it fits its tree. Its logarithm counts, from that of `LEAST_FIT` on: where words
        are strange, fits fall by how much differs from corpus to corpus.
    aside
        Number of nouns that name things without a part in the plan.
    is_ambiguous
        True if it isn't clear which thing is meant.
    untaught
        Share of the words of relations that have neither a feature nor a rule.
    end
        Logarithm of the probability that all words lead there (:mod:`g3.inference.ends`).
    is_first
        True if the search finds it the best one for its tree.
    """
    told = float(np.log(max(fit, LEAST_FIT)))
    doubts = (float(aside), float(is_ambiguous), untaught)
    return np.array([1.0, told, *doubts, end, float(is_first)])


def share_alike(hypothesis: Hypothesis, rivals: Sequence[Hypothesis]) -> float:
    """Return the share of plans with the same end as one; 0 if there are none."""
    alike = [r.score for r in rivals if same_end(hypothesis, r)]
    return float(np.exp(logsumexp(alike) - logsumexp([r.score for r in rivals]))) if alike else 0.0


def same_end(plan: Hypothesis, other: Hypothesis) -> bool:
    """Check that two plans end alike: every load in the same place and on the same thing.

    The robot's end counts only if neither handles a load, and its heading only where it turns last
    but for waiting, or words ask for that. A step of a metre leads elsewhere than none.
    """
    here, there = plan.state, other.state
    if here.held != there.held:
        return False
    own = {here.context.agent_id, here.held}
    for a, b in zip(here.context.objects, there.context.objects, strict=True):
        if a is not b and a.id not in own and not _same_place(a, b, here, there):
            return False
    if any(action.object_id for action in (*plan.actions, *other.actions)):
        return True
    moves = ([a for a in own.actions if a.kind is not WAIT] for own in (plan, other))
    last = tuple(action for own_moves in moves for action in own_moves[-1:])
    if any(action.kind.on_request or action.kind is TURN for action in last):
        turned = abs(wrap(here.pose[2:] - there.pose[2:])[0])
        if turned > SAME_HEADING_RAD or abs(here.forks_m - there.forks_m) > SAME_HEIGHT_M:
            return False
    apart = float(np.linalg.norm(here.pose[:2] - there.pose[:2]))
    steps = [abs(a.amount) for a in last if a.kind.unit == "m" and not a.kind.moves_forks]
    return apart < min([OTHER_PLACE_M, *(step / 2 for step in steps)])


def _same_place(a: PhysicalObject, b: PhysicalObject, here: State, there: State) -> bool:
    under = [beneath(Place(x.prism), s, x.id) for x, s in ((a, here), (b, there))]
    on = {thing.id if thing else None for thing in under}
    apart = float(np.linalg.norm(centre(a.prism) - centre(b.prism)))
    return len(on) == 1 and (None not in on or apart < OTHER_PLACE_M)


def odds(seen: FloatArray) -> FloatArray:
    """Return the logarithm of the odds that plans are right.

    Parameters
    ----------
    seen
        Evidence of the plans, shape (..., len(WEIGHTS)).
    """
    result: FloatArray = seen @ np.array(list(WEIGHTS.values()))
    return result


def plan_probability(seen: FloatArray) -> float:
    """Return the calibrated probability of a plan from its evidence, shape (len(WEIGHTS),)."""
    return float(expit(odds(seen)))


def fit_curve(seen: FloatArray, correct: BoolArray, counts: FloatArray | None = None) -> FloatArray:
    """Fit the weights of a curve to plans, shape (d,).

    Parameters
    ----------
    seen
        Evidence of the plans, shape (n, d), the first column ones.
    correct
        True for right ones, shape (n,).
    counts
        Weight of each, shape (n,); one if left out.
    """
    from scipy.optimize import minimize  # noqa: PLC0415 - as in g3.learning.crf

    sign = np.where(correct, 1.0, -1.0)
    times = np.ones(len(sign)) if counts is None else counts

    def loss(weights: FloatArray) -> tuple[float, FloatArray]:
        odds = sign * (seen @ weights)
        slopes = np.array([0.0, *weights[1:]])
        value = -(times * log_expit(odds)).sum() + SLOPES_L2 * (slopes**2).sum() / 2
        return float(value), -(times * sign * expit(-odds)) @ seen + SLOPES_L2 * slopes

    weights: FloatArray = minimize(loss, np.zeros(seen.shape[1]), jac=True).x
    return weights
