from __future__ import annotations

import numpy as np
import pytest

from corpus_tools.world.scenarios.boxes import Box
from corpus_tools.world.scenarios.random_scenarios import TURNING_M, connected
from corpus_tools.world.scenarios.scenario import Bounds

BOUNDS = Bounds((-10, 10), (-10, 10))
ENDS = np.array([[-7.0, 0.0], [7.0, 0.0]])


def wall(gap, yaw=0.0):
    """A wall along y through the origin, turned, with a gap of so many metres in the middle."""
    length = 20.0
    turn = np.array([np.cos(yaw + np.pi / 2), np.sin(yaw + np.pi / 2)])
    return [
        Box(np.array([*(side * turn * (length + gap) / 2), yaw]), (0.4, length), 0.0, 1.0)
        for side in (-1, 1)
    ]


@pytest.mark.parametrize("yaw", [0.0, 0.3, -1.0])
def test_a_gap_must_be_wide_enough_to_turn_in(yaw):
    assert connected(ENDS, wall(2 * TURNING_M + 1.0, yaw), BOUNDS)
    assert not connected(ENDS, wall(2 * TURNING_M - 0.2, yaw), BOUNDS)


def test_points_must_be_free_and_inside():
    assert connected(ENDS, [], BOUNDS)
    assert not connected(ENDS + 4, [], BOUNDS)
    assert not connected(ENDS, [Box(np.array([7.5, 0, 0]), (1, 1), 0.0, 1.0)], BOUNDS)
