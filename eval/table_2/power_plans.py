"""``ct eval --power``: how many pairs and judgments a wanted interval needs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from math import ceil

import numpy as np

from eval.statistics.intervals import intraclass_correlation
from eval.statistics.power import (
    POWER,
    judgments_for_difference,
    plan_interval,
    simulated_half_width,
)
from eval.statistics.ratings import of_study, ratings_of
from eval.tables.formats import Format, comments, delimited, document, figure_table, table_text
from eval.tables.latex import tabular
from g3.annotation import Judgment

JUDGES = (1, 3, 5, 10)
SHARE, CORRELATION = 0.88, 0.44
"""Of the AAAI-11 corpus's judgments of commands with their own videos."""
DIFFERENCE = 0.1
COLUMNS = (
    "judges", "pairs", "judgments", "half_width", "simulated_half_width", "design_effect",
    "pairs_for_difference",
)  # fmt: skip


def assumptions(judgments: Sequence[Judgment]) -> tuple[float, float]:
    """Share and correlation within pairs of judgments of commands with their own videos."""
    ratings = ratings_of(of_study(judgments))
    mine = ratings.only(ratings.original)
    correlation = intraclass_correlation(mine.agrees, mine.pair) if len(mine) else np.nan
    # Nothing follows from one pair, or from ratings that are all the same.
    if np.isnan(correlation):
        return SHARE, CORRELATION
    return float(mine.agrees.mean()), max(0.0, correlation)


def plans(half_width: float, share: float, correlation: float, seed: int) -> list[dict[str, float]]:
    """A record for each number of judges, by :data:`COLUMNS`.

    Beside the plan it has the half width in simulated studies, and how many pairs of each of two
    configurations find shares that differ by :data:`DIFFERENCE` with a probability of
    :data:`~eval.statistics.power.POWER`.
    """
    rng = np.random.default_rng(seed)
    rows = []
    lower = share - DIFFERENCE if share > DIFFERENCE else share + DIFFERENCE
    for judges in JUDGES:
        plan = plan_interval(half_width, share=share, judges=judges, correlation=correlation)
        simulated = simulated_half_width(plan, share=share, correlation=correlation, rng=rng)
        needed = judgments_for_difference(share, lower) * plan.design_effect / judges
        about = {"simulated_half_width": simulated, "pairs_for_difference": ceil(needed)}
        rows.append(asdict(plan) | about)
    return rows


def render(
    records: Sequence[Mapping[str, float]],
    form: Format,
    metadata: Mapping[str, object],
    *,
    terminal: bool = False,
) -> str:
    """The plans in one of the formats."""
    if form == "json":
        rows = [{name: record[name] for name in COLUMNS} for record in records]
        return document({"rows": rows}, metadata)
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
    table = figure_table(headings, cells, words=0)
    notes = (
        "half width: of a 95% interval of the share, for the videos at hand",
        f"the last column: pairs of each of two configurations, with a power of {POWER:.0%}",
        "design effect: how much more a share varies because judgments of a pair are alike",
    )
    return table_text({"How large a study must be": table}, notes, metadata, terminal=terminal)
