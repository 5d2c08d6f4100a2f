from __future__ import annotations

import numpy as np
import pytest

from corpus_tools.world.physics.pacing import EMPTY, LIFT, Pace, ramp, references

TIMESTEP_S = 0.004


@pytest.mark.parametrize("way", [1e-9, 1e-6, 1e-4, 1e-3, 4e-3, 6e-3])
def test_a_way_of_millimetres_takes_no_longer_than_its_ramps(way: float) -> None:
    # From rest to rest over s with acceleration a takes 2 sqrt(s / a), and smoothing 0.4 s more.
    longest = 2 * np.sqrt(way / LIFT.acceleration) + 0.4 + 3 * TIMESTEP_S
    assert len(ramp(0.5, 0.5 + way, LIFT, TIMESTEP_S)) * TIMESTEP_S <= longest
    assert len(ramp(0.5, 0.5 - way, LIFT, TIMESTEP_S)) * TIMESTEP_S <= longest


def test_a_ramp_keeps_to_its_speed_and_acceleration() -> None:
    values = ramp(0.0, 3.0, Pace(0.5, 0.25), TIMESTEP_S)
    speed = np.diff(values) / TIMESTEP_S
    assert values[0] == 0.0
    assert values[-1] == pytest.approx(3.0)
    assert speed.max() == pytest.approx(0.5, abs=1e-3)
    assert np.abs(np.diff(speed) / TIMESTEP_S).max() <= 0.25 * 1.2  # interpolated
    # 0.5 m/s after 2 s and 0.5 m, the same at the end, 2 m in between: 2 + 4 + 2 s, smoothed.
    assert len(values) * TIMESTEP_S == pytest.approx(8.4, abs=0.1)


@pytest.mark.parametrize("length", [0.001, 0.015, 1.0])
def test_driving_a_straight_way_ends_where_it_leads(length: float) -> None:
    poses = references(np.zeros(3), ((length, 0.0),), EMPTY, TIMESTEP_S)
    assert poses[-1] == pytest.approx([length, 0.0, 0.0])
    assert len(poses) * TIMESTEP_S < 3.5
