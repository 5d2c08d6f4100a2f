"""``ct eval --power``: how many pairs and judgments a wanted interval needs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil

import numpy as np
from rich.table import Table

from eval.statistics.intervals import intraclass_correlation
from eval.statistics.power import (
    POWER,
    Plan,
    judgments_for_difference,
    plan_interval,
    simulated_half_width,
)
from eval.statistics.ratings import of_study, ratings_of
from eval.tables.formats import Format, comments, delimited, document, table_text
from eval.tables.latex import tabular
from g3.annotation import Judgment
from g3.short_repr import short_repr

JUDGES = (1, 3, 5, 10)
SHARE, CORRELATION = 0.88, 0.44
"""Of the AAAI-11 corpus's judgments of commands with their own videos."""
DIFFERENCE = 0.1
COLUMNS = (
    "judges", "pairs", "judgments", "half_width", "simulated_half_width", "design_effect",
    "pairs_for_difference",
)  # fmt: skip


@short_repr
@dataclass(frozen=True, slots=True)
class Row:
    """A plan, and how it does in simulated studies.

    Parameters
    ----------
    simulated_half_width
        What the interval has in simulated studies.
    pairs_for_difference
        How many pairs of each of two configurations find shares that differ by
        :data:`DIFFERENCE` with a probability of :data:`~eval.statistics.power.POWER`.
    """

    plan: Plan
    simulated_half_width: float
    pairs_for_difference: int


def assumptions(judgments: Sequence[Judgment]) -> tuple[float, float]:
    """Share and correlation within pairs of judgments of commands with their own videos."""
    ratings = ratings_of(of_study(judgments))
    mine = ratings.only(ratings.original)
    correlation = intraclass_correlation(mine.agrees, mine.pair) if len(mine) else np.nan
    # Nothing follows from one pair, or from ratings that are all the same.
    if np.isnan(correlation):
        return SHARE, CORRELATION
    return float(mine.agrees.mean()), max(0.0, correlation)


def plans(half_width: float, share: float, correlation: float, seed: int) -> list[Row]:
    """A row for each number of judges."""
    rng = np.random.default_rng(seed)
    rows = []
    lower = share - DIFFERENCE if share > DIFFERENCE else share + DIFFERENCE
    for judges in JUDGES:
        plan = plan_interval(half_width, share=share, judges=judges, correlation=correlation)
        simulated = simulated_half_width(plan, share=share, correlation=correlation, rng=rng)
        needed = judgments_for_difference(share, lower) * plan.design_effect / judges
        rows.append(Row(plan, simulated, ceil(needed)))
    return rows


def render(
    rows: Sequence[Row], form: Format, metadata: Mapping[str, object], *, terminal: bool = False
) -> str:
    """The plans in one of the formats."""
    records = [_record(row) for row in rows]
    if form == "json":
        return document({"rows": records}, metadata)
    if form == "csv":
        return delimited(records, metadata, columns=COLUMNS)
    headings = (
        "Judges of a pair", "Pairs", "Judgments", "Half width", "Simulated", "Design effect",
        f"Pairs to find {DIFFERENCE:.1f}",
    )  # fmt: skip
    cells = [
        (
            *(str(record[name]) for name in COLUMNS[:3]),
            *(f"{record[name]:.3f}" for name in COLUMNS[3:5]),
            f"{record[COLUMNS[5]]:.2f}",
            str(record[COLUMNS[6]]),
        )
        for record in records
    ]
    if form == "latex":
        return tabular(headings, cells, comments=comments(metadata))
    table = Table()
    for heading in headings:
        table.add_column(heading, justify="right")
    for row in cells:
        table.add_row(*row)
    notes = (
        "half width: of a 95% interval of the share, for the videos at hand",
        f"the last column: pairs of each of two configurations, with a power of {POWER:.0%}",
        "design effect: how much more a share varies because judgments of a pair are alike",
    )
    return table_text({"How large a study must be": table}, notes, metadata, terminal=terminal)


def _record(row: Row) -> dict[str, float]:
    return {
        "judges": row.plan.judges,
        "pairs": row.plan.pairs,
        "judgments": row.plan.judgments,
        "half_width": row.plan.half_width,
        "simulated_half_width": row.simulated_half_width,
        "design_effect": row.plan.design_effect,
        "pairs_for_difference": row.pairs_for_difference,
    }
