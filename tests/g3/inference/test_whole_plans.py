"""What all words of a text say of whole plans."""

import numpy as np

from corpus_tools.following.plan_steps import carried_out
from g3.actions.action_kinds import Action
from g3.actions.forklift_actions import DRIVE_TO, PICK_UP, PUT_DOWN
from g3.actions.grounding_candidates import square
from g3.inference.potentials.cases import PlanCase, PlanEnd
from g3.inference.potentials.plan_things import left_aside
from g3.inference.potentials.potential_registry import added_by
from g3.inference.potentials.whole_plans import (
    CUES,
    ENDS,
    THINGS,
    of_ends,
    of_things,
)
from tests.g3.inference.ruled import problem_in
from tests.worlds import scene, thing

TRUCK = thing("truck", "truck", 20, 0, (4, 6), (0, 1))
BERM = thing("berm", "berm", 0, 30, (6, 3))
CRATE = thing("crate", "crate", 8, 0)
OTHER = thing("other", "crate", 0, -12)
TIRES = thing("tires", "tire pallet", -8, 0)
PROBLEM = problem_in(scene(TRUCK, BERM, CRATE, OTHER, TIRES))


def spot(x, y, bottom):
    return square(np.array([x, y], dtype=float), 0.0, bottom)


LIFT = (Action(PICK_UP, "crate"),)
ON_TRUCK = (*LIFT, Action(PUT_DOWN, "crate", place=spot(20, 2, 1), goal=0))
ON_GROUND = (*LIFT, Action(PUT_DOWN, "crate", place=spot(20, 12, 0), goal=0))
DRIVE = (Action(DRIVE_TO, target=(BERM,)),)


def case_of(text, *plans):
    ends = [PlanEnd(plan, carried_out(PROBLEM.state, plan)) for plan in plans]
    return PlanCase(tuple(text.split()), ends, PROBLEM)


def test_a_plan_has_one_end():
    case = case_of("lift", LIFT, ON_TRUCK, ON_GROUND, DRIVE)
    table = of_ends(case).reshape(4, len(CUES), len(ENDS))
    own = table[:, CUES.index("any")]
    assert own.argmax(axis=1).tolist() == [0, 1, 2, 3]
    assert own.sum(axis=1).tolist() == [1, 1, 1, 1]
    # "lift" is also a verb of taking, the last one; no other cue is there.
    assert table.sum() == 3 * 4


def test_named_things_have_a_part_in_a_plan_or_none():
    case = case_of("crate truck", LIFT, ON_TRUCK, ON_GROUND, DRIVE)
    rows = [dict(zip(THINGS, row, strict=True)) for row in of_things(case).tolist()]
    assert [row["unnamed"] for row in rows] == [1, 0, 1, 2]
    assert [row["explained"] for row in rows] == [0.5, 1, 0.5, 0]
    assert [row["last"] for row in rows] == [0, 1, 0, 0]
    assert [row["named deck"] for row in rows] == [0, 1, 0, 0]


def test_what_is_handled_last_is_what_is_put():
    back = Action(PUT_DOWN, "crate", place=spot(8, 12, 0), goal=0)
    moved = (*ON_GROUND, Action(PICK_UP, "tires"), Action(PUT_DOWN, "tires", place=spot(-8, 9, 0)))
    again = (*moved, Action(PICK_UP, "crate"), back)
    plans = case_of("lift", ON_GROUND, moved, again).plans
    assert [plan.put for plan in plans] == ["crate", "tires", "crate"]
    assert plans[2].handled == ["crate", "tires"]


def test_a_deck_that_no_word_names_is_another_one():
    rows = of_things(case_of("crate berm", ON_TRUCK, ON_GROUND)).tolist()
    assert [row[THINGS.index("other deck")] for row in rows] == [1, 0]


def test_who_is_told_to_put_something_on_a_truck_does_that():
    case = case_of("crate onto the truck please put it there", LIFT, ON_TRUCK, ON_GROUND, DRIVE)
    scores = sum(added_by(case).values())
    assert scores.argmax() == 1


def test_who_is_told_to_lift_something_lifts_it():
    scores = sum(added_by(case_of("pick up the crate", LIFT, ON_TRUCK, ON_GROUND, DRIVE)).values())
    assert scores.argmax() == 0


def test_potentials_of_plans_can_be_switched_off():
    problem = problem_in(PROBLEM.state.context, disabled=frozenset({"plan-end", "plan-things"}))
    case = case_of("lift the crate", LIFT, DRIVE)
    assert added_by(PlanCase(case.words, case.plans, problem)) == {}
    assert set(added_by(case)) == {"plan-end", "plan-things"}


def test_things_without_a_part_in_a_plan_are_left_aside():
    state = PROBLEM.state
    words = ("lift", "the", "crate", "by", "the", "berm", "and", "the", "tires")
    [lift] = case_of("", LIFT).plans
    assert left_aside(lift, words, state) == ("berm", "tires")
    assert left_aside(lift, ("lift", "the", "crate"), state) == ()
