from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from corpus_tools.video.drawing.drawn_moments import clock, moving_objects, same_state, sampled
from corpus_tools.world.state.recording import heading
from tests.corpus_tools.video.recordings import CRATE, PALLET, ROBOT, drive


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


def test_a_faster_video_shows_every_other_moment():
    recording = drive(rate_hz=10)
    shown = sampled(recording, 10, speed=2)
    assert (shown.position == recording.position[::2]).all()
    # 16 frames of 0.1 s each show 0.2 s each.
    assert clock(shown, 10) == [(0.0, 0.0), (1.6, 3.2)]


def test_where_nothing_moves_for_long_only_its_ends_are_shown():
    recording = drive(rate_hz=10, still_s=7)
    shown = sampled(recording, 10, skip_idle=True)
    # It moves up to 3 s, and stands up to 10 s: one second is left after that, and one before.
    assert shown.t_s == pytest.approx([*np.arange(40) / 10, *np.arange(90, 101) / 10], abs=0.11)
    knots = clock(shown, 10)
    assert knots[0] == (0.0, 0.0)
    assert np.array(knots[1:3]) == pytest.approx(np.array([(3.9, 3.9), (4.0, 9.0)]), abs=0.11)
    assert knots[-1][1] == pytest.approx(10.1)
    for video_s, log_s in knots[:-1]:
        assert shown.t_s[round(video_s * 10)] == pytest.approx(log_s)


def test_what_moves_for_long_is_shown_whole():
    recording = drive(rate_hz=10)
    assert (sampled(recording, 10, skip_idle=True).t_ns == recording.t_ns).all()


def test_what_settles_by_less_than_anybody_sees_stands_still():
    recording = drive()
    down = np.zeros(recording.position.shape)
    down[5:, CRATE, 2] = -1
    settled, sunk = recording.position + 0.001 * down, recording.position + 0.01 * down
    assert moving_objects(replace(recording, position=settled)) == [ROBOT, PALLET]
    assert moving_objects(replace(recording, position=sunk)) == [ROBOT, PALLET, CRATE]
