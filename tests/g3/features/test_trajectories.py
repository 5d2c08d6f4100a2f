from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from g3.features.sets.trajectories import Tracks, path_length
from g3.groundings import FloatArray, Path, PhysicalObject, Place, Trajectory
from tests.g3.features.scenes import Groundings, one, row
from tests.worlds import line, log, prism, robot, scene, thing


def shape(trajectory: Trajectory) -> dict[str, float]:
    return one("shape", row(scene(), "EVENT", Path(trajectory)))


def quarter_circle(side: int) -> Trajectory:
    """Radius 5, to the left (1) or the right (-1)."""
    turned = np.linspace(0, np.pi / 2, 200)
    xy = 5 * np.column_stack((np.sin(turned), side * (1 - np.cos(turned))))
    return log(xy, yaw=side * turned)


def test_driving_forward() -> None:
    values = shape(log(line((2, 1), (12, 1))))
    assert values == pytest.approx(
        {
            "forward": 1, "leftward": 0, "straight": 1, "turn": 0, "turning": 0,
            "reversing": 0, "reverses_first": 0, "reverses_last": 0, "first_turn": 0,
        }
    )  # fmt: skip


def test_driving_forward_in_another_direction_is_the_same() -> None:
    there = log(line((2, 1), (2, -9)), yaw=-np.pi / 2)
    assert shape(there) == pytest.approx(shape(log(line((0, 0), (10, 0)))), abs=1e-9)


def test_reversing() -> None:
    values = shape(log(line((0, 0), (-5, 0))))
    assert_allclose([values[c] for c in ("forward", "straight", "reversing")], [-1, 1, 1])
    assert values["reverses_first"] == values["reverses_last"] == 1


def test_backing_off_before_driving_on() -> None:
    values = shape(log(np.concatenate([line((0, 0), (-3, 0)), line((-3, 0), (6, 0))])))
    assert (values["reverses_first"], values["reverses_last"]) == (1, 0)
    assert_allclose(values["reversing"], 3 / 12, atol=0.05)
    assert_allclose([values["forward"], values["straight"]], [0.5, 0.5], atol=0.01)


@pytest.mark.parametrize("side", [1, -1])
def test_turning(side: int) -> None:
    values = shape(quarter_circle(side))
    ratio = 5 / (5 * np.pi / 2)
    assert_allclose(values["forward"], ratio, rtol=1e-3)
    assert_allclose(values["leftward"], side * ratio, rtol=1e-3)
    assert_allclose(values["straight"], np.sqrt(2) * ratio, rtol=1e-3)
    assert_allclose(values["turn"], side * np.pi / 2)
    assert_allclose(values["turning"], np.pi / 2)
    # A third of the way there are 8 of 24 steps.
    assert_allclose(values["first_turn"], side * np.pi / 6)
    assert values["reversing"] == 0


def test_turning_to_and_fro_is_turning_without_a_turn() -> None:
    values = shape(log([(0, 0)] * 3, yaw=[0, 1, 0]))
    assert_allclose([values["turn"], values["turning"]], [0, 2], atol=1e-9)


def test_a_trajectory_of_one_pose_has_a_shape() -> None:
    values = shape(log([(3, 3)], yaw=1.0))
    assert np.isfinite(list(values.values())).all()
    assert values["straight"] == values["turning"] == 0


def test_path_length() -> None:
    xyz = np.stack([np.column_stack((line((0, 0), (3, 4), 5), np.zeros(5))), np.zeros((5, 3))])
    still = np.zeros((2, 5))
    assert_allclose(path_length(Tracks(still, xyz, still)), [5, 0.1])


TARGET = thing("target", "pallet", 10, 0)


def approach(trajectory: Trajectory) -> dict[str, float]:
    path = row(scene(TARGET), "PATH", Path(trajectory), landmark=(TARGET,))
    values = one("path-landmark", path)
    event = row(scene(TARGET), "EVENT", Path(trajectory), goal=(TARGET,), theme=(TARGET,))
    assert one("event-goal", event) == pytest.approx(values)
    assert one("event-theme", event) == pytest.approx(values)
    return values


def test_approaching_a_landmark() -> None:
    # From 9 m to 1 m before its side; its reach is its size and a metre: 3 m.
    values = approach(log(line((0, 0), (8, 0))))
    assert values == pytest.approx(
        {
            "start_gap": 3, "end_gap": 1 / 3, "nearest_gap": 1 / 3, "mean_gap": 5 / 3,
            "toward": 1, "end_to_start": 1.1 / 9.1, "end_to_nearest": 0, "along": 6 / 25,
            "facing_end": 1, "facing_start": 1, "beside_end": 0,
        }
    )  # fmt: skip


def test_leaving_a_landmark() -> None:
    values = approach(log(line((8, 0), (0, 0)), yaw=np.pi))
    assert_allclose(values["toward"], -1)
    assert_allclose(values["end_to_start"], 9.1 / 1.1)
    assert_allclose(values["end_to_nearest"], 8 / 3)
    assert_allclose([values["facing_start"], values["facing_end"]], -1)


def test_passing_a_landmark() -> None:
    values = approach(log(line((0, -2), (20, -2))))
    assert_allclose(values["toward"], 0, atol=1e-9)
    assert_allclose(values["nearest_gap"], 1 / 3)
    assert_allclose(values["start_gap"], values["end_gap"])
    assert values["end_to_nearest"] > 2


def test_stopping_beside_a_landmark() -> None:
    # It ends up on the left.
    assert_allclose(approach(log(line((0, -3), (10, -3))))["beside_end"], 1)


# The robot drives 10 m in 10 s; what it carries is logged ten times a second.
DRIVE = log(line((0, 0), (10, 0), 101), t=np.linspace(0, 10, 101))


def carried(begin: float, end: float, *, late: float = 0.0, aside: float = 0.0) -> PhysicalObject:
    """A pallet that hangs at the robot, half a metre up, between two times."""
    t = DRIVE.t[(DRIVE.t >= begin) & (DRIVE.t <= end)]
    first, last = ([0.0], [0.0]) if begin > 0 else ([], [0.0])
    x = np.concatenate([t[: len(first)], t, t[-1:]])
    z = np.concatenate([first, np.full(len(t), 0.5), last])
    times = np.concatenate([t[: len(first)] - 1, t, t[-1:] + 0.01])
    if end >= 10:
        x, z, times = x[:-1], z[:-1], times[:-1]
    xy = np.column_stack((x, np.full(len(x), aside)))
    path = log(xy, z=z, t=times + late)
    return thing("pallet", "tire pallet", x[0], aside, trajectory=path)


def motion(
    theme: PhysicalObject, drive: Trajectory = DRIVE, goal: Groundings = ()
) -> dict[str, float]:
    world = scene(theme, agent=robot(drive))
    example = row(world, "EVENT", world.agent, theme=(theme,), goal=goal)
    name = "theme-goal" if goal else "theme-motion"
    return one(name, example)


def test_picking_up() -> None:
    values = motion(carried(5, 10))
    assert (values["moved"], values["left_alone"]) == (1, 0)
    # It hangs half of its height up, for 12 of 24 samples and the step in which it is lifted.
    assert_allclose([values["lifted"], values["rise"]], 0.5)
    assert_allclose(values["carried"], 0.5, atol=2 / 24)
    assert_allclose(values["displacement"], 0.5)
    assert (values["held_at_start"], values["held_at_end"]) == (0, 1)
    assert values["released"] == 0
    assert_allclose(values["agent_away_at_end"], 0, atol=1e-9)


def test_putting_down_and_driving_on() -> None:
    values = motion(carried(0, 4))
    assert (values["moved"], values["released"]) == (1, 1)
    assert (values["held_at_start"], values["held_at_end"]) == (1, 0)
    assert_allclose(values["rise"], -0.5)
    assert_allclose(values["lifted"], 0)
    assert_allclose(values["displacement"], 0.4)
    # It stays 6 m behind; its reach is its size and a metre.
    assert_allclose(values["agent_away_at_end"], 6 / 3)


def test_putting_down_and_backing_off() -> None:
    there_and_back = np.concatenate([line((0, 0), (5, 0), 51), line((4.9, 0), (0, 0), 50)])
    drive = log(there_and_back, t=np.linspace(0, 10, 101))
    values = motion(carried(0, 5), drive)
    assert (values["moved"], values["released"]) == (1, 1)
    assert_allclose(values["displacement"], 0.5)
    assert_allclose(values["agent_away_at_end"], 5 / 3, atol=1e-6)


def left_alone(theme: PhysicalObject) -> bool:
    values = motion(theme)
    flat = all(values[c] == 0 for c in ("moved", "lifted", "rise", "carried", "displacement"))
    still = not (values["held_at_start"] or values["held_at_end"] or values["released"])
    return values["left_alone"] == 1 and flat and still


def test_a_thing_that_nobody_touches_is_left_alone() -> None:
    assert left_alone(thing("pallet", "tire pallet", 5, 3))


@pytest.mark.parametrize("late", [1000.0, -1000.0])
def test_a_thing_whose_log_runs_at_another_time_is_left_alone(late: float) -> None:
    assert left_alone(carried(5, 10, late=late))
    assert left_alone(carried(0, 5, late=late))


def test_a_thing_that_moves_far_from_the_robot_is_left_alone() -> None:
    assert left_alone(carried(5, 10, aside=8))
    assert not left_alone(carried(5, 10, aside=1))


def test_noise_of_the_log_moves_nothing() -> None:
    shaken = log([(5, 0), (5.1, 0), (5, 0.1)], t=[2, 4, 6])
    assert left_alone(thing("pallet", "tire pallet", 5, 0, trajectory=shaken))


def other_log(theme: PhysicalObject) -> dict[str, float]:
    """What one sees of a theme when the event's trajectory is from another log."""
    elsewhere = Path(log(line((40, 0), (50, 0)), t=np.linspace(500, 510, 11)))
    world = scene(theme, agent=robot(DRIVE))
    return one("theme-motion", row(world, "EVENT", elsewhere, theme=(theme,)))


def test_a_theme_of_another_log_looks_like_one_that_stands_still() -> None:
    still = thing("pallet", "tire pallet", 5, 0)
    assert other_log(carried(5, 10)) == pytest.approx(other_log(still))


def test_loading_onto_a_trailer() -> None:
    bed = thing("trailer", "trailer", 10, 0, (6, 3), (0, 0.5))
    values = motion(carried(2, 10), goal=(bed,))
    assert (values["end.supports"], values["start.supports"]) == (1, 0)
    assert_allclose(values["end.distance"], 0, atol=1e-9)
    assert_allclose(values["end.height_above"], 0)
    assert_allclose(values["start.height_above"], -0.5)
    # It comes 8 m nearer on a drive of 10 m.
    assert_allclose(values["toward"], 0.8)


def test_a_theme_left_alone_lies_to_the_goal_as_before() -> None:
    place = Place(prism(5, 6))
    values = motion(thing("pallet", "tire pallet", 5, 0), goal=(place,))
    assert values["toward"] == 0
    for column in ("gap", "distance", "supports"):
        assert values[f"end.{column}"] == values[f"start.{column}"]


def test_a_carried_thing_turns_with_the_robot() -> None:
    # 4 m by 1 m, turned by a quarter at the end: it reaches over the place on its left.
    turn = np.linspace(0, np.pi / 2, 11)
    xy: FloatArray = np.column_stack((np.linspace(0, 1, 11), np.zeros(11)))
    held = thing("plank", "pallet", 0, 0, (4, 1), trajectory=log(xy, yaw=turn))
    place = Place(prism(1, 1.5, (0.5, 0.5)))
    values = motion(held, log(xy, yaw=turn), goal=(place,))
    assert_allclose(values["end.landmark_overlap"], 1)
    assert values["start.landmark_overlap"] == 0
