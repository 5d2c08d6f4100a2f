"""Where charts have their lines, intervals and labels."""

from __future__ import annotations

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from annotation_app.dashboard.consensus import AgreementOverTime
from annotation_app.dashboard.dashboard_charts import (
    BOTTOM,
    HEIGHT,
    LABEL,
    LEFT,
    RIGHT,
    TOP,
    agreement_chart,
    history_chart,
    span_words,
    written_time,
)
from annotation_app.dashboard.study_statistics import History
from annotation_app.tasks.agreement import Measured


def test_lines_show_the_part_of_what_is_wanted() -> None:
    chart = history_chart([History("rate", (0.0, 50.0, 100.0), (0, 5, 12))], {"rate": 10})
    assert chart is not None
    # More answers than are wanted are no more than all.
    assert chart.lines[0].points == "0.00,100.00 50.00,50.00 100.00,0.00"
    assert (chart.lines[0].x, chart.lines[0].y) == (RIGHT, TOP)
    assert [tick.label for tick in chart.x_ticks] == ["00:00:00", "00:00:50", "00:01:40"]
    assert [tick.at for tick in chart.x_ticks] == [LEFT, (LEFT + RIGHT) / 2, RIGHT]
    assert written_time(86_400.0, 5 * 86_400.0) == "02 Jan"


@given(
    st.lists(
        st.lists(st.integers(0, 10**6), min_size=2, max_size=2).map(sorted), min_size=1, max_size=8
    )
)
def test_nothing_leaves_the_drawing_and_no_label_covers_another(counts: list[list[int]]) -> None:
    histories = [History(f"t{i}", (0.0, 1.0), (a, b)) for i, (a, b) in enumerate(counts)]
    chart = history_chart(histories, {one.task: 1000 for one in histories})
    assert chart is not None
    labels = sorted(line.label_y for line in chart.lines)
    assert all(b - a >= LABEL - 0.11 for a, b in pairwise(labels))
    for line in chart.lines:
        for point in line.points.split():
            assert all(0 <= float(number) <= 100 for number in point.split(","))
        assert TOP <= line.label_y <= HEIGHT - BOTTOM + 0.1


def test_intervals_of_agreement() -> None:
    first, second = Measured("α", 0.5, 12, low=0.25, high=0.75), Measured("α", 1.0, 12)
    chart = agreement_chart([AgreementOverTime("rate", (0.0, 10.0), (first, second))])
    assert chart is not None
    one, other = chart.lines[0].dots
    # The axis from 0 to 1 is 118 pixels long and begins at 8.
    assert (one.high, one.y, one.low) == (37.5, 67.0, 96.5)
    assert (other.y, other.low, other.high) == (TOP, None, None)
    below = Measured("κ", 0.1, 12, low=-0.2, high=0.4)
    chart = agreement_chart([AgreementOverTime("check", (5.0,), (below,))])
    assert chart is not None
    assert [tick.label for tick in chart.y_ticks] == ["−0.5", "0", "0.5", "1"]


def test_nothing_to_draw() -> None:
    assert history_chart([], {}) is None
    assert history_chart([History("rate", (0.0, 1.0), (0, 1))], {}) is None
    assert agreement_chart([AgreementOverTime("rate", (), ())]) is None


def test_spans_of_time_are_rough() -> None:
    spans = (0.2, 59, 600, 5400, 9_000, 3 * 86_400)
    assert [span_words(s) for s in spans] == ["1 s", "59 s", "10 min", "1.5 h", "2.5 h", "3 days"]
