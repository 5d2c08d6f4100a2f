"""Tables for papers in LaTeX."""

from __future__ import annotations

from collections.abc import Sequence

from corpus_tools.corpus.estimate import Estimate

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
    """Return a table in LaTeX, names first and then figures; comments are lines above it."""
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
    """Escape words, so that LaTeX sees no commands in them."""
    return words.translate(_ESCAPED)


def estimate(one: Estimate, form: str = "{:.2f}") -> str:
    """Format a figure with its interval in small print, or the reason for its absence."""
    shown = form.format(one.value) if one.is_known else "--"
    if one.has_interval:
        around = f"[{form.format(one.low)}, {form.format(one.high)}]"
    elif one.reason:
        around = f"({one.reason})"
    else:
        return shown
    return rf"{shown} {{\scriptsize {around}}}"


def _row(cells: Sequence[str]) -> str:
    return " & ".join(cells).rstrip() + r" \\" if cells else r"\midrule"
