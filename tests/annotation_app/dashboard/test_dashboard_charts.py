"""Where charts have their lines, bars and labels."""

from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from annotation_app.dashboard.dashboard_charts import (
    BOTTOM,
    LABEL,
    LINES_HEIGHT,
    TOP,
    WIDTH,
    agreement_chart,
    history_chart,
    time_chart,
    written_time,
)
from annotation_app.dashboard.study_statistics import Duration, History
from annotation_app.tasks.agreement import Measured


def test_lines_begin_and_end_where_they_should() -> None:
    chart = history_chart([History("rate", (0.0, 50.0, 100.0), (0, 5, 8))])
    assert chart is not None
    # The axis goes from 0 to 8 by twos; the drawing is 200 high, with 10 above and 22 below.
    assert [tick.label for tick in chart.y_ticks] == ["0", "2", "4", "6", "8"]
    assert chart.lines[0].points == "34.0,178.0 156.0,73.0 278.0,10.0"
    assert [tick.label for tick in chart.x_ticks] == ["00:00:00", "00:00:50", "00:01:40"]
    assert written_time(86_400.0, 5 * 86_400.0) == "02 Jan"
    assert written_time(61.0, 60.0) == "00:01:01"


@given(
    st.lists(
        st.lists(st.integers(0, 10**6), min_size=2, max_size=2).map(sorted), min_size=1, max_size=8
    )
)
def test_nothing_leaves_the_drawing_and_no_label_covers_another(counts: list[list[int]]) -> None:
    histories = [History(f"t{i}", (0.0, 1.0), (a, b)) for i, (a, b) in enumerate(counts)]
    chart = history_chart(histories)
    assert chart is not None
    labels = sorted(line.label_y for line in chart.lines)
    assert all(b - a >= LABEL - 0.11 for a, b in pairwise(labels))
    for line in chart.lines:
        for point in line.points.split():
            x, y = map(float, point.split(","))
            assert 0 <= x <= WIDTH
            assert TOP <= y <= LINES_HEIGHT - BOTTOM
        assert TOP <= line.label_y <= LINES_HEIGHT - BOTTOM + 0.1


def test_bars_of_times() -> None:
    chart = time_chart([Duration("rate", 4, 10.0, 20.0, 40.0)])
    assert chart is not None
    (bar,) = chart.bars
    # The axis ends at 40 s, 340 from where it begins, at 4.
    assert (bar.start, bar.width, bar.mark) == (89.0, 255.0, 174.0)
    assert bar.value == "20 s (10 to 40 s)"


def test_agreement_below_chance_goes_to_the_left() -> None:
    good, bad = Measured("α", 0.5, 3, "rate"), Measured("κ", -0.5, 3, "check", "all")
    chart = agreement_chart([good, bad, Measured("κ", None, 3, "rate")])
    assert chart is not None
    one, other = chart.bars
    assert one.start == chart.zero == pytest.approx(175)
    assert other.start + other.width == pytest.approx(chart.zero)
    assert other.value == "−0.50"
    alone = agreement_chart([good])
    assert alone is not None
    assert alone.zero == 10  # nothing below 0: the axis begins there


def test_nothing_to_draw() -> None:
    assert history_chart([]) is None
    assert time_chart([]) is None
    assert agreement_chart([Measured("κ", None, 0)]) is None
