"""Whether plans do what single words say, and that the search's plans do."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.stated_relations import RELATIONS, Done, Mention, fulfils_relation, mentions
from g3.actions.action_kinds import Action, move, result
from g3.actions.forklift_actions import (
    BACK_UP,
    DRIVE_AWAY,
    DRIVE_PAST,
    DRIVE_TO,
    FACE,
    GO_STRAIGHT,
    LINE_UP,
    LOWER_FORKS,
    PARK,
    PICK_UP,
    RAISE_FORKS,
    TURN,
    TURN_AWAY,
    WAIT,
)
from g3.actions.robot_state import start_state
from g3.groundings import Context
from g3.inference.grounder import Grounder
from g3.sdc.sdc_notation import parse_brackets
from tests.g3.inference.constant_cost import ConstantCost
from tests.worlds import robot, scene, still, thing

TRUCK = thing("truck", "truck", 7.0, 9.0, (4, 2))
YARD = scene(TRUCK, thing("tires", "tire pallet", 4.0, -6.0, (1, 1)))


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("Drive away from the truck", "away"),
        ("Stop a few feet away from the truck", "wait"),
        ("Turn away from it and drive past the cone", "turn away, past"),
        ("Raise your forklift and lower the mechanical fork", "raise forks, lower forks"),
        ("Lift the pallet. Lower the pallet of tires", ""),
        ("turn towards the truck on the right", "face"),
        ("Turn to the left, then make an about-face turn", ""),
        ("stop in line with the box", "wait, line up"),
        ("Park by the line of pallets until it comes to a stop", "park"),
    ],
)
def test_mentions_in_a_text(text: str, found: str) -> None:
    assert ", ".join(m.relation for m in mentions(text)) == found


def holds(relation: str, action: Action, context: Context = YARD) -> bool:
    before = start_state(context)
    motion = move(before, [action])
    way = np.column_stack((motion.xyz[0, :, :2], motion.yaw[0]))
    done = Done(action, before, result(before, action, motion, 0), way, (TRUCK,))
    return RELATIONS[relation].holds(done)


AT_TRUCK = {
    kind.name: Action(kind, target=(TRUCK,))
    for kind in (DRIVE_TO, DRIVE_PAST, DRIVE_AWAY, FACE, TURN_AWAY, LINE_UP, PARK)
}
OTHERS = {
    "ahead": Action(GO_STRAIGHT, amount=4.0),
    "back": Action(BACK_UP, amount=-4.0),
    "around": Action(TURN, amount=np.pi),
    "wait": Action(WAIT),
    "up": Action(RAISE_FORKS, amount=1.0),
    "down": Action(LOWER_FORKS, amount=0.0),
    "lift": Action(PICK_UP, object_id="tires"),
}


@pytest.mark.parametrize(
    ("relation", "right"),
    [
        ("turn away", "around, drive away, drive past, lift, park, turn away"),
        ("away", "back, drive away"),
        ("past", "drive past"),
        ("raise forks", "up"),
        ("lower forks", "down, wait"),
        ("face", "drive to, face, line up"),
        ("line up", "line up, park"),
        ("park", "drive to, line up, park"),
    ],
)
def test_only_some_actions_do_what_words_say(relation: str, right: str) -> None:
    every = AT_TRUCK | OTHERS
    does = sorted(name for name, action in every.items() if holds(relation, action))
    assert ", ".join(does) == right


_AWAY = "l = PATH(r = away from, l = OBJ(f = the truck))"
COMMANDS = {
    "Drive away from the truck": f"EVENT(r = Drive, {_AWAY})",
    "Drive past the truck": "EVENT(r = Drive, l = PATH(r = past, l = OBJ(f = the truck)))",
    "Turn away from the truck": f"EVENT(r = Turn, {_AWAY})",
    "Face the truck": "EVENT(r = Face, l = OBJ(f = the truck))",
    "Turn towards the truck": "EVENT(r = Turn, l = PATH(r = towards, l = OBJ(f = the truck)))",
    "Line up with the truck": "EVENT(r = Line up, l = PATH(r = with, l = OBJ(f = the truck)))",
    "Park at the truck": "EVENT(r = Park, l = PATH(r = at, l = OBJ(f = the truck)))",
    "Raise the forks": "EVENT(r = Raise, l = OBJ(f = the forks))",
    # The first clause only leads on to the second.
    "Go and raise the forks": "EVENT(r = Go); EVENT(r = raise, l = OBJ(f = the forks))",
    "Lower your forklift": "EVENT(r = Lower, l = OBJ(f = your forklift))",
    "Stop": "EVENT(r = Stop)",
}


@settings(max_examples=40)
@given(
    st.sampled_from(sorted(COMMANDS)),
    st.tuples(st.floats(-12, 12), st.floats(-12, 12)).filter(lambda p: np.hypot(*p) > 5),
    st.tuples(st.floats(-12, 12), st.floats(-12, 12)).filter(lambda p: np.hypot(*p) > 3),
    st.floats(-3, 3),
)
def test_plans_in_plain_worlds_do_as_words_say(
    text: str, truck: tuple[float, float], tires: tuple[float, float], yaw: float
) -> None:
    # A cost that prefers nothing: what is left are the kinds that words ask for.
    world = scene(
        thing("truck", "truck", *truck, (4, 2)),
        thing("tires", "tire pallet", *tires, (1, 1)),
        agent=robot(still(0, 0, yaw=yaw)),
    )
    [mention] = mentions(text)
    sdcs = parse_brackets(COMMANDS[text], command=text)
    plan = Grounder(ConstantCost()).follow(sdcs, world, least=0.0).plan
    assert plan is not None
    assert fulfils_relation(mention, sdcs, world, plan), plan.actions


def test_words_in_no_clause_are_not_done() -> None:
    text = "Face the truck, away from it"
    sdcs = parse_brackets("EVENT(r = Face, l = OBJ(f = the truck))", command=text)
    plan = Grounder(ConstantCost()).follow(sdcs, YARD, least=0.0).plan
    assert plan is not None
    assert fulfils_relation(Mention("face", 0, 4), sdcs, YARD, plan)
    assert not fulfils_relation(Mention("turn away", 16, 25), sdcs, YARD, plan)
