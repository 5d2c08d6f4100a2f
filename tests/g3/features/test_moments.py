from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from g3.groundings import Path, Place, Trajectory
from tests.g3.features.scenes import one, row
from tests.worlds import line, log, prism, robot, scene, thing

# A square of 2 m; the robot is a square of 1.5 m, so the mean size is 1.75 m.
TARGET = thing("target", "pallet", 10, 0)


def moments(name: str, trajectory: Trajectory) -> dict[str, float]:
    world = scene(TARGET, agent=robot())
    type_ = "PATH" if name.startswith("path") else "EVENT"
    roles = {"landmark": (TARGET,)} if type_ == "PATH" else {"goal": (TARGET,)}
    return one(name, row(world, type_, Path(trajectory), **roles))  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["path-prisms", "event-prisms"])
def test_prisms_at_the_start_at_the_end_and_on_average(name: str) -> None:
    values = moments(name, log(line((0, 0), (8, 0))))
    # From 10 - 1 - 0.75 m to 8 m less.
    assert_allclose(values["start.gap"], 8.25 / 1.75)
    assert_allclose(values["end.gap"], 0.25 / 1.75)
    assert_allclose(values["mean.gap"], 4.25 / 1.75)
    assert_allclose([values["start.distance"], values["end.distance"]], [10 / 1.75, 2 / 1.75])
    assert values["end.contact"] == values["end.inside"] == 0
    assert_allclose(values["mean.size_ratio"], np.log10(1.5**2 / 4))


def test_the_prism_is_the_agents_wherever_the_trajectory_starts() -> None:
    there = moments("path-prisms", log(line((2, 0), (10, 0))))
    assert there["end.inside"] == 1
    assert_allclose(there["end.figure_overlap"], 1)
    assert_allclose(there["start.distance"], 8 / 1.75)


def test_the_prism_turns_with_the_trajectory() -> None:
    # Turned by 45 degrees, a corner of the robot reaches 1.5 / sqrt(2) m ahead.
    values = moments("path-prisms", log([(8, 0), (8, 0)], yaw=[0, np.pi / 4]))
    assert_allclose(values["start.gap"], (1 - 0.75) / 1.75)
    assert values["end.contact"] == 1
    assert_allclose(values["end.gap"], 0, atol=1e-9)


def test_an_average_of_binary_features_is_how_much_of_the_time() -> None:
    # At 0, 5, 10, 15 and 20 m along the way only the middle one is on the target.
    values = moments("path-prisms", log(line((0, 0), (20, 0))))
    assert_allclose(values["mean.inside"], 1 / 5)


@pytest.mark.parametrize("name", ["path-frames", "event-frames"])
@pytest.mark.parametrize(("y", "side"), [(6, "left"), (-6, "right")])
def test_sides_are_those_of_the_trajectorys_own_frames(name: str, y: float, side: str) -> None:
    values = moments(name, log(line((0, y), (10, y))))
    for moment in ("start", "end", "mean"):
        of_moment = {c: v for c, v in values.items() if c.startswith(moment)}
        assert max(of_moment, key=of_moment.__getitem__) == f"{moment}.{side}"
        assert of_moment[f"{moment}.{side}"] == 1.0


def test_frames_have_the_first_the_last_and_the_mean_heading() -> None:
    # It ends straight to the left of its first heading: ahead in its last.
    values = moments("path-frames", log([(0, 6), (10, 6)], yaw=[0, np.pi / 2]))
    assert values["start.left"] == values["end.front"] == 1.0
    assert_allclose(values["mean.front"], values["mean.left"])


def test_a_mean_heading_is_a_mean_of_directions() -> None:
    turned_back = log(line((0, 6), (10, 6), 3), yaw=[0, np.pi / 2, 0])
    around = log(line((0, 6), (10, 6), 3), yaw=[2 * np.pi, 2.5 * np.pi, 2 * np.pi])
    assert moments("path-frames", turned_back) == pytest.approx(moments("path-frames", around))


def test_events_without_a_goal_have_none() -> None:
    place = Place(prism(3, 3))
    example = row(scene(TARGET), "EVENT", Path(log([(0, 0)])), theme=(TARGET,))
    for name in ("event-prisms", "event-frames"):
        assert np.isnan(list(one(name, example).values())).all()
        path = row(scene(TARGET), "PATH", Path(log([(0, 0)])), landmark=(place,))
        assert np.isnan(list(one(name, path).values())).all()
