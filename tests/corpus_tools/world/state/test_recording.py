from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from corpus_tools.world.state.recording import Recording, heading, to_context, upright
from g3.groundings import Context, PhysicalObject, Prism, Trajectory

SQUARE = Prism([[0, 0], [1, 0], [1, 1]], 0.0, 1.0)


def recording(t_ns, xyz, yaw, forks=None, ids=("robot", "box")):
    objects = tuple(
        PhysicalObject(name, (name,), SQUARE, Trajectory([0.0], [[0, 0, 0]], [0.0])) for name in ids
    )
    t_ns = np.array(t_ns, dtype=np.int64)
    forks = np.zeros(len(t_ns)) if forks is None else np.array(forks)
    return Recording(
        Context("yard", objects, (), "robot"),
        t_ns,
        np.array(xyz, dtype=float),
        upright(np.array(yaw)),
        forks,
    )


@given(st.floats(-3.14, 3.14))
def test_headings_come_back_from_quaternions(yaw):
    assert heading(upright(np.array([yaw]))) == pytest.approx(yaw)


def test_a_tilted_frame_has_the_heading_of_its_x_axis():
    half = np.sqrt(0.5)
    rolled = np.array([half, half, 0.0, 0.0])  # a quarter turn about x
    assert heading(rolled) == 0.0


@pytest.mark.parametrize("times", [[], [1, 1], [2, 1], [-1, 0]])
def test_times_must_grow_from_zero_on(times):
    n = len(times)
    with pytest.raises(ValueError, match="growing"):
        recording(times, np.zeros((n, 2, 3)), np.zeros((n, 2)))


def test_shapes_must_fit():
    with pytest.raises(ValueError, match=r"position has shape \(1, 3, 3\), expected \(1, 2, 3\)"):
        recording([0], np.zeros((1, 3, 3)), np.zeros((1, 3)))


def test_numbers_must_be_finite():
    with pytest.raises(ValueError, match="fork_height_m holds a value that is not finite"):
        recording([0], np.zeros((1, 2, 3)), np.zeros((1, 2)), forks=[np.nan])


def test_a_context_has_poses_of_what_moves_and_of_the_robot():
    xyz = [[[0, 0, 0], [5, 0, 0]], [[0, 0, 0], [6, 0, 0]]]
    context = to_context(recording([0, 500_000_000], xyz, [[3, 0], [-3, 0]]), start_s=10.0)
    robot, box = (item.trajectory for item in context.objects)
    assert robot.t.tolist() == [10.0, 10.5]
    assert box.xyz[:, 0].tolist() == [5, 6]
    assert robot.yaw == pytest.approx([3, 2 * np.pi - 3])  # unwound


def test_a_context_has_one_pose_of_what_stands_still():
    context = to_context(recording([0, 1], np.zeros((2, 2, 3)), np.zeros((2, 2))))
    assert [len(item.trajectory) for item in context.objects] == [2, 1]
