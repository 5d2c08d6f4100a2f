"""Where commands are followed."""

from __future__ import annotations

import pytest

from corpus_tools.following.start_states import scenario_start
from g3.actions.robot_state import with_moved


@pytest.mark.parametrize(
    ("scenario", "site"),
    [
        ("hall_pick_up_boxes", "hall"),
        ("dock_pick_up_tires", "depot"),
        ("court_go_to_second_truck", "yard"),
    ],
)
def test_a_start_knows_what_is_around_and_keeps_it(scenario: str, site: str) -> None:
    start = scenario_start(scenario)
    assert start.site == site
    assert with_moved(start, {}, None).site == site
