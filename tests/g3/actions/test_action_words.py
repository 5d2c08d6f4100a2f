"""Actions in words: a place is called by its name, or by what it is on or nearest to."""

from dataclasses import replace

import numpy as np
import pytest

from corpus_tools.corpus.answer_records import PlanStep
from corpus_tools.following.plan_steps import read_steps
from g3.actions.action_kinds import Action
from g3.actions.action_words import PlanWords
from g3.actions.forklift_actions import CARRY, DRIVE_TO
from g3.actions.grounding_candidates import square
from g3.actions.robot_state import start_state
from tests.worlds import OTHER, PALLET, TRAILER, place, scene, thing, two_pallets_and_a_trailer


@pytest.fixture
def start():
    person = thing("person-1", "person", 6, -5, (0.5, 0.5), (0, 1.8))
    context = scene(*two_pallets_and_a_trailer(), person)
    receiving = place("receiving", (-12, 0), (4, 4))
    return start_state(replace(context, places=(receiving,)))


def in_words(start, *steps, points=False):
    actions = read_steps([PlanStep(**step) for step in steps], start).actions
    words = PlanWords(start, actions, points=points)
    return [words.action(action) for action in actions]


def test_a_load_goes_onto_a_thing_or_to_a_named_place(start):
    onto = {"action": "carry", "object": PALLET, "on": TRAILER}
    to = {"action": "carry", "object": OTHER, "near": "receiving"}
    within = {"action": "carry", "object": OTHER, "at": (-11.0, 0.5)}
    assert in_words(start, onto) == [f"carry {PALLET} onto {TRAILER}"]
    assert in_words(start, to) == [f"carry {OTHER} to receiving"]
    assert in_words(start, within) == [f"carry {OTHER} to receiving"]
    drive = {"action": "drive to", "target": ["receiving"]}
    assert in_words(start, drive) == ["drive to receiving"]


@pytest.mark.parametrize(
    ("at", "side"),
    [
        ((6.0, 7.0), f"left of {OTHER}"),
        ((6.0, 3.0), f"right of {OTHER}"),
        ((8.0, 5.0), f"behind {OTHER}"),
        ((0.0, 8.0), f"right of {TRAILER}"),
        ((13.6, 5.0), f"7 m behind {OTHER}"),
        ((6.0, -6.0), f"10 m right of {OTHER}"),
    ],
)
def test_the_ground_is_beside_the_nearest_thing_that_stays(start, at, side):
    step = {"action": "carry", "object": PALLET, "at": at}
    assert in_words(start, step) == [f"carry {PALLET} to the ground {side}"]
    (told,) = in_words(start, step, points=True)
    assert told == f"carry {PALLET} to the ground {side} at ({at[0]:.1f}, {at[1]:.1f})"


def test_sides_are_those_that_the_robot_sees(start):
    agent = start.context.agent
    turned = replace(agent, trajectory=replace(agent.trajectory, yaw=np.array([np.pi])))
    objects = tuple(turned if o.id == agent.id else o for o in start.context.objects)
    about = replace(start, context=replace(start.context, objects=objects))
    action = Action(CARRY, PALLET, place=square(np.array([6.0, 7.0]), 0.0, 0.0))
    words = PlanWords(about, [action], points=False)
    assert words.action(action) == f"carry {PALLET} to the ground right of {OTHER}"


def test_a_load_goes_onto_one_that_was_brought_there(start):
    middle = np.array([-3.0, -6.0])
    first = Action(CARRY, OTHER, place=square(middle, 0.0, 0.0))
    second = Action(CARRY, PALLET, place=square(middle, 0.0, 1.0))
    words = PlanWords(start, [first, second], points=False)
    assert words.action(second) == f"carry {PALLET} onto {OTHER}"
    up = PlanWords(start, [second]).action(second)
    assert up.endswith("at (-3.0, -6.0), 1.0 m up")


def test_places_that_clauses_mean_are_named(start):
    spot = square(np.array([6.0, 7.0]), 0.0, 0.0)
    deck = square(np.array([0.0, 12.0]), 0.0, 0.8)
    words = PlanWords(start, points=False)
    assert words.group((spot,)) == f"the place left of {OTHER}"
    assert words.group((deck, start.thing(OTHER))) == f"the place on {TRAILER} and {OTHER}"
    assert words.action(Action(DRIVE_TO, target=(spot,))) == f"drive to the place left of {OTHER}"
    assert PlanWords().group((spot,)) == "at (6.0, 7.0)"
