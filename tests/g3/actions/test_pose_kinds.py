"""Facing, leaving, lining up, parking, and moving the forks."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from g3.actions.action_kinds import Action, Focus, move, possible_actions, result
from g3.actions.forklift_actions import (
    BESIDE_M,
    DRIVE_AWAY,
    FACE,
    HIGHEST_M,
    LINE_UP,
    LOWER_FORKS,
    PARK,
    PICK_UP,
    RAISE_FORKS,
    RAISE_M,
    TURN_AWAY,
)
from g3.actions.grounding_candidates import footprint_of
from g3.actions.motions import LIFT_M
from g3.actions.robot_state import State, start_state
from g3.geometry.plane import point_gap, wrap
from g3.groundings import FloatArray
from tests.g3.actions.yards import Pose, with_load, yard

POSES = st.tuples(st.floats(-6, 6), st.floats(-8, 8), st.floats(-3, 3))
THINGS = st.sampled_from(["tires", "boxes", "truck"])


def driven(state: State, action: Action) -> FloatArray:
    """x, y, yaw of the robot's way, shape (n, 3)."""
    motion = move(state, [action])
    return np.column_stack((motion.xyz[0, :, :2], motion.yaw[0]))


def aimed(kind, state: State, name: str) -> tuple[FloatArray, FloatArray]:
    """The way of an action at a thing, and that thing's outline."""
    target = (state.thing(name),)
    return driven(state, Action(kind, target=target)), footprint_of(target)


def gaps(way: FloatArray, outline: FloatArray) -> FloatArray:
    return point_gap(way[None, :, :2], outline[None])[0]


def bearing(way: FloatArray, outline: FloatArray) -> float:
    x, y = outline.mean(axis=0) - way[-1, :2]
    return float(abs(wrap(np.arctan2(y, x) - way[-1, 2])))


@settings(max_examples=25)
@given(POSES, THINGS)
def test_the_robot_turns_on_the_spot_to_face_a_thing_or_away(pose: Pose, name: str) -> None:
    state = start_state(yard(pose))
    for kind, angle in ((FACE, 0.0), (TURN_AWAY, np.pi)):
        way, outline = aimed(kind, state, name)
        assert bearing(way, outline) == pytest.approx(angle, abs=1e-6)
        assert np.ptp(way[:, :2], axis=0).max() < 1e-9
        assert np.ptp(np.unwrap(way[:, 2])) <= np.pi + 1e-9


@settings(max_examples=25)
@given(POSES, THINGS)
def test_driving_away_ends_farther_with_the_thing_behind(pose: Pose, name: str) -> None:
    way, outline = aimed(DRIVE_AWAY, start_state(yard(pose)), name)
    assert gaps(way, outline)[-1] >= gaps(way, outline)[0] + 1.0
    assert bearing(way, outline) > np.pi / 2


@settings(max_examples=25)
@given(POSES, THINGS)
def test_lining_up_ends_in_front_of_a_side_square_to_it(pose: Pose, name: str) -> None:
    state = start_state(yard(pose))
    way, outline = aimed(LINE_UP, state, name)
    assert bearing(way, outline) < 0.01
    skew = wrap(4 * (way[-1, 2] - state.thing(name).trajectory.yaw[0]))
    assert abs(skew) < 0.01
    assert 2.0 < gaps(way, outline)[-1] < 3.5


@settings(max_examples=25)
@given(POSES, THINGS)
def test_parking_ends_beside_a_thing_and_parallel_to_it(pose: Pose, name: str) -> None:
    state = start_state(yard(pose))
    way, outline = aimed(PARK, state, name)
    assert bearing(way, outline) == pytest.approx(np.pi / 2, abs=0.01)
    assert abs(wrap(4 * (way[-1, 2] - state.thing(name).trajectory.yaw[0]))) < 0.01
    assert gaps(way, outline)[-1] == pytest.approx(BESIDE_M, abs=0.01)


@settings(max_examples=25)
@given(POSES)
def test_parking_in_a_place_ends_in_its_middle_square_to_it(pose: Pose) -> None:
    context = yard(pose)
    way = driven(start_state(context), Action(PARK, target=context.places[:1]))
    np.testing.assert_allclose(way[-1, :2], (4.0, -9.0), atol=1e-6)
    assert abs(wrap(4 * way[-1, 2])) < 0.01


def one_of(kind, state: State) -> Action:
    tried = possible_actions(state, Focus(asked=frozenset({kind})))
    [action] = [action for action in tried if action.kind is kind]
    return action


def test_empty_forks_go_up_and_down_and_nothing_else_changes() -> None:
    start = start_state(yard())
    up = one_of(RAISE_FORKS, start)
    motion = move(start, [up])
    raised = result(start, up, motion, 0)
    assert (start.forks_m, raised.forks_m) == (0.0, RAISE_M)
    assert motion.t[0, -1] > 0
    assert [o.prism for o in raised.context.objects] == [o.prism for o in start.context.objects]
    down = one_of(LOWER_FORKS, raised)
    assert result(raised, down, move(raised, [down]), 0).forks_m == 0.0


def test_a_load_goes_up_with_the_forks_and_stays_off_the_ground() -> None:
    state = start_state(with_load())
    high = [state.thing("load").prism.z_min]
    for kind in (RAISE_FORKS, RAISE_FORKS, LOWER_FORKS):
        action = one_of(kind, state)
        state = result(state, action, move(state, [action]), 0)
        high.append(state.thing("load").prism.z_min)
        assert state.held == "load"
    assert high == pytest.approx([0.3, 0.3 + RAISE_M, HIGHEST_M, LIFT_M])
    assert not any(a.kind is RAISE_FORKS for a in possible_actions(state, Focus()))


def test_picking_up_leaves_the_forks_where_loads_are_carried() -> None:
    state = start_state(yard())
    action = Action(PICK_UP, object_id="tires")
    assert result(state, action, move(state, [action]), 0).forks_m == LIFT_M
