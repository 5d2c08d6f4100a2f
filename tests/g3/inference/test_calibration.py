"""What tells how probably a plan is right."""

import numpy as np
import pytest

from g3.actions.action_kinds import Action
from g3.actions.forklift_actions import BACK_UP, CARRY, DRIVE_TO, PICK_UP, TURN, WAIT
from g3.actions.robot_state import State, moved_to, with_moved
from g3.groundings import Context
from g3.inference.calibration import (
    LEAST_FIT,
    evidence,
    fit_curve,
    fit_of_plan,
    plan_probability,
    same_end,
    share_alike,
)
from g3.inference.search.action_search import Hypothesis
from tests import worlds


def thing(name, x, y, size=1.0, height=1.0, bottom=0.0):
    return worlds.thing(name, name, x, y, (size, size), (bottom, bottom + height))


START = State(
    Context(
        "yard",
        (
            thing("robot", 0, 0),
            thing("tires", 9, 3),
            thing("boxes", 9, -3),
            thing("truck", 20, 0, 6),
        ),
        (),
        "robot",
    ),
    None,
)


def put(name, x, y, bottom=0.0, score=0.0):
    moved = moved_to(START.thing(name), np.array([x, y, 0.0]), bottom)
    return Hypothesis(score, with_moved(START, {name: moved}, None), (Action(CARRY, name),))


def driven(x, y, kind=DRIVE_TO, score=0.0):
    moved = moved_to(START.thing("robot"), np.array([x, y, 0.0]), 0.0)
    return Hypothesis(score, with_moved(START, {"robot": moved}, None), (Action(kind),))


def stepped(x, yaw=0.0, kind=BACK_UP, amount=0.0):
    moved = moved_to(START.thing("robot"), np.array([x, 0.0, yaw]), 0.0)
    return Hypothesis(
        0.0, with_moved(START, {"robot": moved}, None), (Action(kind, amount=amount),)
    )


def lifted(name):
    return Hypothesis(0.0, State(START.context, name), (Action(PICK_UP, name),))


@pytest.mark.parametrize(
    ("plan", "other", "same"),
    [
        (put("tires", 5, 5), put("tires", 6, 6), True),
        (put("tires", 5, 5), put("tires", 5, 8), False),
        (put("tires", 5, 5), put("boxes", 5, 5), False),
        # Anywhere on the truck, which is 6 m wide; but not beside it.
        (put("tires", 18, 0, 1.0), put("tires", 22, 0, 1.0), True),
        (put("tires", 18, 0, 1.0), put("tires", 16, 0), False),
        (lifted("tires"), lifted("tires"), True),
        (lifted("tires"), lifted("boxes"), False),
        (driven(5, 0), driven(6, 0), True),
        (driven(5, 0), driven(9, 0), False),
        # A step or a turn leads elsewhere than staying, however small.
        (stepped(-1, amount=-1), stepped(0, kind=WAIT), False),
        (stepped(-4, amount=-4), stepped(-3, amount=-3), True),
        (stepped(0, np.pi / 2, TURN, np.pi / 2), stepped(0, kind=WAIT), False),
        (stepped(0, np.pi / 2, TURN, np.pi / 2), stepped(0, 1.5, TURN, 1.5), True),
    ],
)
def test_plans_lead_to_the_same_if_loads_do(plan, other, same):
    assert same_end(plan, other) is same
    assert same_end(other, plan) is same


def test_evidence_is_how_well_it_fits_and_how_much_leads_there():
    best, alike, another = (
        put("tires", 5, 5, score=np.log(0.5)),
        put("tires", 6, 6, score=np.log(0.25)),
        put("boxes", 5, 5, score=np.log(0.25)),
    )
    best = Hypothesis(
        best.score, best.state, best.actions, {0: ((), np.log(0.5)), 2: ((), np.log(0.125))}
    )
    fit = fit_of_plan(best, share_alike(best, [best, alike, another]))
    assert fit == pytest.approx(0.75 * np.sqrt(0.25))


def test_probability_falls_with_how_well_it_fits_and_with_how_much_leads_elsewhere():
    def plan(quality, elsewhere):
        best, other = put("tires", 5, 5), put("boxes", 5, 5, score=np.log(elsewhere))
        told = Hypothesis(0.0, best.state, best.actions, {0: ((), np.log(quality))})
        fit = fit_of_plan(told, share_alike(told, [told, other]))
        return plan_probability(evidence(fit))

    assert plan(0.9, 0.01) > plan(0.5, 0.01) > plan(0.01, 0.01)
    assert plan(0.9, 0.01) > plan(0.9, 0.5)


@pytest.mark.parametrize(
    "doubt", [{"aside": 1}, {"is_ambiguous": True}, {"untaught": 1}, {"end": -2.0}]
)
def test_what_speaks_against_a_plan_makes_it_less_probable(doubt):
    assert plan_probability(evidence(1.0, **doubt)) < plan_probability(evidence(1.0))


def test_what_fits_nothing_is_no_answer():
    told = Hypothesis(0.0, START, (), {0: ((), np.log(1e-6))})
    assert fit_of_plan(told, 1e-6) < LEAST_FIT < fit_of_plan(put("tires", 5, 5), 1.0)


def test_a_curve_weighs_plans_as_often_as_they_count():
    seen = np.column_stack((np.ones(4), [0.2, 0.8, 0.2, 0.8]))
    correct = np.array([False, True, True, False])
    thrice = np.array([0, 1, 0, 1, 0, 1, 2, 3])
    counted = fit_curve(seen, correct, np.array([3.0, 3.0, 1.0, 1.0]))
    assert counted == pytest.approx(fit_curve(seen[thrice], correct[thrice]), abs=1e-4)
    assert counted[1] > 0.1 > abs(fit_curve(seen, correct)[1])


def test_a_curve_finds_the_odds_that_plans_were_made_with():
    rng = np.random.default_rng(0)
    seen = np.column_stack((np.ones(4000), rng.normal(size=(4000, 2))))
    odds = seen @ [0.5, 1.0, -1.0]
    correct = rng.uniform(size=4000) < 1 / (1 + np.exp(-odds))
    assert fit_curve(seen, correct) == pytest.approx([0.5, 1.0, -1.0], abs=0.15)
