"""Charts as geometry, which a template draws as SVG.

A chart is as wide as its card. So horizontal lengths are percentages of its width, and texts keep
their size; vertical lengths are pixels.
"""

from __future__ import annotations

import datetime
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from annotation_app.dashboard.consensus import AgreementOverTime
from annotation_app.dashboard.study_statistics import History
from annotation_app.store.models import TaskName
from annotation_app.tasks.task_registry import task_names

SECONDS_BELOW_S, DAY_S = 600.0, 86_400.0
"""Shorter spans of time are shown with seconds, longer ones by days."""
HEIGHT, TOP, BOTTOM = 148.0, 8.0, 22.0
LEFT, RIGHT = 13.0, 80.0
"""Percentages of the width at which lines begin and end; labels follow."""
LABEL = 15.0
"""Smallest distance between labels."""
STYLES = 6
"""Number of line styles."""


@dataclass(frozen=True, slots=True)
class Tick:
    """A place on an axis."""

    at: float
    label: str


@dataclass(frozen=True, slots=True)
class Dot:
    """A measured point, with the bounds of its interval if it has one."""

    x: float
    y: float
    low: float | None = None
    high: float | None = None


@dataclass(frozen=True, slots=True)
class Line:
    """A line with its name at its end.

    `points` are in a square of 100 by 100, which is stretched to the chart.
    """

    label: str
    points: str
    dots: tuple[Dot, ...]
    x: float
    y: float
    """The line's end."""
    label_y: float
    style: int


@dataclass(frozen=True, slots=True)
class LineChart:
    """Lines over time."""

    lines: tuple[Line, ...]
    x_ticks: tuple[Tick, ...]
    y_ticks: tuple[Tick, ...]
    height: float = HEIGHT
    top: float = TOP
    bottom: float = BOTTOM
    left: float = LEFT
    right: float = RIGHT


@dataclass(frozen=True, slots=True)
class _Point:
    at: float
    value: float
    low: float | None = None
    high: float | None = None


def history_chart(histories: Sequence[History], wanted: Mapping[TaskName, int]) -> LineChart | None:
    """Draw the part of the wanted answers that was there at each time; None if there are none."""
    lines = {
        one.task: [
            _Point(at, min(n / wanted[one.task], 1.0))
            for at, n in zip(one.at, one.answers, strict=True)
        ]
        for one in histories
        if wanted.get(one.task)
    }
    ticks = {0.0: "0 %", 0.5: "50 %", 1.0: "100 %"}
    return _chart(lines, ticks, with_dots=False)


def agreement_chart(over_time: Sequence[AgreementOverTime]) -> LineChart | None:
    """Draw agreement over time with its intervals; None if there is none."""
    lines = {
        one.task: [
            _Point(at, m.value, m.low, m.high)
            for at, m in zip(one.at, one.measured, strict=True)
            if m.value is not None
        ]
        for one in over_time
    }
    least = min((p.value if p.low is None else p.low for s in lines.values() for p in s), default=0)
    below = {-1.0: "−1"} if least < -0.5 else {-0.5: "−0.5"} if least < 0 else {}
    return _chart(lines, {**below, 0.0: "0", 0.5: "0.5", 1.0: "1"}, with_dots=True)


def _chart(
    named: Mapping[str, Sequence[_Point]], y_labels: Mapping[float, str], *, with_dots: bool
) -> LineChart | None:
    series = {name: points for name, points in named.items() if points}
    if not series:
        return None
    order = task_names()
    times = [point.at for points in series.values() for point in points]
    first, last = min(times), max(times)
    low, high = min(y_labels), max(y_labels)

    def x(at: float) -> float:
        return 100.0 * (at - first) / (last - first) if last > first else 100.0

    def across(at: float) -> float:
        return round(LEFT + (RIGHT - LEFT) * x(at) / 100, 2)

    def y(value: float) -> float:
        return round(TOP + (HEIGHT - TOP - BOTTOM) * (high - value) / (high - low), 1)

    def dot(point: _Point) -> Dot:
        bounds = (None if bound is None else y(bound) for bound in (point.low, point.high))
        return Dot(across(point.at), y(point.value), *bounds)

    ends = _apart([y(points[-1].value) for points in series.values()], TOP, HEIGHT - BOTTOM)
    lines = tuple(
        Line(
            name,
            " ".join(f"{x(p.at):.2f},{100 * (high - p.value) / (high - low):.2f}" for p in points),
            tuple(map(dot, points)) if with_dots else (),
            across(points[-1].at),
            y(points[-1].value),
            label_y,
            order.index(name) % STYLES if name in order else 0,
        )
        for (name, points), label_y in zip(series.items(), ends, strict=True)
    )
    moments = (first, (first + last) / 2, last) if last > first else (last,)
    return LineChart(
        lines,
        tuple(Tick(across(moment), written_time(moment, last - first)) for moment in moments),
        tuple(Tick(y(value), label) for value, label in y_labels.items()),
    )


def written_time(at: float, span_s: float) -> str:
    """Format a moment, as finely as a span of time needs it, in UTC."""
    form = "%H:%M:%S" if span_s < SECONDS_BELOW_S else "%H:%M" if span_s < DAY_S else "%d %b"
    return in_utc(at, form)


def in_utc(at: float, form: str) -> str:
    """Format a moment as text; a question mark if a clock was far out."""
    try:
        return datetime.datetime.fromtimestamp(at, datetime.timezone.utc).strftime(form)
    except (OverflowError, OSError, ValueError):
        return "?"


def span_words(seconds: float) -> str:
    """Format a span of time roughly: "40 s", "35 min", "3.5 h", "12 days"."""
    for unit, length, digits in (("days", DAY_S, 0), ("h", 3600.0, 1), ("min", 60.0, 0)):
        if seconds >= (2 if unit == "days" else 1.5) * length:
            return f"{round(seconds / length, digits):g} {unit}"
    return f"{math.ceil(seconds)} s"


def _apart(wanted: Sequence[float], top: float, bottom: float) -> list[float]:
    """Return heights of labels that don't cover each other, as near as possible to those wanted."""
    order = sorted(range(len(wanted)), key=lambda i: wanted[i])
    found = list(wanted)
    lowest = top
    for i in order:
        found[i] = lowest = max(wanted[i], lowest)
        lowest += LABEL
    highest = bottom
    for i in reversed(order):
        found[i] = highest = min(found[i], highest)
        highest -= LABEL
    return [round(y, 1) for y in found]
