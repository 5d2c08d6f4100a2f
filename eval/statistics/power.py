"""Numbers of pairs and judgments that a study needs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import special

from corpus_tools.corpus.estimate import Estimate, Reason, undefined
from eval.statistics.estimates import LEVEL, FloatArray

POWER = 0.8
LEAST_CORRELATION = 1e-9
"""Smallest correlation above none; one as near to 1 is 1."""


@dataclass(frozen=True, slots=True)
class Plan:
    """A large enough study: pairs of command and video, and the number of judges of each."""

    pairs: int
    judges: int
    judgments: int
    design_effect: float
    """Factor on the variance as judgments of a pair are alike."""
    half_width: float
    """Half width of the interval."""


def design_effect(judges: int, correlation: float) -> float:
    """Return the variance's factor for alike judgments of a pair (L. Kish, 1965, 5.4)."""
    return 1.0 + (judges - 1) * correlation


def plan_interval(
    half_width: float, *, share: float, judges: int, correlation: float
) -> Plan | Reason:
    """Plan the pairs for an interval of a half width, or return why none can be planned.

    The half width is the required distance of the bounds from the expected share, of which 0.5 is
    the worst case; the correlation is between judgments of a pair. It doesn't matter for one judge
    of a pair, and may be NaN then; below 0 it counts as 0. A share of 0 or 1 doesn't vary, so that
    nothing follows from it.
    """
    if not 0 < share < 1:
        return "no data" if np.isnan(share) else "all alike"
    if judges == 1:
        correlation = 0.0
    if np.isnan(correlation):
        return "no overlap"
    correlation = max(correlation, 0.0)
    z = float(special.ndtri((1 + LEVEL) / 2))
    effect = design_effect(judges, correlation)
    variance = share * (1 - share) * effect / judges
    pairs = int(np.ceil(z**2 * variance / half_width**2 - 1e-9))
    pairs = max(pairs, 1)
    reached = z * float(np.sqrt(variance / pairs))
    return Plan(pairs, judges, pairs * judges, effect, reached)


def judgments_for_difference(one: float, other: float, power: float = POWER) -> float:
    """Return the independent judgments of each to find a difference with power.

    The normal approximation with a pooled variance under no difference (J. L. Fleiss, B. Levin
    and M. C. Paik, Statistical Methods for Rates and Proportions, 2003, section 4.2).
    """
    if one == other:
        raise ValueError("the shares are the same: nothing can be found")
    middle = (one + other) / 2
    under_none = np.sqrt(2 * middle * (1 - middle))
    spread = np.sqrt(one * (1 - one) + other * (1 - other))
    z, z_of_power = special.ndtri((1 + LEVEL) / 2), special.ndtri(power)
    return float(((z * under_none + z_of_power * spread) / (one - other)) ** 2)


def simulated_half_width(
    plan: Plan,
    *,
    share: float,
    correlation: float,
    rng: np.random.Generator,
    studies: int = 2000,
) -> Estimate:
    """Return the half width of a plan's interval, by simulated studies.

    Each pair's own share is drawn from a beta distribution with the plan's correlation, its
    judgments from that. The half width is that of the middle 95 % of the studies' shares.
    """
    if not 0 < share < 1:
        return undefined("all alike")
    drawn = own_shares(share, correlation, (studies, plan.pairs), rng)
    shares = rng.binomial(plan.judges, drawn).mean(axis=1) / plan.judges
    low, high = np.quantile(shares, ((1 - LEVEL) / 2, (1 + LEVEL) / 2))
    return Estimate(float(high - low) / 2)


def own_shares(
    share: npt.ArrayLike, correlation: float, shape: tuple[int, ...], rng: np.random.Generator
) -> FloatArray:
    """Draw shares of clusters from beta distributions with a correlation within them.

    The shares that are expected broadcast to the shape. With a correlation of 0 each cluster has
    them; with one of 1 all in a cluster are equal.
    """
    expected = np.broadcast_to(np.asarray(share, dtype=np.float64), shape)
    if not correlation > LEAST_CORRELATION:
        return expected
    size = 1 / correlation - 1
    if size < LEAST_CORRELATION:
        return (rng.random(shape) < expected).astype(np.float64)
    inside = np.clip(expected, LEAST_CORRELATION, 1 - LEAST_CORRELATION)
    return rng.beta(inside * size, (1 - inside) * size)
