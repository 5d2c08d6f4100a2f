"""Ways around obstacles, and when the robot is where on them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from corpus_tools.world.physics.pacing import EMPTY, LIFT, ramp, references
from corpus_tools.world.planning import ways as planning
from corpus_tools.world.planning.curves import cost_of, dubins, poses_on, turn_go_turn
from corpus_tools.world.planning.ways import (
    Boxes,
    NoWayError,
    Rect,
    clearance,
    distance,
    field_of,
    outline,
    plan,
)
from g3.geometry.plane import wrap
from g3.groundings import FloatArray

VEHICLE = outline((Rect((-1.2, 0.5), (-0.55, 0.55)), Rect((0.5, 1.55), (-0.3, 0.3))))

coordinates = st.floats(-8, 8, allow_subnormal=False)
poses = st.tuples(coordinates, coordinates, st.floats(-3, 3)).map(np.array)


def boxes(*rows: tuple[float, float, float, float, float]) -> Boxes:
    """From x, y, yaw and half lengths; a metre high."""
    table = np.array(rows, dtype=float).reshape(-1, 5)
    heights = np.tile([0.0, 1.0], (len(table), 1))
    return Boxes(table[:, :2], table[:, 2], table[:, 3:], heights)


def assert_same_pose(a: FloatArray, b: FloatArray) -> None:
    np.testing.assert_allclose(a[:2], b[:2], atol=1e-6)
    assert abs(wrap(a[2] - b[2])) < 1e-6


@given(start=poses, goal=poses, radius=st.floats(0.5, 3))
def test_curves_lead_to_the_goal(start: FloatArray, goal: FloatArray, radius: float) -> None:
    assert_same_pose(poses_on(start, turn_go_turn(start, goal))[-1], goal)
    way = dubins(start, goal, radius)
    if way is not None:
        assert_same_pose(poses_on(start, way)[-1], goal)
        assert all(length >= 0 for length, _ in way)
        assert all(abs(turn) <= length / radius + 1e-6 for length, turn in way)


def test_a_dubins_curve_worked_by_hand() -> None:
    # Left a quarter circle of radius 1, straight on by 3, left another quarter.
    way = dubins(np.zeros(3), np.array([0.0, 5.0, np.pi]), 1.0)
    assert way is not None
    np.testing.assert_allclose(
        way, [(np.pi / 2, np.pi / 2), (3.0, 0.0), (np.pi / 2, np.pi / 2)], atol=1e-9
    )


def test_distances_to_a_box_worked_by_hand() -> None:
    one = boxes((1.0, 0.0, np.pi / 2, 2.0, 1.0))
    points = np.array([[3.0, 0.0], [1.0, 3.0], [5.0, 5.0], [1.0, 0.0]])
    np.testing.assert_allclose(distance(points, one), [1.0, 1.0, np.hypot(3, 3), -1.0], atol=1e-9)
    field = field_of(one, np.zeros((1, 2)), 6.0)
    np.testing.assert_allclose(field.at(points), distance(points, one), atol=0.03)


def test_the_way_leads_around_a_wall() -> None:
    wall = boxes((3.0, 0.0, np.pi / 2, 4.0, 0.2))
    goal = np.array([6.0, 0.0, 0.0])
    way, chosen = plan(np.zeros(3), goal[None], VEHICLE, wall)
    assert chosen == 0
    driven = poses_on(np.zeros(3), way)
    assert_same_pose(driven[-1], goal)
    assert clearance(driven, VEHICLE, wall) > 0.08
    assert np.abs(driven[:, 1]).max() > 4


def test_the_cheaper_goal_is_chosen() -> None:
    goals = np.array([[8.0, 0.0, 0.0], [4.0, 0.0, 0.0]])
    nothing = boxes()
    assert plan(np.zeros(3), goals, VEHICLE, nothing)[1] == 1
    assert plan(np.zeros(3), goals, VEHICLE, nothing, np.array([0.0, 20.0]))[1] == 0


@given(goal=poses, metres=st.integers(0, 64))
def test_what_all_goals_cost_on_top_changes_no_way(goal: FloatArray, metres: int) -> None:
    goals = goal + np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 0.5]])
    wall = boxes((20.0, 0.0, 0.0, 1.0, 1.0))
    plain = plan(np.zeros(3), goals, VEHICLE, wall, np.array([0.0, 2.0]))
    assert plan(np.zeros(3), goals, VEHICLE, wall, np.array([metres, metres + 2.0])) == plain


def test_a_dear_goal_is_taken_when_the_search_for_a_cheap_one_ends(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(planning, "_PATIENCE", 200)
    pen = boxes(*((8 + 3 * x, 3 * y, np.pi / 2 * abs(x), 3.0, 0.2) for x, y in _SIDES))
    goals = np.array([[8.0, 0.0, 0.0], [-4.0, 0.0, np.pi]])
    way, chosen = plan(np.zeros(3), goals, VEHICLE, pen, np.array([0.0, 500.0]))
    assert chosen == 1
    assert_same_pose(poses_on(np.zeros(3), way)[-1], goals[1])


def test_a_goal_in_a_pen_is_out_of_reach() -> None:
    pen = boxes(*((8 + 3 * x, 3 * y, np.pi / 2 * abs(x), 3.0, 0.2) for x, y in _SIDES))
    with pytest.raises(NoWayError):
        plan(np.zeros(3), np.array([[8.0, 0.0, 0.0]]), VEHICLE, pen)
    with pytest.raises(NoWayError, match="no room"):
        plan(np.zeros(3), np.array([[8.0, 3.0, 0.0]]), VEHICLE, pen)


_SIDES = ((1, 0), (-1, 0), (0, 1), (0, -1))


@given(goal=poses)
def test_speeds_and_turn_rates_keep_their_limits(goal: FloatArray) -> None:
    way = dubins(np.zeros(3), goal, 1.5) or turn_go_turn(np.zeros(3), goal)
    at = references(np.zeros(3), way, EMPTY, 0.02)
    np.testing.assert_allclose(at[0], 0, atol=1e-9)
    assert_same_pose(at[-1], poses_on(np.zeros(3), way)[-1])
    speed = np.hypot(*np.diff(at[:, :2], axis=0).T) / 0.02
    assert speed.max(initial=0) <= EMPTY.drive.speed + 1e-6
    assert (np.abs(np.diff(at[:, 2])) / 0.02).max(initial=0) <= EMPTY.turn.speed + 1e-6
    assert (np.abs(np.diff(speed)) / 0.02).max(initial=0) <= 2 * EMPTY.drive.acceleration
    assert cost_of(way) >= 0


@given(start=st.floats(0, 2), end=st.floats(0, 2))
def test_the_forks_come_to_rest_where_they_shall(start: float, end: float) -> None:
    heights = ramp(start, end, LIFT, 0.01)
    assert heights[0] == pytest.approx(start, abs=1e-6)
    assert heights[-1] == pytest.approx(end, abs=1e-6)
    assert np.abs(np.diff(heights)).max() / 0.01 <= LIFT.speed + 1e-6
