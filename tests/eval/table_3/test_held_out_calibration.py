"""Probabilities of plans from curves that have not seen their scenarios."""

from dataclasses import replace

import numpy as np
import pytest

from eval.table_3.held_out import calibrated
from eval.table_3.outcomes import Outcome, reliability


def outcomes(scenarios, per_scenario=60, seed=0):
    """Plans that are right as often as the second of their evidence says."""
    rng = np.random.default_rng(seed)
    made = []
    for s in range(scenarios):
        for i in range(per_scenario):
            mean, share = rng.normal(0, 2), rng.normal(0, 2)
            right = bool(rng.uniform() < 1 / (1 + np.exp(-mean)))
            seen = (1.0, float(mean), float(share))
            made.append(Outcome(f"c{s}-{i}", f"s{s}", "Go.", 0.5, right, "", evidence=seen))
    return made


def test_what_tells_right_from_wrong_in_other_scenarios_counts():
    found = calibrated(outcomes(5))
    assert reliability(found)[0].value < 0.1
    sure = [o for o in found if o.probability > 0.8]
    assert np.mean([o.correct for o in sure]) > 0.75


def test_a_scenario_with_other_verdicts_has_the_same_order():
    # What the tested scenario's own verdicts are must not matter to its own probabilities'
    # order, and neither must it be punished for going well.
    made = outcomes(4)
    flipped = [replace(o, correct=not o.correct) if o.scenario == "s0" else o for o in made]

    def order(found):
        return np.argsort([o.probability for o in found if o.scenario == "s0"]).tolist()

    assert order(calibrated(made)) == order(calibrated(flipped))


@pytest.mark.parametrize("change", [{"evidence": ()}, {"correct": True}, {"scenario": "one"}])
def test_without_anything_to_fit_probabilities_stay(change):
    made = [replace(o, **change) for o in outcomes(3, 5)]
    assert calibrated(made) == made
