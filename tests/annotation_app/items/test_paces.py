"""Videos at another pace than their logs: parts of the one are parts of the other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from annotation_app.items.scenes import Scene
from tests.tiny_corpus import tiny_corpus


def scene(*clock: tuple[float, float]) -> Scene:
    context = next(iter(tiny_corpus().contexts.values()))
    return Scene(context, start_s=100.0, duration_s=8.0, steps=(), segmentation={}, clock=clock)


def test_by_itself_a_video_has_the_pace_of_its_log() -> None:
    assert scene().since_start(2.5) == 2.5
    assert scene().video_times(np.array([100.0, 103.0])) == pytest.approx([0.0, 3.0])


def test_a_video_that_is_twice_as_fast_and_leaves_out_ten_seconds() -> None:
    # 0 to 2 s show 0 to 4 s; the next frame, 0.04 s later, shows 14 s; 3 s more show 6 s.
    shown = scene((0.0, 0.0), (2.0, 4.0), (2.04, 14.0), (5.04, 20.0))
    assert [shown.since_start(t) for t in (0.0, 1.0, 2.04, 3.04)] == [0.0, 2.0, 14.0, 16.0]
    assert shown.video_times(np.array([102.0, 114.0, 116.0])) == pytest.approx([1.0, 2.04, 3.04])
    times = np.linspace(0, 5, 40)
    back = shown.video_times(np.array([100 + shown.since_start(t) for t in times]))
    assert back == pytest.approx(times)


def test_the_map_follows_the_video() -> None:
    plain = scene()
    agent = plain.context.agent
    begin = float(agent.trajectory.t[0])
    fast = replace(plain, start_s=begin, clock=((0.0, 0.0), (50.0, 100.0)))
    assert fast.video_times(agent.trajectory.t) == pytest.approx((agent.trajectory.t - begin) / 2)
