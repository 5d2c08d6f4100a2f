"""How far, how much and how long a command says is what is done."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.g3.inference.following_commands import BOXES, TIRES, followed, world

OPEN = {"tires": (TIRES, (3, 30)), "boxes": (BOXES, (-4, -30))}
FOOT = 0.3048


def ends(grounder, text, **others):
    """The robot's pose in the end, with degrees; and the actions."""
    plan = followed(grounder.follow(text, world(**OPEN, **others), least=0.0))
    x, y, yaw = plan.state.pose
    return (x, y, np.rad2deg(yaw)), plan.actions


@pytest.mark.parametrize(
    ("text", "pose"),
    [
        ("Go forward 10 m", (10, 0, 0)),
        ("go 15 metres", (15, 0, 0)),
        ("Drive straight ahead for 18 meters.", (18, 0, 0)),
        ("drive about 10 feet forward and stop", (10 * FOOT, 0, 0)),
        ("forward twenty feet", (20 * FOOT, 0, 0)),
        ("back up two and a half metres", (-2.5, 0, 0)),
        ("Reverse ten yards", (-9.144, 0, 0)),
        ("back up a couple of meters please", (-2, 0, 0)),
        ("Turn 45 degrees to the left", (0, 0, 45)),
        ("turn right 30 degrees", (0, 0, -30)),
        ("rotate 90° clockwise", (0, 0, -90)),
        ("turn 135 degrees counter-clockwise", (0, 0, 135)),
        ("make a 90-degree turn to the left", (0, 0, 90)),
        ("turn a quarter turn to the right", (0, 0, -90)),
        ("spin round 180", (0, 0, 180)),
        ("turn left 90, go 5m, turn right 90 and go 5m", (5, 5, 0)),
        ("Go forward 10 m, then turn right 90 degrees and go another 4 m", (10, -4, -90)),
        # Without a measure a step is a step.
        ("turn left", (0, 0, 90)),
        ("turn around", (0, 0, 180)),
    ],
)
def test_the_robot_goes_as_far_as_is_said(text, pose, grounder):
    found, _ = ends(grounder, text)
    np.testing.assert_allclose(found, pose, atol=0.01)


@settings(max_examples=15, deadline=None)
@given(
    metres=st.floats(0.5, 20).map(lambda m: round(m, 1)),
    way=st.sampled_from(["forward", "back"]),
    degrees=st.integers(10, 170),
    side=st.sampled_from(["left", "right"]),
)
def test_any_measure_is_done(metres, way, degrees, side, grounder):
    text = f"Turn {degrees} degrees to the {side}, then go {way} {metres} meters"
    (x, y, yaw), _ = ends(grounder, text)
    sign, along = (1 if side == "left" else -1), (metres if way == "forward" else -metres)
    angle = np.deg2rad(sign * degrees)
    np.testing.assert_allclose((x, y), along * np.array([np.cos(angle), np.sin(angle)]), atol=0.01)
    assert yaw == pytest.approx(sign * degrees)


@pytest.mark.parametrize(
    ("text", "kind", "amount"),
    [
        ("raise the forks half a metre", "raise forks", 0.5),
        ("Lift your forks 50 cm", "raise forks", 0.5),
        ("wait ten seconds", "wait", 10),
        ("Wait for half a minute", "wait", 30),
    ],
)
def test_forks_and_waiting_have_amounts(text, kind, amount, grounder):
    plan = followed(grounder.follow(text, world(**OPEN), least=0.0))
    (action,) = plan.actions
    assert (action.kind.name, action.amount) == (kind, pytest.approx(amount))


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize(
    ("text", "kind", "far"),
    [
        ("drive away from the {side} crate", "drive away", 6),
        ("Drive 3 m away from the {side} crate", "drive away", 3),
        ("move ten feet away from the {side} crate", "drive away", 10 * FOOT),
        ("back up 3 meters from the {side} crate", "back up", 3),
    ],
)
def test_it_leaves_a_thing_by_so_much(text, kind, far, mirrored, grounder):
    y = -5 if mirrored else 5
    there = world(left=("crate", (12, y)), right=("crate", (12, -y)))
    side = "right" if mirrored else "left"
    plan = followed(grounder.follow(text.format(side=side), there, least=0.0))
    assert [a.kind.name for a in plan.actions] == [kind]
    assert np.hypot(*plan.state.pose[:2]) == pytest.approx(far)
    before, after = (np.hypot(x - 12, y0 - y) for x, y0 in ((0, 0), plan.state.pose[:2]))
    assert after > before


def test_what_is_measured_by_a_place_is_put_there(grounder):
    text = "Put it five metres to the left of the barrel"
    there = world("load", load=(TIRES,), barrel=("barrel", (10, 0)))
    plan = followed(grounder.follow(text, there, least=0.0))
    away = plan.state.thing("load").prism.xy.mean(axis=0) - (10, 0)
    assert plan.state.held is None
    assert abs(away[0]) < 1.5
    assert 4 < away[1] < 7
