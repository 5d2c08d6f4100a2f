"""Tables for papers in LaTeX."""

from __future__ import annotations

from collections.abc import Sequence
from math import isnan

NEEDS = r"% Needs \usepackage{booktabs}."
RULE: tuple[str, ...] = ()
"""A row that is a line across the table."""

_ESCAPED = str.maketrans(
    {c: rf"\{c}" for c in "&%$#_{}"}
    | {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}"}
)


def tabular(
    headings: Sequence[str], rows: Sequence[Sequence[str]], *, comments: Sequence[str] = ()
) -> str:
    """A table of LaTeX's cells, names first and then figures; comments are lines above it."""
    return "\n".join(
        [
            NEEDS,
            *(f"% {line}" for line in comments),
            rf"\begin{{tabular}}{{l{'r' * (len(headings) - 1)}}}",
            r"\toprule",
            _row(headings),
            r"\midrule",
            *map(_row, rows),
            r"\bottomrule",
            r"\end{tabular}",
        ]
    )


def text(words: str) -> str:
    """Words in which LaTeX sees no commands."""
    return words.translate(_ESCAPED)


def estimate(value: float, low: float | None, high: float | None, form: str = "{:.2f}") -> str:
    """A figure with its interval in small print, which may be missing; so may the figure."""
    if isnan(value):
        return "--"
    shown = form.format(value)
    if low is None or high is None or isnan(low):
        return shown
    return rf"{shown} {{\scriptsize [{form.format(low)}, {form.format(high)}]}}"


def _row(cells: Sequence[str]) -> str:
    return " & ".join(cells).rstrip() + r" \\" if cells else r"\midrule"
