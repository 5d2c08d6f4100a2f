"""Things that a text names, and their part in a plan."""

from dataclasses import replace

import numpy as np

from corpus_tools.following.plan_steps import carried_out
from g3.actions.action_kinds import Action
from g3.actions.forklift_actions import DRIVE_TO, PICK_UP, PUT_DOWN
from g3.actions.grounding_candidates import square
from g3.actions.robot_state import start_state
from g3.inference.plan_things import PlanEnd, left_aside, named_things, where_it_ends
from tests.g3.inference.following_commands import followed, told
from tests.worlds import scene, thing

TRUCK = thing("truck", "truck", 20, 0, (4, 6), (0, 1))
BERM = thing("berm", "berm", 0, 30, (6, 3))
CRATE = thing("crate", "crate", 8, 0)
OTHER = thing("other", "crate", 0, -12)
TIRES = thing("tires", "tire pallet", -8, 0)
START = start_state(scene(TRUCK, BERM, CRATE, OTHER, TIRES))


def spot(x, y, bottom):
    return square(np.array([x, y], dtype=float), 0.0, bottom)


LIFT = (Action(PICK_UP, "crate"),)
ON_TRUCK = (*LIFT, Action(PUT_DOWN, "crate", place=spot(20, 2, 1), goal=0))
ON_GROUND = (*LIFT, Action(PUT_DOWN, "crate", place=spot(20, 12, 0), goal=0))
DRIVE = (Action(DRIVE_TO, target=(BERM,)),)


def end(plan):
    return PlanEnd(plan, carried_out(START, plan))


def test_a_plan_ends_at_what_is_near_or_under_its_load_or_near_the_robot():
    assert where_it_ends(end(LIFT)) == set()
    assert where_it_ends(end(ON_TRUCK)) == {"truck"}
    assert where_it_ends(end(ON_GROUND)) == set()
    assert where_it_ends(end(DRIVE)) == {"berm"}


def test_what_is_handled_last_is_what_is_put():
    back = Action(PUT_DOWN, "crate", place=spot(8, 12, 0), goal=0)
    moved = (*ON_GROUND, Action(PICK_UP, "tires"), Action(PUT_DOWN, "tires", place=spot(-8, 9, 0)))
    again = (*moved, Action(PICK_UP, "crate"), back)
    plans = [end(plan) for plan in (ON_GROUND, moved, again)]
    assert [plan.put for plan in plans] == ["crate", "tires", "crate"]
    assert plans[2].handled == ["crate", "tires"]


def test_a_noun_names_all_things_of_its_kind_and_other_words_name_nothing():
    named = dict(named_things(("lift", "the", "crate", "by", "the", "berm"), START))
    assert list(named) == ["crate", "berm"]
    assert named["crate"] >= {"crate", "other"}
    assert named["berm"] == {"berm"}


def test_things_without_a_part_in_a_plan_are_left_aside():
    named = named_things(("lift", "the", "crate", "by", "the", "berm", "and", "tires"), START)
    assert left_aside(end(LIFT), named, START) == ("berm", "tires")
    assert left_aside(end(LIFT), named[:1], START) == ()
    assert left_aside(end(DRIVE), named, START) == ("crate", "tires")


def test_a_named_place_is_where_a_plan_ends():
    storage = replace(square(np.array([20.0, 12.0]), 0.0, 0), name="storage A")
    start = start_state(replace(START.context, places=(storage,)))
    named = named_things(("drive", "to", "the", "storage"), start)
    assert named == [("storage", {"storage A"})]
    there = PlanEnd(ON_GROUND, carried_out(start, ON_GROUND))
    assert where_it_ends(there) == {"storage A"}
    assert left_aside(PlanEnd(LIFT, carried_out(start, LIFT)), named, start) == ("storage",)
    drive = (Action(DRIVE_TO, target=(storage,)),)
    assert not left_aside(PlanEnd(drive, carried_out(start, drive)), named, start)


def test_a_named_place_wins_in_every_bundled_world(warehouse, widely_trained):
    for name, context in warehouse.contexts.items():
        for place in filter(lambda place: place.name, context.places):
            text = f"Go to the {place.name}"
            tree = f"EVENT(r = Go, l = PATH(r = to, l = OBJ(f = the {place.name})))"
            (drive,) = followed(widely_trained.follow(told(text, tree), context)).actions
            assert [target.name for target in drive.target] == [place.name], (name, text)
