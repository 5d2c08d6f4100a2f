"""Facing things, leaving them, lining up, parking and moving the forks, in physics."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("mujoco")

from corpus_tools.world.physics.execute import Execution, execute
from corpus_tools.world.state.dimensions import LIFT_RANGE, LOW
from corpus_tools.world.state.recording import heading
from corpus_tools.world.state.robot_script import ScriptStep
from g3.geometry.plane import convex_hull, point_gap, wrap
from g3.groundings import FloatArray
from tests.physics_scenes import yard


def run(*steps: tuple[str, str | float], forks_m: float = 0.0) -> Execution:
    done = execute(yard(), tuple(ScriptStep(*step) for step in steps), forks_m=forks_m)
    assert done.problems == ()
    return done


def ways(done: Execution, name: str = "robot") -> FloatArray:
    """x, y, yaw over time, shape (n, 3)."""
    i = [item.id for item in done.recording.start.objects].index(name)
    xy = done.recording.position[:, i, :2]
    return np.column_stack((xy, heading(done.recording.orientation[:, i])))


def outline(done: Execution, name: str) -> FloatArray:
    start = done.recording.start
    return convex_hull(next(o for o in start.objects if o.id == name).prism.xy)


def bearing(done: Execution, name: str) -> float:
    """Where an object is in the end, seen from the robot."""
    x, y, yaw = ways(done)[-1]
    middle = outline(done, name).mean(axis=0)
    return float(abs(wrap(np.arctan2(middle[1] - y, middle[0] - x) - yaw)))


@pytest.mark.parametrize("name", ["truck", "person", "tires"])
def test_the_robot_turns_to_face_things_and_away_from_them(name: str) -> None:
    facing = run(("face", name))
    assert bearing(facing, name) < 0.05
    assert np.ptp(ways(facing)[:, :2], axis=0).max() < 0.05
    assert bearing(run(("turn_away", name)), name) > np.pi - 0.05


@pytest.mark.parametrize("name", ["truck", "tires", "person"])
def test_the_robot_drives_away_from_things(name: str) -> None:
    done = run(("drive_away", name))
    way, hull = ways(done), outline(done, name)
    first, last = point_gap(way[None, [0, -1], :2], hull[None])[0]
    assert last > first + 1.5
    assert bearing(done, name) > np.pi / 2


def test_the_robot_lines_up_square_to_a_side_of_a_load() -> None:
    done = run(("line_up", "tires"))
    x, y, yaw = ways(done)[-1]
    tires = next(o for o in done.recording.start.objects if o.id == "tires")
    assert abs(wrap(4 * (yaw - tires.trajectory.yaw[0]))) < 0.05
    assert bearing(done, "tires") < 0.05
    gap = point_gap(np.array([[[x, y]]]), outline(done, "tires")[None])[0, 0]
    assert 1.5 < gap < 3.5  # in front of it, with the forks still outside
    np.testing.assert_array_equal(ways(done, "tires")[0], ways(done, "tires")[-1])


@pytest.mark.parametrize("name", ["truck", "trailer", "tires"])
def test_the_robot_parks_beside_things_and_parallel_to_them(name: str) -> None:
    done = run(("park", name))
    x, y, yaw = ways(done)[-1]
    thing = next(o for o in done.recording.start.objects if o.id == name)
    assert abs(wrap(4 * (yaw - thing.trajectory.yaw[0]))) < 0.1
    assert point_gap(np.array([[[x, y]]]), outline(done, name)[None])[0, 0] < 2.0
    assert np.pi / 4 < bearing(done, name) < 3 * np.pi / 4


def test_empty_forks_go_up_and_down() -> None:
    up, down = run(("raise_forks_m", 1.0)), run(("lower_forks_m", 5.0), forks_m=1.2)
    assert up.recording.fork_height_m[[0, -1]] == pytest.approx([LOW, LOW + 1.0], abs=0.01)
    assert down.recording.fork_height_m[[0, -1]] == pytest.approx([LOW + 1.2, LOW], abs=0.01)
    highest = run(("raise_forks_m", 9.0)).recording.fork_height_m
    assert highest[-1] == pytest.approx(LOW + LIFT_RANGE, abs=0.01)
    assert np.ptp(ways(up), axis=0).max() < 0.01


def test_what_is_on_the_forks_goes_up_with_them_and_does_not_touch_the_ground() -> None:
    done = run(("pick_up", "tires"), ("raise_forks_m", 0.8), ("lower_forks_m", 2.0))
    names = [item.id for item in done.recording.start.objects]
    high = done.recording.position[:, names.index("tires"), 2]
    at = [int(np.searchsorted(done.recording.t_s, step.end_s)) for step in done.recording.steps]
    picked, raised, lowered = high[np.minimum(at, len(high) - 1)]
    assert raised == pytest.approx(picked + 0.8, abs=0.02)
    assert lowered == pytest.approx(picked, abs=0.02)
    assert lowered > 0.05
