"""A rating set: plans drawn for people to rate, so that the automatic judge can be checked."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np

from corpus_tools.corpus.corpus_reading import load_corpus
from corpus_tools.runtime.parallel import Executor, Workers, work_in_order
from corpus_tools.runtime.progress import OnProgress, no_progress
from eval.plan_study.plan_validity import PlanAgreement, agreements, tells_of_all
from eval.plan_study.rating_power import Planned, planned
from eval.plan_study.rating_sample import DistinctPlan, Sample, distinct_plans, sampled
from eval.plan_study.study_pairs import Pair, film_all, write_study
from eval.plan_study.study_plans import (
    FIRST,
    RUNS,
    PlanRecord,
    carry_out,
    chosen_commands,
    plan_all,
    run_corpus,
)
from eval.plan_study.study_results import check_ratings
from eval.plan_study.study_settings import Settings, check_settings
from eval.plan_study.whole_study import ratings_so_far
from eval.statistics.raters import majorities
from eval.statistics.ratings import agrees, codes
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
    own = {a.command.id: a.context for a in chosen_commands(settings)}
    runs = _carried_out(folder, [p for p in plans if p.run in drawn.chance], own, on_progress)
    whole = {run: chance for run, chance in drawn.chance.items() if not runs[run].failure}
    sample = msgspec.structs.replace(drawn, chance=whole)
    pairs = [
        Pair(
            p.record.text,
            p.run,
            own[p.record.command].id,
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
    found: RatingSet,
    *,
    ratings: Path | None = None,
    pay: float | None = None,
    draws: int = 2000,
    on_progress: OnProgress = no_progress,
) -> Rated:
    """Make the videos that aren't there yet and the study's file, and read the ratings so far.

    All is taken and refused as by :func:`eval.plan_study.whole_study.go_on`.
    """
    folder, seed = found.folder, found.settings.seed
    film_all(folder, found.settings.test, [*found.pairs], on_progress)
    file = write_study(folder, [*found.pairs], seed, pay)
    judgments = ratings_so_far(folder, ratings)
    people = most_people(found.pairs, judgments)
    rows: dict[str, Sequence[PlanAgreement]] = {}
    if people:
        rows = {
            verdict: agreements(found.plans, found.sample, people, verdict, seed=seed, draws=draws)
            for verdict in verdicts(found.plans, found.sample)
        }
    return Rated(found, file, len(judgments), people, rows)


def verdicts(plans: Sequence[DistinctPlan], sample: Sample) -> list[str]:
    """Return the judge's verdicts that the sample can check, of those that all plans have."""
    named = [name for name in plans[0].record.verdicts if name != FIRST] if plans else []
    others = [name for name in named if all(name in p.record.verdicts for p in plans)]
    return [FIRST, *(others if tells_of_all(plans, sample) else ())]


def most_people(pairs: Sequence[Pair], judgments: Sequence[Judgment]) -> dict[str, bool]:
    """Return most people's verdict by run of each rated pair; see :func:`check_ratings`."""
    check_ratings(pairs, judgments)
    if not judgments:
        return {}
    said = np.array([agrees(j) for j in judgments])
    runs = [j.shown_video for j in judgments]
    return dict(zip(dict.fromkeys(runs), map(bool, majorities(said, codes(runs))), strict=True))


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
    (context,) = load_corpus(run_corpus(folder, run)).contexts.values()
    t = context.agent.trajectory.t
    outcome = RunOutcome(float(t[-1] - t[0]), failure)
    write_bytes(_outcome_file(folder, run), msgspec.json.encode(outcome))


def _outcome_file(folder: Path, run: str) -> Path:
    return folder / RUNS / f"{run}.json"
