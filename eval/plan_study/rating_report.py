"""A rating set as text and as JSON: its plan, and people's ratings against the judge."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Literal

from rich.table import Table

from corpus_tools.corpus.estimate import Estimate, explained
from eval.plan_study.plan_validity import PlanAgreement
from eval.plan_study.rating_power import ANSWER_S, ASSUMED, Planned
from eval.plan_study.rating_sample import KINDS, RIGHT, WRONG, DistinctPlan
from eval.plan_study.rating_set import Rated
from eval.plan_study.study_pairs import INSTANCE
from eval.tables.formats import document, figure, figure_table, interval, table_text

SHOWN = ("kappa", "precision", "recall", "precision_of_wrong", "people_right")
HEADINGS = {
    "kappa": "Kappa",
    "precision": "Precision",
    "recall": "Recall",
    "precision_of_wrong": "Precision of wrong",
    "people_right": "Right to people",
}
NOTES = (
    "precision: of the plans that the judge calls right, the part that most people call right; "
    "recall: of those that people call right, the part that the judge does",
    "the figures are of all plans: each rated plan is weighted by one over the chance that it had "
    "to be drawn; the counts beside are of rated plans",
    "95%: percentile intervals with whole scenarios resampled; all: a plan of several "
    "configurations counts once",
)


def lines_planned(planned: Planned) -> list[str]:
    """Describe a planned rating set, for people to read before anything is rendered."""
    there, drawn = (
        ", ".join(f"{counts[kind]} {kind}" for kind in KINDS)
        for counts in (planned.plans, planned.pairs)
    )
    by_configuration = "; ".join(
        f"{name}: " + ", ".join(f"{counts[kind]} {kind}" for kind in KINDS)
        for name, counts in planned.configurations.items()
    )
    widths = ", ".join(f"{HEADINGS[name].lower()} {_half(planned, name)}" for name in SHOWN)
    return [
        f"plans by the automatic judge: {there}; {planned.without} commands without a plan",
        f"pairs to rate: {planned.total} ({drawn}), of {planned.scenarios} scenarios, "
        f"by {planned.raters} people each; {by_configuration}",
        f"drawn but not rated: {planned.stopped} plans that physics stopped, for their "
        "videos don't show what the judge has judged",
        f"expected half widths of 95% intervals: {widths}",
        f"if most people call {ASSUMED[RIGHT]:.0%} of the right plans right and "
        f"{ASSUMED[WRONG]:.0%} of the wrong ones",
        f"a person takes {planned.minutes:.0f} minutes for all pairs: {planned.seconds_each:.0f} s "
        f"for each, of which {ANSWER_S:.0f} s are for reading and answering",
    ]


def render(rated: Rated, form: Literal["text", "json"], *, terminal: bool = False) -> str:
    """Render the plan and the judge's validity; ``no ratings yet`` where there is none."""
    settings, planned = rated.of.settings, rated.of.planned
    about = {
        "train": settings.train,
        "test": settings.test,
        "plans": ",".join(settings.plans),
        "seed": rated.of.sample.seed,
    }
    if form == "json":
        drawn = rated.of.sample.chance
        content = {
            "study": str(rated.file),
            "pairs": planned.total,
            "planned": asdict(planned),
            "judgments": rated.judgments,
            "validity": {name: _records(rows) for name, rows in rated.agreements.items()} or None,
            "rated": [_drawn(plan, rated) for plan in rated.of.plans if plan.run in drawn],
        }
        return document(content, about)
    tables: dict[str, Table] = {}
    for name, rows in rated.agreements.items():
        tables[f"The automatic judge ({name}) against most people"] = _figures(rows)
        tables[f"Rated plans by what most people and the judge ({name}) say"] = _counts(rows)
    return table_text(tables, _notes(rated), about, terminal=terminal)


def _notes(rated: Rated) -> list[str]:
    planned = rated.of.planned
    serve = f"ct annotate {rated.file} --instance {rated.file.parent / INSTANCE}"
    found = lines_planned(planned)
    if not rated.agreements:
        return [*found, f"no ratings yet; let people rate with: {serve}"]
    found.append(
        f"{len(rated.people)} of {planned.total} pairs have ratings, {rated.judgments} of "
        f"{planned.total * planned.raters} in all; more with: {serve}"
    )
    if len(rated.people) < planned.total:
        found.append("the pairs without ratings are taken to be like those that have them")
    estimates = [
        one for rows in rated.agreements.values() for row in rows for one in row.figures.values()
    ]
    return [*found, *NOTES, *explained(estimates)]


def _figures(rows: Sequence[PlanAgreement]) -> Table:
    headings = (heading for name in SHOWN for heading in (HEADINGS[name], "95%"))
    table = figure_table(("Plans", *headings, "n", "Rated"))
    for row in rows:
        cells = [cell for name in SHOWN for cell in _shown(row.figures[name])]
        table.add_row(row.configuration, *cells, str(row.plans), str(row.rated))
    return table


def _counts(rows: Sequence[PlanAgreement]) -> Table:
    return figure_table(
        ("Plans", "both right", "people right", "judge right", "both wrong"),
        ((row.configuration, *map(str, row.counts.values())) for row in rows),
    )


def _shown(estimate: Estimate) -> tuple[str, str]:
    return figure(estimate.value), interval(estimate)


def _half(planned: Planned, name: str) -> str:
    reason = planned.unknown.get(name)
    return f"unknown ({reason})" if reason else f"{planned.half_widths[name]:.2f}"


def _records(rows: Sequence[PlanAgreement]) -> list[dict[str, object]]:
    return [
        {
            "configuration": row.configuration,
            "plans": row.plans,
            "rated": row.rated,
            "counts": row.counts,
            **{name: estimate._asdict() for name, estimate in row.figures.items()},
        }
        for row in rows
    ]


def _drawn(plan: DistinctPlan, rated: Rated) -> dict[str, object]:
    chance = rated.of.sample.chance[plan.run]
    said: Mapping[str, bool] = plan.record.verdicts
    return {
        "run": plan.run,
        "command": plan.record.command,
        "text": plan.record.text,
        "scenario": plan.record.scenario,
        "configurations": plan.configurations,
        "judge": said,
        "reason": plan.record.reason,
        "chance": chance,
        "weight": 1 / chance,
        "people": rated.people.get(plan.run),
    }
