"""``ct eval power``: numbers of pairs and judgments for an interval of a given width."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from math import ceil

import numpy as np

from corpus_tools.corpus.estimate import Estimate, explained, undefined
from corpus_tools.runtime.text_tables import figure_table
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

JUDGES = (1, 3, 5, 10)
SHARE, CORRELATION = 0.88, 0.44
"""Share and correlation in the AAAI-11 corpus, for commands with their own videos."""
DIFFERENCE = 0.1
COLUMNS = (
    "judges", "pairs", "judgments", "half_width", "simulated_half_width", "design_effect",
    "pairs_for_difference", "reason",
)  # fmt: skip

FORMS = {
    "pairs": "{}",
    "judgments": "{}",
    "half_width": "{:.3f}",
    "simulated_half_width": "{:.3f}",
    "design_effect": "{:.2f}",
    "pairs_for_difference": "{}",
}
"""Formats of the figures of a plan in a table."""


def assumptions(judgments: Sequence[Judgment] | None) -> tuple[Estimate, Estimate]:
    """Return share and correlation of judgments of commands with their own videos.

    Without a corpus's judgments they are those of the AAAI-11 corpus; of judgments that don't show
    them there is a reason.
    """
    if judgments is None:
        return Estimate(SHARE), Estimate(CORRELATION)
    ratings = ratings_of(of_study(judgments))
    mine = ratings.only(ratings.original)
    if not len(mine):
        return undefined("no data"), undefined("no data")
    correlation = intraclass_correlation(mine.agrees, mine.pair)
    return Estimate(float(mine.agrees.mean())), correlation


def plans(
    half_width: float, share: Estimate, correlation: Estimate, seed: int
) -> list[dict[str, float | str]]:
    """Return a record for each number of judges, by :data:`COLUMNS`.

    Beside the plan it has the half width in simulated studies, and the number of pairs of each of
    two configurations that find shares that differ by :data:`DIFFERENCE` with a probability of
    :data:`~eval.statistics.power.POWER`. Where nothing can be planned it has the reason instead.
    """
    rng = np.random.default_rng(seed)
    rows: list[dict[str, float | str]] = []
    one = share.value
    other = one - DIFFERENCE if one > DIFFERENCE else one + DIFFERENCE
    for judges in JUDGES:
        plan = plan_interval(half_width, share=one, judges=judges, correlation=correlation.value)
        if not isinstance(plan, Plan):
            reason = share.reason or (plan if plan == "all alike" else correlation.reason) or plan
            rows.append({**dict.fromkeys(COLUMNS, np.nan), "judges": judges, "reason": reason})
            continue
        within = correlation.value if judges > 1 else 0.0
        simulated = simulated_half_width(plan, share=one, correlation=within, rng=rng)
        needed = judgments_for_difference(one, other) * plan.design_effect / judges
        about = {"simulated_half_width": simulated.value, "pairs_for_difference": ceil(needed)}
        rows.append(asdict(plan) | about | {"reason": simulated.reason})
    return rows


def render(
    records: Sequence[Mapping[str, float | str]],
    form: Format,
    metadata: Mapping[str, object],
    *,
    terminal: bool = False,
) -> str:
    """Render the plans in one of the formats."""
    if form == "json":
        rows = [{name: record[name] for name in COLUMNS} for record in records]
        return document({"rows": rows}, metadata)
    if form == "csv":
        return delimited(records, metadata, columns=COLUMNS)
    headings = (
        "Judges of a pair", "Pairs", "Judgments", "Half width", "Simulated", "Design effect",
        f"Pairs to find {DIFFERENCE:.1f}",
    )  # fmt: skip
    cells = [_cells(record) for record in records]
    reasons = explained(record["reason"] for record in records)
    if form == "latex":
        return tabular(headings, cells, comments=[*comments(metadata), *reasons])
    table = figure_table(headings, cells, words=0)
    notes = (
        "half width: of a 95% interval of the share, for the videos at hand",
        f"the last column: pairs of each of two configurations, with a power of {POWER:.0%}",
        "design effect: how much more a share varies because judgments of a pair are alike",
        *reasons,
    )
    return table_text({"How large a study must be": table}, notes, metadata, terminal=terminal)


def _cells(record: Mapping[str, float | str]) -> list[str]:
    judges = str(record["judges"])
    if record["reason"]:
        return [judges, str(record["reason"]), *["-"] * (len(FORMS) - 1)]
    return [judges, *(form.format(record[name]) for name, form in FORMS.items())]
