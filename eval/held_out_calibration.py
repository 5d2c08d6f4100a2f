"""Probabilities of plans from curves that have not seen the plans' scenarios.

The curve that comes along was fitted to plans for the paper's commands, so that on these commands
it says more than it knows. Here the slopes for a scenario's plans are fitted to the plans of all
others. An intercept fitted so is the lower, the better the scenario goes, and would sort scenarios
the wrong way round. A curve that has seen neither of two scenarios has one intercept for both, so
all have one: the mean of those that were fitted without a scenario.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.special import expit

from eval.outcomes import Outcome
from g3.inference.calibration import fit_curve

FEWEST = 3
"""With fewer scenarios the probabilities stay as they are."""


def calibrated(outcomes: Sequence[Outcome]) -> list[Outcome]:
    """Outcomes with probabilities from curves fitted without their scenarios.

    Those that have no evidence keep their probability, and so do all if no plan or every plan is
    right.
    """
    own = [o for o in outcomes if o.evidence]
    scenario = np.array([o.scenario for o in own])
    correct = np.array([o.correct for o in own], dtype=bool)
    if len(set(scenario)) < FEWEST or correct.all() or not correct.any():
        return list(outcomes)
    seen = np.array([o.evidence for o in own])
    odds = np.zeros(len(own))
    intercepts = []
    for name in sorted(set(scenario)):
        tested = scenario == name
        intercept, *slopes = fit_curve(seen[~tested], correct[~tested])
        odds[tested] = seen[tested, 1:] @ slopes
        intercepts.append(intercept)
    given = iter(expit(odds + np.mean(intercepts)).tolist())
    return [replace(o, probability=next(given)) if o.evidence else o for o in outcomes]
