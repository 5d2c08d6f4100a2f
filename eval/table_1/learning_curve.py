"""The learning curve: test error against the number of annotated SDCs trained on.

The paper found "that the test error asymptotes at around 1,000 (of 3,000) annotated
SDCs" (section 4.2); the plot marks that place.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from corpus_tools.corpus.estimate import Reason
from corpus_tools.runtime.text_tables import figure_table
from eval.table_1.correspondence import ROW_TYPES, RowType
from eval.tables.formats import (
    Format,
    comments,
    delimited,
    document,
    figure,
    metadata_text,
    table_text,
)
from eval.tables.latex import tabular
from eval.tables.plot_style import (
    BLUE,
    FAINT,
    GREEN,
    GREY,
    GROUND,
    INK,
    NARROW,
    ORANGE,
    PURPLE,
    Plot,
    PlotFormat,
)
from g3.errors import FormatError
from g3.short_repr import short_repr
from g3.storage.atomic_file import write_bytes

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PAPER_ASYMPTOTE_SDCS = 1000
"""Number of SDCs at which the paper's test error stops falling (section 4.2)."""

PLOT_SUFFIXES: Mapping[str, PlotFormat] = {".png": "png", ".svg": "svg", ".pdf": "pdf"}

STYLES: Mapping[RowType, tuple[str, str]] = {
    "OBJECT": (BLUE, "o"),
    "PLACE": (ORANGE, "s"),
    "PATH": (GREEN, "^"),
    "EVENT": (PURPLE, "D"),
    "overall": (INK, "o"),
}
"""Colours, and marks that distinguish curves in grey print."""
TEXT_HEIGHT = 0.055
"""Height of a line of text beside the plot, as a fraction of the axes."""


@short_repr
@dataclass(frozen=True, slots=True)
class CurvePoint:
    """The test error of models trained on a number of SDCs.

    Parameters
    ----------
    sdcs
        Number of annotated SDCs trained on.
    error
        Mean fraction of test examples whose φ is predicted wrongly.
    low, high
        Bounds of its interval; NaN if there is none.
    reason
        Reason for a missing error; empty if there is one.
    """

    type: RowType
    sdcs: int
    error: float
    low: float
    high: float
    reason: Reason = ""


def write_csv(
    points: Sequence[CurvePoint], path: Path, *, metadata: Mapping[str, object] | None = None
) -> None:
    """Write points as CSV, a line each, ordered by type and size, with metadata; atomically."""
    columns = [field.name for field in fields(CurvePoint)]
    text = delimited([asdict(p) for p in _ordered(points)], metadata or {}, columns=columns)
    write_bytes(path, (text + "\n").encode())


def render(points: Sequence[CurvePoint], form: Format, metadata: Mapping[str, object]) -> str:
    """Render the points in one of the formats of tables, ordered by type and size."""
    records = [asdict(point) for point in _ordered(points)]
    columns = [field.name for field in fields(CurvePoint)]
    if form == "json":
        return document({"rows": records}, metadata)
    if form == "csv":
        return delimited(records, metadata, columns=columns)
    headings = ("Type", "SDCs", "Error", "Least", "Greatest")
    cells = [
        [p.type, str(p.sdcs), *(figure(one) for one in (p.error, p.low, p.high))]
        for p in _ordered(points)
    ]
    if form == "latex":
        return tabular(headings, cells, comments=comments(metadata))
    table = figure_table(headings, cells)
    title = "Test error by the number of annotated SDCs trained on"
    return table_text({title: table}, (), metadata, terminal=False)


def write_plot(
    points: Sequence[CurvePoint],
    path: Path,
    *,
    metadata: Mapping[str, object] | None = None,
    bounds: str = "95% intervals",
) -> None:
    """Plot the curve as PNG, SVG or PDF, by the path's suffix; atomically.

    The same points give the same bytes with the same version of matplotlib.

    Parameters
    ----------
    points
        The curve, in any order; types without a defined error are left out.
    metadata
        Metadata for the file's description.
    bounds
        Meaning of lows and highs; stands at the axis.
    """
    suffix = PLOT_SUFFIXES.get(path.suffix.lower())
    if suffix is None:
        raise FormatError(
            f"can't plot to a {path.suffix or 'suffixless'} file",
            where=str(path),
            fix=f"end the name in {' or '.join(PLOT_SUFFIXES)}",
        )
    plot = curve_plot(points, bounds)
    write_bytes(path, plot.saved(suffix, description=metadata_text(metadata or {})))


def curve_plot(points: Sequence[CurvePoint], bounds: str) -> Plot:
    """Return the plot of the curve; `bounds` is the meaning of lows and highs."""
    return Plot("Learning curve", partial(_plot, points, bounds))


def _ordered(points: Sequence[CurvePoint]) -> list[CurvePoint]:
    return sorted(points, key=lambda p: (ROW_TYPES.index(p.type), p.sdcs))


def _plot(points: Sequence[CurvePoint], bounds: str, width: float) -> Figure:
    # Not pyplot: it keeps global state and picks a window system.
    from matplotlib.figure import Figure  # noqa: PLC0415
    from matplotlib.ticker import PercentFormatter, StrMethodFormatter  # noqa: PLC0415

    figure = Figure(figsize=(width, 3.4 if width > NARROW else 3), layout="constrained")
    axes = figure.add_subplot()
    defined = [p for p in _ordered(points) if not math.isnan(p.error)]
    curves = {kind: [p for p in defined if p.type == kind] for kind in ROW_TYPES}
    curves = {kind: curve for kind, curve in curves.items() if curve}
    for kind, curve in curves.items():
        _draw(axes, kind, curve)

    right = max((p.sdcs for p in defined), default=PAPER_ASYMPTOTE_SDCS)
    axes.set_xlim(0, max(right, PAPER_ASYMPTOTE_SDCS * 1.1))
    tops = [value for p in defined for value in (p.error, p.high) if not math.isnan(value)]
    axes.set_ylim(0, min(1.0, max(tops, default=0.5) * 1.08 + 0.01))
    axes.set_xlabel("Annotated SDCs trained on")
    axes.set_ylabel(f"Test error\n(bands: {bounds})")
    axes.xaxis.set_major_formatter(StrMethodFormatter("{x:,.0f}"))
    axes.yaxis.set_major_formatter(PercentFormatter(xmax=1, decimals=0))
    axes.grid(axis="y", color=FAINT, linewidth=0.7)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    _mark_asymptote(axes)
    _name_curves(axes, curves)
    return figure


def _draw(axes: Axes, kind: RowType, curve: Sequence[CurvePoint]) -> None:
    colour, marker = STYLES[kind]
    overall = kind == "overall"
    sdcs = [p.sdcs for p in curve]
    lows, highs = [p.low for p in curve], [p.high for p in curve]
    if len(curve) == 1:
        axes.vlines(sdcs, lows, highs, color=colour, alpha=0.5, zorder=2)
    axes.fill_between(sdcs, lows, highs, color=colour, alpha=0.16 if overall else 0.07, linewidth=0)
    axes.plot(
        sdcs,
        [p.error for p in curve],
        color=colour,
        marker=marker,
        markersize=4.5 if overall else 3.5,
        linewidth=2.4 if overall else 1.4,
        zorder=4 if overall else 3,
        # A point at the edge of the axes would lose half its marker.
        clip_on=False,
    )


def _mark_asymptote(axes: Axes) -> None:
    axes.axvline(PAPER_ASYMPTOTE_SDCS, color=GREY, linewidth=1, linestyle=(0, (4, 3)), zorder=1)
    crowded = axes.get_xlim()[1] < 1.5 * PAPER_ASYMPTOTE_SDCS
    axes.annotate(
        f"paper: error levels off\naround {PAPER_ASYMPTOTE_SDCS:,} SDCs",
        xy=(PAPER_ASYMPTOTE_SDCS, 1),
        xycoords=("data", "axes fraction"),
        xytext=(-5 if crowded else 5, -2),
        textcoords="offset points",
        ha="right" if crowded else "left",
        va="top",
        fontsize=7,
        color=GREY,
        bbox={"facecolor": GROUND, "edgecolor": "none", "pad": 1.5},
        zorder=2,
    )


def _name_curves(axes: Axes, curves: Mapping[RowType, Sequence[CurvePoint]]) -> None:
    """Write each curve's name beside its last point, moved apart where they would overlap."""
    kinds = sorted(curves, key=lambda kind: curves[kind][-1].error)
    top = axes.get_ylim()[1]
    heights = spread([curves[kind][-1].error / top for kind in kinds], TEXT_HEIGHT)
    for kind, height in zip(kinds, heights, strict=True):
        axes.annotate(
            "Overall" if kind == "overall" else kind,
            xy=(curves[kind][-1].sdcs, height),
            xycoords=("data", "axes fraction"),
            xytext=(9, 0),
            textcoords="offset points",
            va="center",
            fontweight="bold" if kind == "overall" else "normal",
            color=STYLES[kind][0],
            annotation_clip=False,
        )


def spread(heights: Sequence[float], gap: float) -> list[float]:
    """Move ascending heights apart so that neighbours are at least a gap from each other.

    Heights that crowd share out the room evenly about their mean, the least squares
    solution (pool adjacent violators).
    """
    from scipy.optimize import isotonic_regression  # noqa: PLC0415 - heavy

    if not heights:
        return []
    # With i gaps taken off height i, "a gap apart" becomes "not decreasing".
    below = gap * np.arange(len(heights))
    result: list[float] = (isotonic_regression(np.array(heights) - below).x + below).tolist()
    return result
