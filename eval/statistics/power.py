"""How many pairs and judgments a study needs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import optimize, special

from eval.statistics.estimates import LEVEL

POWER = 0.8


@dataclass(frozen=True, slots=True)
class Plan:
    """A study that is large enough: pairs of command and video, each judged by so many people."""

    pairs: int
    judges: int
    judgments: int
    design_effect: float
    """By how much judgments of the same pair being alike multiplies the variance."""
    half_width: float
    """Of the interval that it gives."""


def design_effect(judges: int, correlation: float) -> float:
    """How much more a share varies if judgments of a pair are alike (L. Kish, 1965, 5.4)."""
    return 1.0 + (judges - 1) * correlation


def plan_interval(half_width: float, *, share: float, judges: int, correlation: float) -> Plan:
    """How many pairs an interval of a share needs to be so narrow.

    The half width is the wanted distance of the bounds from the share that is expected, of which
    0.5 is the worst case; the correlation is between judgments of a pair, within it.
    """
    z = float(special.ndtri((1 + LEVEL) / 2))
    effect = design_effect(judges, correlation)
    variance = share * (1 - share) * effect / judges
    pairs = int(np.ceil(z**2 * variance / half_width**2 - 1e-9))
    pairs = max(pairs, 1)
    reached = z * float(np.sqrt(variance / pairs))
    return Plan(pairs, judges, pairs * judges, effect, reached)


def power_of_difference(n: float, one: float, other: float) -> float:
    """Power to find two shares different with n independent judgments of each.

    The normal approximation with a pooled variance under no difference (J. L. Fleiss, B. Levin
    and M. C. Paik, Statistical Methods for Rates and Proportions, 2003, section 4.2).
    """
    z = float(special.ndtri((1 + LEVEL) / 2))
    middle = (one + other) / 2
    under_none = np.sqrt(2 * middle * (1 - middle))
    spread = np.sqrt(one * (1 - one) + other * (1 - other))
    return float(special.ndtr((np.sqrt(n) * abs(one - other) - z * under_none) / spread))


def judgments_for_difference(one: float, other: float, power: float = POWER) -> float:
    """How many independent judgments of each find two shares different so often."""
    if one == other:
        raise ValueError("the shares are the same: nothing can be found")
    return float(optimize.brentq(lambda n: power_of_difference(n, one, other) - power, 1e-6, 1e9))


def simulated_half_width(
    plan: Plan,
    *,
    share: float,
    correlation: float,
    rng: np.random.Generator,
    studies: int = 2000,
) -> float:
    """The half width that a plan gives in simulated studies.

    Each pair's own share is drawn from a beta distribution with the wanted correlation, its
    judgments from that. The half width is that of the middle 95 % of the studies' shares.
    """
    if correlation <= 0:
        own = np.full((studies, plan.pairs), share)
    else:
        size = 1 / correlation - 1
        own = rng.beta(share * size, (1 - share) * size, size=(studies, plan.pairs))
    shares = rng.binomial(plan.judges, own).mean(axis=1) / plan.judges
    low, high = np.quantile(shares, ((1 - LEVEL) / 2, (1 + LEVEL) / 2))
    return float(high - low) / 2
