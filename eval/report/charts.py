"""The plots of a report: intervals, differences, reliability diagrams."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from corpus_tools.corpus.estimate import Estimate
from eval.report.plan_results import Bin
from eval.tables.plot_style import BLUE, FAINT, GREEN, GREY, GROUND, INK, NARROW, ORANGE, Plot

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

UNIT = 0.185
"""Height of a line of text, inches."""
LETTER, COLUMN = 0.058, 1.05
"""Widths of a letter of a label and of a column of figures, inches."""
SERIES = ((BLUE, "o"), (GREEN, "s"))
"""Colours and marks of a line's figures."""


@dataclass(frozen=True, slots=True)
class Line:
    """A line of a plot: figures with their intervals."""

    label: str
    figures: Mapping[str, Estimate]
    """Figures by name; NaN bounds draw no interval, a NaN value nothing."""
    paper: float | None = None
    """The paper's figure; None if it has none."""
    is_baseline: bool = False
    """True for a baseline."""

    @property
    def colour(self) -> str:
        """Colour of the label."""
        return GREY if self.is_baseline else INK


@dataclass(frozen=True, slots=True)
class _Scale:
    """Ticks of an axis, and the format of its figures."""

    ticks: Sequence[float]
    form: str
    between: str

    def text(self, figure: Estimate) -> str:
        if math.isnan(figure.value):
            return "–"
        bounds = "–"
        if not math.isnan(figure.low):
            bounds = self.between.join(map(self.form.format, (figure.low, figure.high)))
        return f"{self.form.format(figure.value)} ({bounds})".replace("-", "−")


SHARES = _Scale((0.0, 0.25, 0.5, 0.75, 1.0), "{:.2f}", "–")
DIFFERENCES = _Scale((-1.0, -0.5, 0.0, 0.5, 1.0), "{:+.2f}", " to ")


def intervals(lines: Sequence[Line], title: str) -> Plot:
    """Plot figures between 0 and 1 as points with whiskers, the paper's as hollow diamonds."""
    return Plot(title, partial(_drawn, lines, SHARES))


def differences(lines: Sequence[Line], title: str) -> Plot:
    """Plot figures between -1 and 1 as points with whiskers, and a line at no difference."""
    return Plot(title, partial(_drawn, lines, DIFFERENCES))


def reliability(bins: Sequence[Bin], title: str) -> Plot:
    """Plot observed against stated probabilities; a marker's area shows the number."""
    return Plot(title, partial(_reliability, bins))


def _drawn(lines: Sequence[Line], scale: _Scale, width: float) -> Figure:
    names = list(dict.fromkeys(name for line in lines for name in line.figures))
    return (_narrow if width <= NARROW else _wide)(lines, names, scale, width)


def _wide(lines: Sequence[Line], names: Sequence[str], scale: _Scale, width: float) -> Figure:
    """Labels at the left, figures in columns at the right."""
    step = 1 + 0.45 * (len(names) - 1)
    column = COLUMN + 0.45 * (scale is DIFFERENCES)
    has_paper = any(line.paper is not None for line in lines)
    left = 0.15 + LETTER * max((len(line.label) for line in lines), default=0)
    right = column * len(names) + 0.5 * has_paper
    has_heads = has_paper or len(names) > 1
    axes = _axes(width, left, right, (-0.6 - 0.9 * has_heads, step * len(lines) - 0.5), scale)
    for i, line in enumerate(lines):
        y = i * step + (step - 1) / 2
        _write(axes, 0, y, line.label, offset=-left, colour=line.colour)
        for j, (name, figure) in enumerate(line.figures.items()):
            place = names.index(name)
            _mark(axes, y + 0.38 * (j - (len(line.figures) - 1) / 2), figure, SERIES[place])
            at = column * (place + 1)
            _write(axes, 1, y, scale.text(figure), offset=at, ha="right", colour=SERIES[place][0])
        if line.paper is not None:
            _diamond(axes, y, line.paper)
            _write(axes, 1, y, f"{line.paper:.2f}", offset=right, ha="right", colour=ORANGE)
    for i, name in enumerate(names if has_heads else ()):
        _write(axes, 1, -1, name, offset=column * (i + 1), ha="right", colour=SERIES[i][0])
    if has_paper:
        _write(axes, 1, -1, "paper", offset=right, ha="right", colour=ORANGE)
    return _figure_of(axes)


def _narrow(lines: Sequence[Line], names: Sequence[str], scale: _Scale, width: float) -> Figure:
    """Labels and figures above each bar."""
    several = len(names) > 1
    rows = sum(1.7 * len(line.figures) + several for line in lines)
    axes = _axes(width, 0.06, 0.06, (-0.6, rows - 0.2), scale)
    y = 0.0
    for line in lines:
        if several:
            _write(axes, 0, y, line.label, colour=line.colour)
            y += 1
        for name, figure in line.figures.items():
            style = SERIES[names.index(name)]
            label, colour = (name, style[0]) if several else (line.label, line.colour)
            _write(axes, 0, y, label, colour=colour)
            _write(axes, 1, y, scale.text(figure), ha="right", colour=style[0])
            _mark(axes, y + 0.75, figure, style)
            if line.paper is not None and name == names[0]:
                _diamond(axes, y + 0.75, line.paper)
            y += 1.7
    return _figure_of(axes)


def _axes(
    width: float, left: float, right: float, span: tuple[float, float], scale: _Scale
) -> Axes:
    """Make empty axes with margins in inches, and room for a span of lines."""
    # Not pyplot: it keeps global state and picks a window system.
    from matplotlib.figure import Figure  # noqa: PLC0415

    foot, edge = 0.24, 0.03
    height = UNIT * (span[1] - span[0]) + foot
    figure = Figure(figsize=(width, height))
    inner = (width - left - right - 2 * edge) / width
    axes = figure.add_axes(((left + edge) / width, foot / height, inner, 1 - foot / height))
    axes.set_xlim(scale.ticks[0], scale.ticks[-1])
    axes.set_ylim(span[1], span[0])
    axes.set_xticks(scale.ticks, [f"{t:g}".replace("-", "−") for t in scale.ticks])
    axes.set_yticks([])
    _quiet(axes, axis="x")
    if scale.ticks[0] < 0:
        axes.axvline(0, color=GREY, linewidth=0.8)
    return axes


def _figure_of(axes: Axes) -> Figure:
    figure: Any = axes.figure
    return figure  # type: ignore[no-any-return]


def _write(
    axes: Axes, x: float, y: float, text: str, *, colour: str, offset: float = 0, ha: str = "left"
) -> None:
    """Write beside the axes' left or right end, an offset in inches away."""
    axes.annotate(
        text,
        xy=(x, y),
        xycoords=("axes fraction", "data"),
        xytext=(72 * offset, 0),
        textcoords="offset points",
        ha=ha,
        va="center_baseline",
        color=colour,
        annotation_clip=False,
    )


def _mark(axes: Axes, y: float, figure: Estimate, shown: tuple[str, str]) -> None:
    """Draw a point with its interval; a hollow one where there is none."""
    colour, marker = shown
    has_interval = not math.isnan(figure.low)
    if has_interval:
        axes.plot([figure.low, figure.high], [y, y], color=colour, linewidth=1.6, clip_on=False)
    face = colour if has_interval else GROUND
    style: dict[str, Any] = {"color": colour, "markerfacecolor": face, "markersize": 4.5}
    axes.plot([figure.value], [y], marker, clip_on=False, **style)


def _diamond(axes: Axes, y: float, value: float) -> None:
    axes.plot([value], [y], "D", color=ORANGE, markerfacecolor="none", markersize=4.5)


def _quiet(axes: Axes, **grid: Any) -> None:
    """Leave axes with nothing but a faint grid behind the data."""
    axes.grid(color=FAINT, linewidth=0.7, **grid)
    axes.set_axisbelow(True)
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)


def _reliability(bins: Sequence[Bin], width: float) -> Figure:
    from matplotlib.figure import Figure  # noqa: PLC0415

    figure = Figure(figsize=(width, min(width, 3.2)), layout="constrained")
    axes = figure.add_subplot()
    axes.plot([0, 1], [0, 1], color=GREY, linewidth=0.8, linestyle=(0, (4, 3)))
    most = max((b.n for b in bins), default=1)
    for b in bins:
        has_interval = not math.isnan(b.low)
        if has_interval:
            axes.plot([b.stated] * 2, [b.low, b.high], color=BLUE, linewidth=1.2)
        axes.plot(
            [b.stated],
            [b.true],
            "o",
            color=BLUE,
            markerfacecolor=BLUE if has_interval else GROUND,
            markersize=3 + 6 * math.sqrt(b.n / most),
            clip_on=False,
        )
        axes.annotate(
            f"{b.n:,}",
            xy=(b.stated, -0.075),
            ha="center",
            fontsize=6.5,
            color=GREY,
        )
    axes.set_xlim(0, 1)
    axes.set_ylim(-0.1, 1)
    axes.set_xticks(SHARES.ticks, [f"{t:g}" for t in SHARES.ticks])
    axes.set_yticks(SHARES.ticks, [f"{t:g}" for t in SHARES.ticks])
    axes.set_xlabel("stated probability (small numbers: how many)")
    axes.set_ylabel("part that is right")
    _quiet(axes)
    return figure
