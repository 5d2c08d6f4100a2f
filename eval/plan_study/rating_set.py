"""A rating set: plans drawn for people to rate, so that the automatic judge can be checked."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Literal

import msgspec
import numpy as np
from rich.table import Table

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.estimate import Estimate, explained
from corpus_tools.runtime.parallel import Executor, Workers, work_in_order
from corpus_tools.runtime.progress import OnProgress, no_progress
from corpus_tools.runtime.text_tables import figure_table
from eval.plan_study.rating_sample import (
    ANSWER_S,
    ASSUMED,
    KINDS,
    RIGHT,
    WRONG,
    DistinctPlan,
    PlanAgreement,
    Planned,
    Sample,
    agreements,
    distinct_plans,
    planned,
    sampled,
    tells_of_all,
)
from eval.plan_study.study_plans import (
    INSTANCE,
    LOG,
    RUNS,
    Pair,
    PlanRecord,
    Settings,
    carry_out,
    check_settings,
    chosen_commands,
    film_all,
    plan_all,
    run_corpus,
    write_study,
)
from eval.plan_study.whole_study import check_ratings, ratings_so_far
from eval.statistics.ratings import agrees, codes, majorities
from eval.tables.formats import document, figure, interval, table_text
from g3.annotation import Judgment
from g3.groundings import Context
from g3.storage.atomic_file import write_bytes

PLANNED = "planned.json"


class RunOutcome(msgspec.Struct, frozen=True):
    """The outcome of a run, kept beside its corpus when that is whole."""

    seconds: float
    failure: str
    """Reason for which physics stopped the run; empty if it didn't."""


@dataclass(frozen=True, slots=True)
class RatingSet:
    """A rating set before its videos are made."""

    folder: Path
    settings: Settings
    plans: Sequence[DistinctPlan]
    """All plans, each once."""
    sample: Sample
    """Those that people rate. Plans that physics stopped aren't among them, for their videos don't
    show what the judge has judged."""
    pairs: Sequence[Pair]
    planned: Planned


@dataclass(frozen=True, slots=True)
class Rated:
    """A rating set as far as people have come."""

    of: RatingSet
    file: Path
    """The study's file for ``ct annotate``."""
    judgments: int
    """Number of judgments."""
    people: Mapping[str, bool]
    """Majority verdict of people on each rated plan, by its run."""
    agreements: Mapping[str, Sequence[PlanAgreement]]
    """By verdict of the judge; empty without ratings."""


def prepare(
    folder: Path, settings: Settings, *, on_progress: OnProgress = no_progress
) -> RatingSet:
    """Make and draw plans, carry out the drawn ones, and return the rating set with its plan.

    Existing results aren't made again.
    """
    check_settings(folder, settings)
    records = plan_all(folder, settings, on_progress)
    plans = distinct_plans(records)
    drawn = sampled(folder, plans, settings)
    contexts = {a.command.id: a.context for a in chosen_commands(settings)}
    runs = _carried_out(folder, [p for p in plans if p.run in drawn.chance], contexts, on_progress)
    whole = {run: chance for run, chance in drawn.chance.items() if not runs[run].failure}
    sample = msgspec.structs.replace(drawn, chance=whole)
    pairs = [
        Pair(
            p.record.text,
            p.run,
            contexts[p.record.command].id,
            "+".join(p.configurations),
            p.record.command,
        )
        for p in plans
        if p.run in whole
    ]
    plan = planned(
        plans,
        sample,
        [runs[run].seconds for run in whole],
        without=sum(r.script is None for r in records),
        stopped=len(runs) - len(whole),
        seed=settings.seed,
    )
    write_bytes(folder / PLANNED, msgspec.json.format(msgspec.json.encode(plan)) + b"\n")
    return RatingSet(folder, settings, plans, sample, pairs, plan)


def finish(
    rating_set: RatingSet,
    *,
    ratings: Path | None = None,
    pay: float | None = None,
    draws: int = 2000,
    on_progress: OnProgress = no_progress,
) -> Rated:
    """Make the videos that aren't there yet and the study's file, and read the ratings so far.

    All is taken and refused as by :func:`eval.plan_study.whole_study.go_on`.
    """
    folder, seed = rating_set.folder, rating_set.settings.seed
    film_all(folder, rating_set.settings.test, [*rating_set.pairs], on_progress)
    file = write_study(folder, [*rating_set.pairs], seed, pay)
    judgments = ratings_so_far(folder, ratings)
    people = most_people(rating_set.pairs, judgments)
    rows: dict[str, Sequence[PlanAgreement]] = {}
    if people:
        rows = {
            verdict: agreements(
                [p for p in rating_set.plans if verdict in p.record.verdicts],
                rating_set.sample,
                people,
                verdict,
                seed=seed,
                draws=draws,
            )
            for verdict in verdicts(rating_set.plans, rating_set.sample)
        }
    return Rated(rating_set, file, len(judgments), people, rows)


def verdicts(plans: Sequence[DistinctPlan], sample: Sample) -> list[str]:
    """Return the judge's verdicts that the sample can check."""
    others = [name for p in plans for name in p.record.verdicts if tells_of_all(plans, sample)]
    return list(dict.fromkeys([LOG, *others]))


def most_people(pairs: Sequence[Pair], judgments: Sequence[Judgment]) -> dict[str, bool]:
    """Return most people's verdict by run of each rated pair; see :func:`check_ratings`."""
    check_ratings(pairs, judgments)
    if not judgments:
        return {}
    agreeing = np.array([agrees(j) for j in judgments])
    runs = [j.shown_video for j in judgments]
    return dict(zip(dict.fromkeys(runs), map(bool, majorities(agreeing, codes(runs))), strict=True))


def _carried_out(
    folder: Path,
    plans: Sequence[DistinctPlan],
    contexts: Mapping[str, Context],
    on_progress: OnProgress,
) -> dict[str, RunOutcome]:
    """Carry out the plans that haven't been yet, in as many processes as there are processors."""
    errands = [
        (folder, p.run, p.record, contexts[p.record.command])
        for p in plans
        if not _outcome_file(folder, p.run).exists()
    ]
    before = len(plans) - len(errands)

    def told(done: int) -> None:
        on_progress("runs in physics", before + done, len(plans))

    if errands:
        with Executor(Workers(min(os.cpu_count() or 1, len(errands)))) as executor:
            work_in_order(_carry_out, errands, executor, on_done=told)
    return {
        p.run: msgspec.json.decode(_outcome_file(folder, p.run).read_bytes(), type=RunOutcome)
        for p in plans
    }


def _carry_out(errand: tuple[Path, str, PlanRecord, Context]) -> None:
    folder, run, _, _ = errand
    failure = carry_out(*errand)
    (context,) = Corpus.load(run_corpus(folder, run)).contexts.values()
    t = context.agent.trajectory.t
    outcome = RunOutcome(float(t[-1] - t[0]), failure)
    write_bytes(_outcome_file(folder, run), msgspec.json.encode(outcome))


def _outcome_file(folder: Path, run: str) -> Path:
    return folder / RUNS / f"{run}.json"


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
    result = lines_planned(planned)
    if not rated.agreements:
        return [*result, f"no ratings yet; let people rate with: {serve}"]
    result.append(
        f"{len(rated.people)} of {planned.total} pairs have ratings, {rated.judgments} of "
        f"{planned.total * planned.raters} in all; more with: {serve}"
    )
    if len(rated.people) < planned.total:
        result.append("the pairs without ratings are taken to be like those that have them")
    estimates = [
        one for rows in rated.agreements.values() for row in rows for one in row.figures.values()
    ]
    return [*result, *NOTES, *explained(estimates)]


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
    plan_verdicts: Mapping[str, bool] = plan.record.verdicts
    return {
        "run": plan.run,
        "command": plan.record.command,
        "text": plan.record.text,
        "scenario": plan.record.scenario,
        "configurations": plan.configurations,
        "judge": plan_verdicts,
        "reason": plan.record.reason,
        "chance": chance,
        "weight": 1 / chance,
        "people": rated.people.get(plan.run),
    }
