"""Intervals and reliability diagrams as inline SVG, without scripts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import NamedTuple

from eval.report.reliability import Bin

INK, GREY, FAINT, BLUE, ORANGE = "#1f2430", "#6b7280", "#e3e6ea", "#0072b2", "#d55e00"
WIDTH, EDGE, LINE = 440, 8, 42
"""Of a chart of intervals, of its margins, and of a bar with its label above; pixels. Narrow, so
that it can be read on a telephone."""
SIDE, MARGIN = 340, 58
"""Of a reliability diagram, pixels."""
TICKS = (0.0, 0.25, 0.5, 0.75, 1.0)
SIGNED_TICKS = (-1.0, -0.5, 0.0, 0.5, 1.0)


@dataclass(frozen=True, slots=True)
class Bar:
    """A figure with its interval.

    Parameters
    ----------
    label
        What it is of.
    value, low, high
        NaN bounds draw no interval.
    paper
        The paper's figure; None if it has none.
    """

    label: str
    value: float
    low: float
    high: float
    paper: float | None = None


def intervals(bars: Sequence[Bar], title: str) -> str:
    """Figures between 0 and 1 as points with whiskers, the paper's as hollow diamonds."""
    return _intervals(bars, title, TICKS, "{:.2f}")


def differences(bars: Sequence[Bar], title: str) -> str:
    """Figures between -1 and 1 as points with whiskers, and a line where there is none."""
    return _intervals(bars, title, SIGNED_TICKS, "{:+.2f}")


def _intervals(bars: Sequence[Bar], title: str, ticks: Sequence[float], form: str) -> str:
    height = LINE * len(bars) + 30
    axis = _Axis(EDGE, WIDTH - EDGE, ticks[0], ticks[-1])
    parts = [_open(WIDTH, height, title)]
    anchors = ("start", *["middle"] * (len(ticks) - 2), "end")
    for tick, anchor in zip(ticks, anchors, strict=True):
        x = axis.at(tick)
        parts.append(_line(x, 4, x, height - 24, FAINT if tick or not ticks[0] else GREY))
        parts.append(_text(x, height - 8, f"{tick:g}", GREY, anchor))
    for i, bar in enumerate(bars):
        parts += _bar(bar, LINE * (i + 0.75), axis, form)
    return "".join([*parts, "</svg>"])


def reliability(bins: Sequence[Bin], title: str) -> str:
    """What was stated against what was true; the diagonal is perfect, area is the number."""
    inner = SIDE - 2 * MARGIN
    parts = [_open(SIDE, SIDE, title)]
    for tick in TICKS:
        along = MARGIN + tick * inner
        parts.append(_line(along, MARGIN, along, SIDE - MARGIN, FAINT))
        parts.append(_line(MARGIN, along, SIDE - MARGIN, along, FAINT))
        parts.append(_text(along, SIDE - MARGIN + 16, f"{tick:g}", GREY, "middle"))
        parts.append(_text(MARGIN - 6, SIDE - along + 4, f"{tick:g}", GREY, "end"))
    parts.append(_line(MARGIN, SIDE - MARGIN, SIDE - MARGIN, MARGIN, GREY, dash="4 4"))
    most = max((b.n for b in bins), default=1)
    for b in bins:
        x, y = MARGIN + b.stated * inner, SIDE - MARGIN - b.true * inner
        if not math.isnan(b.low):
            ends = (SIDE - MARGIN - bound * inner for bound in (b.low, b.high))
            parts.append(_line(x, next(ends), x, next(ends), BLUE, width=1.5))
        radius = 2.5 + 5.5 * math.sqrt(b.n / most)
        parts.append(
            f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius:.1f}" fill="{BLUE}" fill-opacity="0.75">'
            f"<title>{b.n}: stated {b.stated:.2f}, true {b.true:.2f}</title></circle>"
        )
    parts.append(_text(SIDE / 2, SIDE - 8, "stated probability", INK, "middle"))
    parts.append(
        f'<text transform="translate(14 {SIDE / 2}) rotate(-90)" text-anchor="middle" '
        f'fill="{INK}">part that is right</text>'
    )
    return "".join([*parts, "</svg>"])


class _Axis(NamedTuple):
    """Where figures lie, pixels."""

    left: float
    right: float
    least: float
    most: float

    def at(self, value: float) -> float:
        return self.left + (value - self.least) / (self.most - self.least) * (
            self.right - self.left
        )


def _bar(bar: Bar, y: float, axis: _Axis, form: str) -> list[str]:
    above = y - 13
    parts = [_text(axis.left, above, bar.label, INK)]
    if math.isnan(bar.value):
        return [*parts, _text(axis.right, above, "undefined", GREY, "end")]
    shown = form.format(bar.value)
    if not math.isnan(bar.low):
        between = "–" if axis.least == 0 else " to "
        shown += f" ({form.format(bar.low)}{between}{form.format(bar.high)})"
        parts.append(_line(axis.at(bar.low), y, axis.at(bar.high), y, BLUE, width=2.5))
    parts.append(f'<circle cx="{axis.at(bar.value):.1f}" cy="{y}" r="4.5" fill="{BLUE}"/>')
    if bar.paper is not None:
        x = axis.at(bar.paper)
        parts.append(
            f'<path d="M{x - 5:.1f} {y}L{x:.1f} {y - 5}L{x + 5:.1f} {y}L{x:.1f} {y + 5}Z" '
            f'fill="none" stroke="{ORANGE}" stroke-width="1.6">'
            f"<title>the paper: {bar.paper:.2f}</title></path>"
        )
    return [*parts, _text(axis.right, above, shown.replace("-", "−"), INK, "end")]


def _open(width: float, height: float, title: str) -> str:
    return (
        f'<svg viewBox="0 0 {width} {height}" width="{width}" height="{height}" role="img" '
        f'xmlns="http://www.w3.org/2000/svg"><title>{escape(title)}</title>'
    )


def _line(
    x: float, y: float, to_x: float, to_y: float, colour: str, *, width: float = 1, dash: str = ""
) -> str:
    dashed = f' stroke-dasharray="{dash}"' if dash else ""
    return (
        f'<line x1="{x:.1f}" y1="{y:.1f}" x2="{to_x:.1f}" y2="{to_y:.1f}" stroke="{colour}" '
        f'stroke-width="{width}"{dashed}/>'
    )


def _text(x: float, y: float, text: str, colour: str, anchor: str = "start") -> str:
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" fill="{colour}" text-anchor="{anchor}">'
        f"{escape(text)}</text>"
    )
