"""Plans that name things by their ids, in a yard with two pallets and a trailer."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from corpus_tools.corpus.answer_records import PlanStep
from corpus_tools.following.plan_steps import (
    carried_out,
    read_steps,
    scene_shown,
    why_impossible,
)
from g3.actions.action_kinds import KINDS
from g3.actions.grounding_candidates import carrier
from g3.actions.robot_state import start_state
from g3.errors import FormatError
from tests.worlds import OTHER, PALLET, TRAILER, place, scene, two_pallets_and_a_trailer


@pytest.fixture
def start():
    return start_state(scene(*two_pallets_and_a_trailer()))


def read(start, *steps):
    return read_steps([PlanStep(**step) for step in steps], start)


def end(start, *steps):
    plan = read(start, *steps)
    assert not plan.why_not
    return carried_out(start, plan.actions)


def test_a_load_is_put_on_a_trailer(start):
    after = end(start, {"action": "carry", "object": PALLET, "on": TRAILER})
    assert carrier(after, PALLET).id == TRAILER
    assert after.held is None


def test_what_is_picked_up_is_put_down_without_saying_what(start):
    steps = ({"action": "pick up", "object": OTHER}, {"action": "put down", "at": (3.0, -4.0)})
    assert end(start, steps[0]).held == OTHER
    after = end(start, *steps)
    assert after.held is None
    middle = after.thing(OTHER).prism.xy.mean(axis=0)
    assert np.linalg.norm(middle - (3.0, -4.0)) < 0.5


def test_near_is_on_the_ground_and_beside(start):
    after = end(start, {"action": "carry", "object": PALLET, "near": TRAILER})
    assert carrier(after, PALLET) is None
    assert np.linalg.norm(after.thing(PALLET).prism.xy.mean(axis=0) - (0, 12)) < 6


def test_a_point_on_a_deck_is_as_high_as_the_deck(start):
    after = end(start, {"action": "carry", "object": PALLET, "at": (1.0, 12.0)})
    assert after.thing(PALLET).prism.z_min == pytest.approx(0.8)


def test_signs_and_degrees_of_amounts(start):
    assert end(start, {"action": "turn", "amount": 90.0}).pose[2] == pytest.approx(np.pi / 2)
    for amount in (3.0, -3.0):  # the kind says which way
        assert end(start, {"action": "back up", "amount": amount}).pose[0] == pytest.approx(-3)
    assert end(start, {"action": "go straight", "amount": 2.0}).pose[0] == pytest.approx(2)


def test_things_places_and_points_are_driven_to(start):
    there = end(start, {"action": "drive to", "target": (TRAILER,)}).pose[:2]
    assert np.linalg.norm(there - (0, 12)) < 7
    there = end(start, {"action": "drive to", "to": (9.0, -9.0)}).pose[:2]
    assert np.linalg.norm(there - (9, -9)) < 3


@pytest.mark.parametrize(
    ("step", "said"),
    [
        ({"action": "fly"}, "there is no action 'fly'"),
        ({"action": "pick up"}, "a pick up action needs an object"),
        ({"action": "pick up", "object": "moon"}, "there is no thing 'moon'"),
        ({"action": "pick up", "object": PALLET, "on": TRAILER}, "takes none of on, near and at"),
        ({"action": "carry", "object": PALLET}, "needs one of on, near and at"),
        ({"action": "carry", "object": PALLET, "on": PALLET}, "on or near itself"),
        ({"action": "drive to"}, "needs one of target and to"),
        ({"action": "drive to", "target": (PALLET,), "to": (1, 1)}, "needs one of target and to"),
        ({"action": "drive between", "target": (PALLET,)}, "needs two targets"),
        ({"action": "turn"}, "needs an amount"),
        ({"action": "drive to", "target": (PALLET,), "amount": 1}, "takes no amount"),
        ({"action": "wait", "object": PALLET}, "takes no object"),
    ],
)
def test_what_cannot_be_meant_is_told(step, said, start):
    with pytest.raises(FormatError) as error:
        read(start, {"action": "turn", "amount": 10}, step)
    assert said in error.value.what
    assert error.value.where == "action 2"


def test_what_cannot_be_done_is_no_error(start):
    """Who plans so is wrong; the file isn't."""
    twice = ({"action": "pick up", "object": PALLET}, {"action": "pick up", "object": OTHER})
    plan = read(start, *twice)
    assert plan.why_not == f"action 2: pick up: {PALLET} is on the forks"
    assert plan.actions == ()
    both = [read(start, step).actions[0] for step in twice]
    assert why_impossible(start, both) == f"action 2: pick up: {PALLET} is on the forks"
    assert why_impossible(start, both[:1]) == ""
    plan = read(start, {"action": "put down", "near": PALLET})
    assert plan.why_not == "action 1: put down: nothing is on the forks"


def test_every_kind_of_action_can_be_given(start):
    """No kind is left out, however it was added."""
    for kind in KINDS.values():
        fields = {"action": kind.name}
        fields |= {"object": PALLET} if kind.takes else {}
        fields |= {"at": (3.0, 3.0)} if kind.leaves else {}
        fields |= {"target": (OTHER, TRAILER)} if kind.aims else {}
        fields |= {"amount": 0.5} if kind.unit else {}
        before = end(start, {"action": "pick up", "object": PALLET}) if kind.leaves else start
        plan = read(start if kind.takes else before, fields)
        assert [a.kind for a in plan.actions] == [kind], plan


def test_a_world_is_shown_as_the_robot_sees_it(start):
    shown = scene_shown(start)
    things = {one.id: one for one in shown.things}
    assert (shown.position, shown.heading, shown.holds) == ((0.0, 0.0), 0.0, "")
    assert things[OTHER].seen == (6.0, 5.0)  # ahead, and to the left
    assert things[OTHER].liftable
    assert not things[TRAILER].liftable
    assert things[TRAILER].size == (6.0, 3.0, 0.8)
    after = scene_shown(end(start, {"action": "carry", "object": PALLET, "on": TRAILER}))
    (load,) = (one for one in after.things if one.id == PALLET)
    assert load.on == TRAILER
    assert b'"on":"trailer"' in msgspec.json.encode(load)


def test_places_have_names(start):
    yard = replace(start.context, places=(place("receiving", (20, 0)),))
    named = replace(start, context=yard)
    there = end(named, {"action": "drive to", "target": ("receiving",)}).pose[:2]
    assert np.linalg.norm(there - (20, 0)) < 4
    assert [p.name for p in scene_shown(named).places] == ["receiving"]
