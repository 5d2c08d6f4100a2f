from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from g3.features.avs.vector_sums import avs_directions, footprints
from g3.features.sets.reference_frames import (
    DIRECTIONS,
    intrinsic_yaw,
    speaker_yaw,
)
from tests.g3.features.scenes import one, row
from tests.worlds import log, prism, robot, scene, thing


def test_frames_of_start_and_speaker() -> None:
    # The agent at the origin faces +y; the landmark lies at +x, the figure north of it.
    landmark, figure = thing("landmark", "pallet", 10, 0), thing("figure", "pallet", 10, 8)
    world = scene(landmark, figure, agent=robot(log([(0, 0)], yaw=np.pi / 2)))
    example = row(world, "OBJECT", figure, landmark=(landmark,))
    start, speaker = one("avs-start", example), one("avs-speaker", example)
    # Ahead for the agent, but left of the line of sight to the landmark.
    assert start["start.front"] == 1.0
    assert speaker["speaker.left"] == 1.0
    assert start["start.back"] == speaker["speaker.right"] == 0.0


def test_speaker_yaw_is_the_line_of_sight() -> None:
    agent = np.array([[1.0, 1.0, 2.0]])
    assert_allclose(speaker_yaw(agent, np.array([[4, 4]])), np.pi / 4)


@pytest.mark.parametrize(
    ("agent_yaw", "expected"), [(0.3, 0.0), (2.0, np.pi), (-1.4, 0.0), (np.pi / 2, np.pi)]
)
def test_intrinsic_yaw_runs_along_the_longest_side(agent_yaw: float, expected: float) -> None:
    long = prism(0, 0, size=(6, 2)).xy[None]
    yaw = intrinsic_yaw(long, np.array([[0, 0, agent_yaw]]))
    assert_allclose(np.cos(yaw - expected), 1)


def test_of_a_squares_sides_the_one_along_the_agents_heading_counts() -> None:
    rng = np.random.default_rng(0)
    noisy = prism(0, 0).xy + rng.uniform(-1e-6, 1e-6, (20, 4, 2))
    agent = np.tile([0, 0, 1.2], (20, 1))
    assert_allclose(np.cos(intrinsic_yaw(noisy, agent) - np.pi / 2), 1)


def test_frames_of_the_log_see_the_whole_drive() -> None:
    landmark, figure = thing("landmark", "pallet", 10, 0), thing("figure", "pallet", 10, 8)
    turning = log([(0, 0), (1, 0), (2, 0)], yaw=[0, np.pi / 4, np.pi / 2])
    world = scene(landmark, figure, agent=robot(turning))
    values = one("avs-log", row(world, "OBJECT", figure, landmark=(landmark,)))
    assert values["end.front"] == 1.0
    assert values["end.left"] < 0.6
    assert_allclose(values["mean.front"], values["mean.left"])


def test_columns_are_the_directions() -> None:
    assert DIRECTIONS == ("front", "left", "back", "right")
    landmark = prism(0, 0).xy[None]
    degrees = avs_directions(np.array([[0.0, 5.0]]), footprints(landmark), np.zeros((1, 1)))
    assert DIRECTIONS[degrees.argmax()] == "left"
