"""Comparisons of configurations as text and as records."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence

import numpy as np
from rich.table import Table

from corpus_tools.runtime.text_tables import figure_table
from eval.statistics.comparison import Comparison, compare_all
from eval.statistics.estimates import FloatArray, IntArray
from eval.statistics.ratings import codes
from eval.tables.formats import interval, table_text
from g3.storage.text_lines import split_lines

TITLE = "configurations compared on the commands that both have"
NOTE = (
    "compared on commands that both have: p is of no difference, by McNemar's test for pairs in "
    "clusters, which are scenarios, exact where fewer than 10 of these differ, with Holm's "
    "correction; h is Cohen's effect size"
)
COLUMNS = (
    "one", "other", "n", "difference", "low", "high", "reason", "p", "adjusted_p", "effect",
)  # fmt: skip


def compare_commands(
    shares: Mapping[str, Mapping[str, float]],
    scenarios: Mapping[str, str],
    *,
    seed: int,
    draws: int,
    including: Collection[str] = (),
) -> list[Comparison]:
    """Compare each two configurations, with whole scenarios as clusters.

    `shares` are by configuration and command; the rest is as
    :func:`~eval.statistics.comparison.compare_all` takes it.
    """
    commands = sorted({command for of_commands in shares.values() for command in of_commands})
    clusters: IntArray = codes([scenarios[command] for command in commands])
    arrays: dict[str, FloatArray] = {
        name: np.array([of_commands.get(command, np.nan) for command in commands])
        for name, of_commands in shares.items()
    }
    rng = np.random.default_rng(seed)
    return compare_all(arrays, clusters, rng=rng, draws=draws, including=including)


def records(comparisons: Iterable[Comparison]) -> list[dict[str, str | int | float]]:
    """Convert comparisons to records by name, for JSON and CSV."""
    values = (
        (c.one, c.other, c.n, *c.difference[:4], c.p, c.adjusted_p, c.effect) for c in comparisons
    )
    return [dict(zip(COLUMNS, row, strict=True)) for row in values]


def comparison_table(comparisons: Sequence[Comparison]) -> Table:
    """Return the comparisons as a table to read."""
    rows = (
        (
            f"{c.one} - {c.other}",
            f"{c.difference.value:+.2f}",
            interval(c.difference, "{:+.2f} to {:+.2f}"),
            shown_p(c.adjusted_p),
            f"{c.effect:+.2f}",
            str(c.n),
        )
        for c in comparisons
    )
    headings = ("Configurations", "Difference", "95%", "p, corrected", "h", "n")
    return figure_table(headings, rows)


def lines(comparisons: Sequence[Comparison], title: str = TITLE) -> list[str]:
    """Return the comparisons as lines of text."""
    tables = {f"{title[0].upper()}{title[1:]}": comparison_table(comparisons)}
    return split_lines(table_text(tables, (), {}, terminal=False))


def shown_p(p: float) -> str:
    """Format a p value for people to read."""
    return "< 0.001" if p < 0.001 else f"{p:.3f}"
