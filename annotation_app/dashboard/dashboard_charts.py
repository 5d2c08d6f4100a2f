"""Charts as geometry: the templates draw them as SVG, and show the same numbers as tables.

Lengths are in units of the drawing, which is 360 wide: about a pixel on a phone.
"""

from __future__ import annotations

import datetime
import math
from collections.abc import Sequence
from dataclasses import dataclass

from annotation_app.dashboard.study_statistics import Duration, History
from annotation_app.tasks.agreement import Measured

WIDTH = 360.0
SECONDS_BELOW_S, DAY_S = 600.0, 86_400.0
"""Shorter spans of time are shown with seconds, longer ones by days."""
LEFT, RIGHT, TOP, BOTTOM = 34.0, 82.0, 10.0, 22.0
LINES_HEIGHT = 200.0
ROW = 38.0
LABEL = 14.0
"""Smallest distance between labels."""
STYLES = 6
"""Number of line styles."""


@dataclass(frozen=True, slots=True)
class Tick:
    """A place on an axis."""

    at: float
    label: str


@dataclass(frozen=True, slots=True)
class Line:
    """A line with its name at its end."""

    label: str
    points: str
    end: float
    """Height of the end."""
    label_y: float
    style: int


@dataclass(frozen=True, slots=True)
class LineChart:
    """Lines over time."""

    height: float
    right: float
    bottom: float
    lines: tuple[Line, ...]
    x_ticks: tuple[Tick, ...]
    y_ticks: tuple[Tick, ...]


@dataclass(frozen=True, slots=True)
class Bar:
    """A row with a bar, of which a point may be marked."""

    label: str
    value: str
    y: float
    start: float
    width: float
    mark: float | None


@dataclass(frozen=True, slots=True)
class BarChart:
    """Rows of bars from where the axis has its zero."""

    height: float
    zero: float
    bars: tuple[Bar, ...]
    ticks: tuple[Tick, ...]


def history_chart(histories: Sequence[History]) -> LineChart | None:
    """Draw the number of answers over time; None if there are none."""
    if not histories:
        return None
    at = histories[0].at
    span = (at[-1] - at[0]) or 1.0
    most = max(max(history.answers) for history in histories)
    step, top = _axis(most)
    wide, high = WIDTH - LEFT - RIGHT, LINES_HEIGHT - TOP - BOTTOM

    def x(moment: float) -> float:
        return round(LEFT + wide * (moment - at[0]) / span, 1)

    def y(count: float) -> float:
        return round(TOP + high * (1 - count / top), 1)

    ends = _apart([y(history.answers[-1]) for history in histories], TOP, LINES_HEIGHT - BOTTOM)
    lines = tuple(
        Line(
            history.task,
            " ".join(f"{x(m)},{y(n)}" for m, n in zip(history.at, history.answers, strict=True)),
            y(history.answers[-1]),
            label_y,
            number % STYLES,
        )
        for number, (history, label_y) in enumerate(zip(histories, ends, strict=True))
    )
    moments = (at[0], at[0] + span / 2, at[0] + span)
    return LineChart(
        LINES_HEIGHT,
        WIDTH - RIGHT,
        LINES_HEIGHT - BOTTOM,
        lines,
        tuple(Tick(x(moment), written_time(moment, span)) for moment in moments),
        tuple(Tick(y(n), f"{n:g}") for n in (step * i for i in range(round(top / step) + 1))),
    )


def time_chart(durations: Sequence[Duration]) -> BarChart | None:
    """Draw the middle half of the times that people took, with the median marked."""
    if not durations:
        return None
    step, top = _axis(max(duration.upper_s for duration in durations))

    def x(seconds: float) -> float:
        return round((WIDTH - 20) * seconds / top + 4, 1)

    bars = tuple(
        Bar(
            d.task,
            f"{d.median_s:.0f} s ({d.lower_s:.0f} to {d.upper_s:.0f} s)",
            ROW * number,
            x(d.lower_s),
            round(max(x(d.upper_s) - x(d.lower_s), 1.0), 1),
            x(d.median_s),
        )
        for number, d in enumerate(durations)
    )
    ticks = tuple(Tick(x(step * i), f"{step * i:g} s") for i in range(round(top / step) + 1))
    return BarChart(ROW * len(bars) + BOTTOM, x(0), bars, ticks)


def agreement_chart(found: Sequence[Measured]) -> BarChart | None:
    """Draw the measures of agreement that could be computed."""
    known = [(one, one.value) for one in found if one.value is not None]
    if not known:
        return None
    lowest = -1.0 if any(value < 0 for _, value in known) else 0.0

    def x(value: float) -> float:
        part = (max(value, -1.0) - lowest) / (1 - lowest)
        return round((WIDTH - 30) * part + 10, 1)

    bars = tuple(
        Bar(
            f"{one.task}: {one.measure}{f', {one.answers}' if one.answers != 'all' else ''}",
            f"{value:.2f}".replace("-", "−"),
            ROW * number,
            min(x(0), x(value)),
            round(abs(x(value) - x(0)), 1),
            None,
        )
        for number, (one, value) in enumerate(known)
    )
    marks = (-1.0, -0.5, 0.0, 0.5, 1.0) if lowest else (0.0, 0.25, 0.5, 0.75, 1.0)
    ticks = tuple(Tick(x(mark), f"{mark:g}".replace("-", "−")) for mark in marks)
    return BarChart(ROW * len(bars) + BOTTOM, x(0), bars, ticks)


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


def _axis(most: float) -> tuple[float, float]:
    """Return a round distance of ticks, four or five to the top or fewer, and the top."""
    rough = max(most, 1.0) / 4
    power = 10.0 ** math.floor(math.log10(rough))
    found = next(power * n for n in (1, 2, 5, 10) if power * n >= rough)
    step = max(found, 1.0)
    return step, step * max(math.ceil(most / step), 1)


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
