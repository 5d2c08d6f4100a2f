"""Style of plots, on a page and in a paper, and their files."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PlotFormat = Literal["png", "svg", "pdf"]

INK, GREY, FAINT, GROUND = "#1f2430", "#5b6472", "#e3e6ea", "#ffffff"
BLUE, ORANGE, GREEN, PURPLE = "#0072b2", "#b84e00", "#00785a", "#a8487f"
"""Colours after Okabe and Ito (2008), distinct for colour-blind readers; dark enough for text."""
WIDE, NARROW = 7.0, 3.0
"""Widths: of two columns of a paper or a page, and of a telephone; inches."""


@dataclass(frozen=True, slots=True)
class Plot:
    """A plot that can be drawn in several widths, in inches."""

    title: str
    draw: Callable[[float], Figure]

    def saved(self, form: PlotFormat, width: float = WIDE, description: str = "") -> bytes:
        """Return the content of a file; equal plots give equal bytes with one matplotlib."""
        undated = {"svg": {"Date": None}, "pdf": {"CreationDate": None}, "png": {}}[form]
        about = {"Title": self.title, **({} if form == "pdf" else {"Description": description})}
        out = io.BytesIO()
        with _style(f"{self.title} {width}"):
            metadata: Any = about | undated
            self.draw(width).savefig(out, format=form, dpi=160, metadata=metadata)
        return out.getvalue()


@contextmanager
def _style(salt: str) -> Iterator[None]:
    import matplotlib as mpl  # noqa: PLC0415 - slow to import, and only plots need it

    style: dict[Any, Any] = {
        "svg.hashsalt": salt,
        # Text stays text: in SVG for the page's own type, in PDF as a font that may be embedded.
        "svg.fonttype": "none",
        "pdf.fonttype": 42,
        "text.parse_math": False,
        "font.size": 8,
        "axes.linewidth": 0.6,
        **dict.fromkeys(("text.color", "axes.labelcolor"), INK),
        **dict.fromkeys(("xtick.color", "ytick.color", "axes.edgecolor"), GREY),
    }
    with mpl.rc_context(style):
        yield
