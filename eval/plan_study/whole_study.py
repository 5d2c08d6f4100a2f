"""A study from end to end: plans, runs, videos, the study's file, and results so far."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Literal

from rich.table import Table

from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.corpus_reading import load_corpus
from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.runtime.progress import OnProgress, no_progress
from eval.judging.judge_report import in_a_line, summary
from eval.judging.judge_validity import Validity, known_validity
from eval.plan_study.study_pairs import ANSWERS, INSTANCE, Pair, film_all, pairs, write_study
from eval.plan_study.study_plans import CONFIGURATIONS, PlanRecord, chosen_commands, plan_all
from eval.plan_study.study_results import (
    RatedRow,
    by_judge,
    by_people,
    compare_judge,
    compare_people,
)
from eval.plan_study.study_settings import Settings, check_settings
from eval.statistics.comparison import Comparison
from eval.statistics.estimates import beside
from eval.table_3.baselines import BASELINES, missing
from eval.table_3.following import judged, plan_by_grounder, task_of
from eval.table_3.grounder_registry import grounder_named
from eval.table_3.judged_commands import judged_commands
from eval.table_3.outcomes import JudgedRow, estimates_of
from eval.table_3.plan_report import PAPER
from eval.tables.comparison_report import NOTE, TITLE, comparison_table
from eval.tables.comparison_report import records as comparison_records
from eval.tables.formats import document, figure, figure_table, interval, table_text
from g3.annotation import Judgment


@dataclass(frozen=True, slots=True)
class Study:
    """A study as far as it has come."""

    settings: Settings
    file: Path
    """The study's file for ``ct annotate``."""
    pairs: Sequence[Pair]
    records: Sequence[PlanRecord]
    people: Sequence[RatedRow]
    """Rows of Table 3 by people; empty without ratings."""
    automatic: Sequence[JudgedRow]
    """Rows of Table 3 by the automatic judge."""
    validity: Validity | None
    compared_by_people: Sequence[Comparison] = ()
    compared: Sequence[Comparison] = ()
    """Each two configurations on the commands that both have, by people and by the judge."""


def go_on(
    folder: Path,
    settings: Settings,
    *,
    ratings: Path | None = None,
    pay: float | None = None,
    draws: int = 2000,
    on_progress: OnProgress = no_progress,
) -> Study:
    """Do what hasn't been done yet, and read the ratings that there are.

    Ratings are in a corpus, or else in the app's database in the folder. The pay is in dollars for
    a pair; None if the study's file says it. A CorpusError says that the folder or the ratings are
    of another study.
    """
    check_settings(folder, settings)
    corpora: dict[str, Corpus] = {
        name: open_corpus(name) for name in (settings.test, *settings.train.split(","))
    }
    records = plan_all(folder, settings, _half(on_progress, 0))
    found = pairs(records, chosen_commands(settings), settings.seed)
    film_all(folder, settings.test, found, _half(on_progress, 1))
    file = write_study(folder, found, settings.seed, pay)
    judgments = ratings_so_far(folder, ratings)
    both = [*records, *baseline_records(settings)]
    options = {"seed": settings.seed, "draws": draws}
    return Study(
        settings,
        file,
        found,
        records,
        by_people(found, records, judgments, **options) if judgments else (),
        by_judge(both, **options),
        known_validity(corpora.values(), **options),
        compare_people(found, records, judgments, **options) if judgments else (),
        compare_judge(both, **options),
    )


def baseline_records(settings: Settings) -> list[PlanRecord]:
    """Return the automatic judge's verdicts on baselines' plans for a study's commands."""
    chosen = {annotation.command.id for annotation in chosen_commands(settings)}
    commands = [c for c in judged_commands(open_corpus(settings.test)) if c.command.id in chosen]
    names = [name for name in BASELINES if name not in missing()]
    outcomes = [
        (name, judged(command, plan_by_grounder(grounder_named(name), task_of(command))))
        for name in names
        for command in commands
    ]
    return [
        PlanRecord(name, o.command, o.scenario, o.text, o.probability, o.correct, o.reason)
        for name, o in outcomes
    ]


def ratings_so_far(folder: Path, ratings: Path | None) -> Sequence[Judgment]:
    """Return people's ratings, from a corpus, or without one from the app's database."""
    if ratings is not None:
        return load_corpus(ratings).judgments
    if find_spec("sqlalchemy") is None:
        return ()
    from eval.plan_study.study_rating import received  # noqa: PLC0415 - an extra

    return received(folder)


def _half(on_progress: OnProgress, which: int) -> OnProgress:
    """Return a progress callback that fills one half of a bar for plans and videos."""
    return lambda step, done, total: on_progress(step, which * total + done, 2 * total)


def render(study: Study, form: Literal["text", "json"], *, terminal: bool = False) -> str:
    """Render people's rows and the judge's, in tables of their own."""
    about = {"table": 3, "train": study.settings.train, "test": study.settings.test}
    about |= {"seed": study.settings.seed}
    if form == "json":
        validity = None if study.validity is None else summary(study.validity)
        people = [_flat(row) for row in study.people] or None
        content = {
            "study": str(study.file),
            "pairs": len(study.pairs),
            "people": people,
            "people_compared": comparison_records(study.compared_by_people),
            "automatic": {
                "rows": study.automatic,
                "comparisons": comparison_records(study.compared),
                "judge_validity": validity,
            },
            "commands": {name: _told(study.records, name) for name in CONFIGURATIONS},
            "failures": [{"run": r.run, "failure": r.failure} for r in study.records if r.failure],
        }
        return document(content, about)
    tables = {"People's judgments": _people(study.people)} if study.people else {}
    if study.compared_by_people:
        tables[f"People's judgments: {TITLE}"] = comparison_table(study.compared_by_people)
    tables["The automatic judge (a program, not people)"] = _automatic(study.automatic)
    if study.compared:
        tables[f"The automatic judge: {TITLE}"] = comparison_table(study.compared)
    return table_text(tables, _notes(study), about, terminal=terminal)


def _told(records: Sequence[PlanRecord], configuration: str) -> list[dict[str, object]]:
    return [
        {
            "command": r.command,
            "text": r.text,
            "probability": r.probability,
            "correct": int(r.correct),
            "by_words": None if r.by_words is None else int(r.by_words),
            "reason": r.reason,
            "run": r.run,
        }
        for r in records
        if r.configuration == configuration
    ]


def _notes(study: Study) -> list[str]:
    failed = sum(bool(r.failure) for r in study.records)
    lacking = [f"{name} {why}" for name, why in missing().items()]
    found = [
        NOTE,
        in_a_line(study.validity),
        *lacking,
        f"{failed} of {len(study.records)} plans were stopped in physics; their videos end there",
        f"{len(study.pairs)} pairs of commands and videos to rate by {ANSWERS} people each: "
        f"ct annotate {study.file} --instance {study.file.parent / INSTANCE}",
    ]
    if study.people:
        found.append(
            "95%: percentile intervals with whole scenarios resampled; scenarios, raters: for "
            "others of both"
        )
    else:
        found.append(
            "nobody has rated yet; ratings are read from the app's database in the study's folder, "
            "or from --ratings, which `ct annotate export` writes"
        )
    return found


def _people(rows: Sequence[RatedRow]) -> Table:
    headings = ("Agree", "95%", "Scenarios, raters", "Majority", "Paper", "n", "Rated pairs")
    table = figure_table(("Configuration", *headings))
    for row in rows:
        paper = beside(PAPER.get(row.configuration), row.rated)
        table.add_row(
            row.configuration if row.configuration in PAPER else f"known {row.configuration}",
            f"{row.share.value:.2f}",
            interval(row.share),
            interval(row.two_way),
            f"{row.majority:.2f}",
            "" if paper is None else f"{paper:.2f}",
            str(row.judgments),
            f"{row.rated} of {row.n}",
        )
    return table


def _automatic(rows: Sequence[JudgedRow]) -> Table:
    headings = ("Ends where the log ends", "95%", "Does what the words say", "95%", "n")
    table = figure_table(("Configuration", *headings))
    for row in rows:
        cells = (cell for one in estimates_of(row) for cell in (figure(one.value), interval(one)))
        table.add_row(row["configuration"], *cells, str(row["n"]))
    return table


def _flat(row: RatedRow) -> dict[str, object]:
    return {
        "configuration": row.configuration,
        "judge": "people",
        "precision": row.share.value,
        "low": row.share.low,
        "high": row.share.high,
        "reason": row.share.reason,
        "two_way": {name: getattr(row.two_way, name) for name in ("low", "high", "reason")},
        "majority": row.majority,
        "n": row.judgments,
        "rated": row.rated,
        "pairs": row.n,
        "paper": beside(PAPER.get(row.configuration), row.rated),
    }
