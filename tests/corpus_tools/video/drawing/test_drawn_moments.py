from __future__ import annotations

import numpy as np
import pytest

from corpus_tools.video.drawing.drawn_moments import moving_objects, same_state, sampled
from corpus_tools.world.state.recording import heading
from tests.corpus_tools.video.recordings import PALLET, ROBOT, drive


def test_a_recording_at_the_videos_rate_comes_through_unchanged():
    recording = drive(rate_hz=10)
    again = sampled(recording, 10)
    for name in ("t_ns", "position", "orientation", "fork_height_m"):
        assert (getattr(again, name) == getattr(recording, name)).all()


def test_moments_between_are_interpolated():
    # From 1 s to 2 s the forks rise by 1 m; from 2 s to 3 s the robot turns by 0.8.
    shown = sampled(drive(rate_hz=1), 4)
    assert shown.t_s == pytest.approx(np.arange(13) / 4)
    assert np.diff(shown.fork_height_m[4:9]) == pytest.approx(0.25)
    assert heading(shown.orientation[10, ROBOT]) == pytest.approx(0.4)
    assert np.linalg.norm(shown.orientation, axis=-1) == pytest.approx(1)


def test_the_robot_and_what_it_carries_move():
    assert moving_objects(drive()) == [ROBOT, PALLET]


def test_stillness_is_noticed():
    recording = drive(rate_hz=10, still_s=1)
    assert same_state(recording, 31, 40)
    assert not same_state(recording, 25, 26)
