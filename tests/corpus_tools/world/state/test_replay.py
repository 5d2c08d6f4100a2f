"""Replays of logs: true to the log, complete, and with forks where they must be."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.world.state.dimensions import ENTRY_HEIGHT, LOW
from corpus_tools.world.state.recording import NS_PER_S, heading
from corpus_tools.world.state.replay import FORK_SPEED_M_S, NOTHING, carried, replay
from g3.groundings import Context
from tests import worlds
from tests.corpus_tools.world.state.replayed import deviations
from tests.strategies import contexts
from tests.worlds import log


def thing(name, labels, t, xyz, yaw=None):
    """A pallet or robot, 1 m long and wide, its poses on its bottom."""
    x, y, z = np.array(xyz, dtype=float).T
    way = log(np.column_stack((x, y)), 0.0 if yaw is None else yaw, z, t)
    return worlds.thing(name, labels, x[0], y[0], (1, 1), (z[0], z[0] + 0.7), way)


def robot(t, xyz, yaw=None):
    return thing("robot", "forklift", t, xyz, yaw)


def pallet(t, xyz, yaw=None):
    return thing("pallet", "tire pallet", t, xyz, yaw)


def world(*objects):
    return Context("yard", objects, (), "robot")


@pytest.fixture
def picking_up():
    """Waits 10 s 5 m away, drives up in 4 s, lifts by 0.3 m in 2 s, backs out by 2 m in 2 s."""
    driver = robot(
        [100, 110, 112, 114, 116, 117, 118],
        [[0, 0, 0], [0, 0, 0], [2, 0, 0], [3.9, 0, 0], [3.9, 0, 0], [2.9, 0, 0], [1.9, 0, 0]],
    )
    load = pallet(
        [100, 115, 116, 117, 118],
        [[5, 0, 0], [5, 0, 0.15], [5, 0, 0.3], [4, 0, 0.3], [3, 0, 0.3]],
    )
    return world(driver, load)


def test_times_are_an_exact_grid_that_covers_the_log(picking_up):
    recording = replay(picking_up, 25.0)
    assert recording.t_ns.tolist() == [k * NS_PER_S // 25 for k in range(18 * 25 + 1)]
    starts = [item.trajectory.t.tolist() for item in recording.start.objects]
    assert starts == [[0.0], [0.0]], "the log begins at 100 s, the recording at 0"
    thirds = replay(picking_up, 30.0).t_ns
    assert thirds[:4].tolist() == [0, 33333333, 66666667, 100000000]


def test_the_robot_is_where_the_log_says_when_it_says(picking_up):
    recording = replay(picking_up, 10.0)
    assert recording.position[[0, 120, 140, 170, 180], 0, 0] == pytest.approx([0, 2, 3.9, 2.9, 1.9])


def test_a_gap_is_a_wait_and_not_a_slow_drive():
    recording = replay(world(robot([0, 20, 21], [[0, 0, 0], [1, 0, 0], [2, 0, 0]])), 10.0)
    x = recording.position[:, 0, 0]
    assert (x[:191] == 0).all()
    assert x[200] == pytest.approx(1)
    assert (np.diff(x) >= 0).all()


def test_a_load_keeps_to_the_robot_in_a_turn():
    """A quarter turn on the spot between two poses: the load goes around, not straight."""
    driver = robot([0, 1, 2], [[0, 0, 0]] * 3, [0, 0, np.pi / 2])
    load = pallet([0, 1, 2], [[1.1, 0, 0.2], [1.1, 0, 0.3], [0, 1.1, 0.3]], [0, 0, np.pi / 2])
    recording = replay(world(driver, load), 20.0)
    distance = np.linalg.norm(recording.position[:, 1, :2], axis=1)
    assert distance == pytest.approx(1.1)
    assert heading(recording.orientation[:, 1]) == pytest.approx(
        heading(recording.orientation[:, 0])
    )


def test_yaw_turns_the_shorter_way():
    recording = replay(world(robot([0, 1], [[0, 0, 0]] * 2, [3.0, -3.0])), 10.0)
    assert (np.abs(heading(recording.orientation[:, 0])) >= 3.0 - 1e-9).all()


def test_forks_are_under_the_deck_of_the_load_while_it_is_carried(picking_up):
    recording = replay(picking_up, 10.0)
    load = carried(recording)
    assert (load[:140] == NOTHING).all()
    assert (load[141:] == 1).all()
    bottom = recording.position[141:, 1, 2]
    assert recording.fork_height_m[141:] == pytest.approx(bottom + ENTRY_HEIGHT)


def test_forks_are_low_before_they_carry(picking_up):
    recording = replay(picking_up, 10.0)
    assert (recording.fork_height_m[:135] == LOW).all()
    rate = np.diff(recording.fork_height_m) * 10
    assert np.abs(rate).max() <= FORK_SPEED_M_S + 1e-9


def test_forks_are_raised_before_they_enter_a_load_on_a_deck():
    driver = robot(
        [0, 10, 15, 18, 19], [[0, 0, 0], [6, 0, 0], [8.9, 0, 0], [8.9, 0, 0], [7.9, 0, 0]]
    )
    load = pallet([0, 17, 18, 19], [[10, 0, 1.0], [10, 0, 1.2], [10, 0, 1.3], [9, 0, 1.3]])
    recording = replay(world(driver, load), 10.0)
    assert (recording.fork_height_m[:50] == LOW).all()
    ahead = recording.position[:, 1, 0] - recording.position[:, 0, 0]
    entered = (ahead < 2.1) & (recording.t_s < 15)
    assert entered.any()
    assert recording.fork_height_m[entered] == pytest.approx(1.0 + LOW)


def test_forks_come_down_after_they_left_a_load_that_was_put_down():
    driver = robot([0, 1, 2, 3, 6, 12], [[0, 0, 0]] * 4 + [[-3, 0, 0], [-9, 0, 0]])
    load = pallet([0, 1, 2, 3], [[1.1, 0, 1.3], [1.1, 0, 1.2], [1.1, 0, 1.1], [1.1, 0, 1.0]])
    recording = replay(world(driver, load), 10.0)
    ahead = recording.position[:, 1, 0] - recording.position[:, 0, 0]
    out = (recording.t_s > 3.5) & (ahead < 2.1)
    assert recording.fork_height_m[out] == pytest.approx(1.0 + LOW)
    assert recording.fork_height_m[-1] == LOW
    assert (carried(recording)[35:] == NOTHING).all()


def test_driving_past_a_raised_load_leaves_the_forks_low():
    driver = robot([0, 5, 10], [[0, 0, 0], [10, 0, 0], [20, 0, 0]])
    load = pallet([0], [[10, 1.5, 1.0]])
    assert (replay(world(driver, load), 10.0).fork_height_m == LOW).all()


def test_what_has_one_pose_stands_still(picking_up):
    stone = thing("stone", "crate", [0], [[1, 2, 3]], [0.5])
    recording = replay(world(*picking_up.objects, stone), 10.0)
    assert (recording.position[:, 2] == [1, 2, 3]).all()
    assert [len(item.trajectory) for item in recording.start.objects] == [1, 1, 1]


def test_a_context_without_trajectories_is_one_moment():
    recording = replay(world(robot([50], [[1, 2, 0]]), pallet([0], [[5, 5, 0]])), 25.0)
    assert recording.t_ns.tolist() == [0]
    assert recording.position.tolist() == [[[1, 2, 0], [5, 5, 0]]]
    assert recording.fork_height_m.tolist() == [LOW]


def test_the_last_moment_is_the_last_pose_in_spite_of_rounding():
    end = 2 + 1e-8
    recording = replay(world(robot([0, end - 0.002, end], [[0, 0, 0], [0, 0, 0], [5, 0, 0]])), 10.0)
    assert recording.position[-1, 0].tolist() == [5, 0, 0]


@given(contexts(), st.sampled_from([1.0, 7.5, 30.0]))
def test_any_context_is_played_within_the_poses_of_its_log(context, rate_hz):
    recording = replay(context, rate_hz)
    assert np.isfinite(recording.orientation).all()
    assert (recording.fork_height_m >= LOW).all()
    i = [item.id for item in context.objects].index(context.agent_id)
    way, t = context.agent.trajectory.xyz, context.agent.trajectory.t
    assert recording.position[0, i] == pytest.approx(way[0])
    if t[-1] - t[0] > 0.001:  # else it is the first pose, by the same clock
        assert recording.position[-1, i] == pytest.approx(way[-1])
    assert (recording.position[:, i] >= way.min(axis=0) - 1e-9).all()
    assert (recording.position[:, i] <= way.max(axis=0) + 1e-9).all()


def test_the_bundled_corpus_is_replayed_truly():
    for context in open_corpus("warehouse").contexts.values():
        assert max(deviations(context)) < 0.01
