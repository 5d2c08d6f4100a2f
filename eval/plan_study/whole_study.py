"""A study from end to end: plans, runs, videos, what people rate, and results so far."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Literal

import numpy as np
from rich.table import Table

from annotation_app.core.config import DATABASE_FILE, Config, open_instance
from annotation_app.crowds.crowd_registry import find_provider, providers
from annotation_app.crowds.crowd_session import open_session
from annotation_app.crowds.publishing import publish_links, publish_posting
from annotation_app.export.corpus_export import find_only_study
from annotation_app.store.database import opened, reading, transaction
from annotation_app.store.schema import migrate
from annotation_app.study_setup.rendered_study import put_study, rendered_videos
from annotation_app.study_setup.study_reading import read_study
from annotation_app.tasks.rate import judgments as ratings
from corpus_tools.corpus.corpus_model import Corpus
from corpus_tools.corpus.estimate import Estimate
from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.runtime.progress import OnProgress, no_progress
from corpus_tools.runtime.text_tables import figure_table
from eval.judging.judge_report import in_a_line, summary
from eval.judging.judge_validity import Validity, known_validity
from eval.plan_study.study_plans import (
    ANSWERS,
    CONFIGURATIONS,
    INSTANCE,
    Pair,
    PlanRecord,
    Settings,
    check_settings,
    chosen_commands,
    film_all,
    pairs,
    plan_all,
    top,
    write_study,
)
from eval.statistics.comparison import Comparison
from eval.statistics.estimates import beside
from eval.statistics.intervals import bootstrap, two_way
from eval.statistics.ratings import agrees, codes, majorities, shown_pair
from eval.table_3 import plan_rows
from eval.table_3.baselines import BASELINES, missing
from eval.table_3.following import judged, plan_by_grounder, task_of
from eval.table_3.grounder_registry import grounder_named
from eval.table_3.judged_commands import judged_commands
from eval.table_3.outcomes import Outcome
from eval.table_3.plan_report import PAPER
from eval.table_3.plan_rows import Row, estimates_of
from eval.tables.comparison_report import NOTE, TITLE, compare_commands, comparison_table
from eval.tables.comparison_report import records as comparison_records
from eval.tables.formats import document, figure, interval, table_text
from g3.annotation import Judgment
from g3.errors import FormatError

ROWS = {
    "random": ("random", False),
    "gold-top30": ("gold", True),
    "auto-top30": ("auto", True),
    "gold-all": ("gold", False),
}
"""The rows of Table 3: each one's configuration, and whether only the most probable plans count."""
KNOWN = ("right", "wrong")


@dataclass(frozen=True, slots=True)
class RatedRow:
    """People's ratings of a configuration."""

    configuration: str
    share: Estimate
    """Judgments that agree, with whole scenarios resampled."""
    two_way: Estimate
    """Share for other scenarios and other raters."""
    majority: float
    """Share of the pairs on which more than half of the judgments agree."""
    judgments: int
    rated: int
    """Numbers of judgments, and of the pairs that they rate."""
    n: int
    """Number of pairs to rate."""


def by_people(
    pairs: Sequence[Pair],
    records: list[PlanRecord],
    judgments: Sequence[Judgment],
    *,
    seed: int,
    draws: int,
) -> list[RatedRow]:
    """Return the rows of people's ratings so far; unrated ones are left out."""
    check_ratings(pairs, judgments)
    scenarios = _scenarios(records)
    rows = []
    for name in (*ROWS, *KNOWN):
        which, only_top = ROWS.get(name, (name, False))
        best = {r.command for r in top(records, which)} if only_top else None
        configured = [
            p for p in pairs if p.configuration == which and (best is None or p.command in best)
        ]
        row = _rated(
            name, configured, scenarios, judgments, rng=np.random.default_rng(seed), draws=draws
        )
        if row is not None:
            rows.append(row)
    return rows


def check_ratings(pairs: Sequence[Pair], judgments: Sequence[Judgment]) -> None:
    """Refuse ratings of other studies, and second ones by the same person, naming the row."""
    keys = {p.key for p in pairs}
    seen: Counter[tuple[str, ...]] = Counter()
    for row, j in enumerate(judgments, start=1):
        key = shown_pair(j)
        where = f"judgments.jsonl: line {row}"
        if key not in keys:
            raise FormatError(
                f"the study has no pair of {j.command!r} and the video {j.shown_video!r}",
                where=where,
                fix="give the ratings of this study",
            )
        mine = (*key, j.subject)
        seen[mine] += 1
        if j.subject and seen[mine] > 1:
            raise FormatError(
                "the same person has rated this pair before", where=where, fix="remove one"
            )


def outcomes_of(records: Sequence[PlanRecord]) -> dict[str, list[Outcome]]:
    """Return the automatic judge's outcomes of kept plans, as Table 3 has them."""
    outcomes: dict[str, list[Outcome]] = {}
    for r in records:
        about = (r.command, r.scenario, r.text, r.probability, r.correct, r.reason)
        refused = r.script is None and not r.run
        outcome = Outcome(*about, by_words=r.by_words, refused=refused)
        outcomes.setdefault(r.configuration, []).append(outcome)
    return outcomes


def by_judge(outcomes: Mapping[str, Sequence[Outcome]], *, seed: int, draws: int) -> list[Row]:
    """Return the rows of Table 3 by the automatic judge, and those of baselines."""
    all_rows = plan_rows.rows(outcomes, {}, missing(), seed=seed, draws=draws)
    names = {*ROWS, *BASELINES}
    return [r for r in all_rows if r["subset"] == "all" and r["configuration"] in names]


def compare_people(
    pairs: Sequence[Pair],
    records: list[PlanRecord],
    judgments: Sequence[Judgment],
    *,
    seed: int,
    draws: int,
) -> list[Comparison]:
    """Compare configurations by people's ratings, on the commands rated in both."""
    of_pair = {p.key: p for p in pairs if p.is_plan}
    answers: dict[str, dict[str, list[bool]]] = {name: {} for name in CONFIGURATIONS}
    for j in judgments:
        pair = of_pair.get(shown_pair(j))
        if pair is not None:
            answers[pair.configuration].setdefault(pair.command, []).append(agrees(j))
    shares = {
        name: {command: float(np.mean(agreeing)) for command, agreeing in of_commands.items()}
        for name, of_commands in answers.items()
    }
    return compare_commands(shares, _scenarios(records), seed=seed, draws=draws)


def compare_judge(
    outcomes: Mapping[str, Sequence[Outcome]], *, seed: int, draws: int
) -> Sequence[Comparison]:
    """Compare each model with each other configuration by the automatic judge."""
    compared = plan_rows.comparisons(outcomes, {}, seed=seed, draws=draws)
    return next((c.comparisons for c in compared if c.verdict == "precision"), ())


def _scenarios(records: list[PlanRecord]) -> dict[str, str]:
    return {r.command: r.scenario for r in records}


def _rated(
    name: str,
    pairs: Sequence[Pair],
    scenarios: Mapping[str, str],
    judgments: Sequence[Judgment],
    *,
    rng: np.random.Generator,
    draws: int,
) -> RatedRow | None:
    by_key = {p.key: p for p in pairs}
    mine = [(by_key[key], j) for j in judgments if (key := shown_pair(j)) in by_key]
    if not mine:
        return None
    agreeing = np.array([agrees(j) for _, j in mine])
    pair = codes([(p.command, p.video) for p, _ in mine])
    place = codes([scenarios[p.command] for p, _ in mine])
    rater = codes([j.subject for _, j in mine])
    return RatedRow(
        name,
        bootstrap(agreeing, place, rng=rng, draws=draws),
        two_way(agreeing, place, rater),
        float(majorities(agreeing, pair).mean()),
        len(mine),
        len(np.unique(pair)),
        len(pairs),
    )


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
    automatic: Sequence[Row]
    """Rows of Table 3 by the automatic judge."""
    validity: Validity | None
    compared_by_people: Sequence[Comparison] = ()
    compared: Sequence[Comparison] = ()
    """Each two configurations on the commands that both have, by people and by the judge."""
    is_authored: bool = False
    """True if the commands are of an authored corpus."""


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
    study_pairs = pairs(records, chosen_commands(settings), settings.seed)
    film_all(folder, settings.test, study_pairs, _half(on_progress, 1))
    file = write_study(folder, study_pairs, settings.seed, pay)
    judgments = ratings_so_far(folder, ratings)
    both = {**outcomes_of(records), **baseline_outcomes(settings)}
    options = {"seed": settings.seed, "draws": draws}
    return Study(
        settings,
        file,
        study_pairs,
        records,
        by_people(study_pairs, records, judgments, **options) if judgments else (),
        by_judge(both, **options),
        known_validity(corpora.values(), **options),
        compare_people(study_pairs, records, judgments, **options) if judgments else (),
        compare_judge(both, **options),
        corpora[settings.test].is_authored,
    )


def baseline_outcomes(settings: Settings) -> dict[str, list[Outcome]]:
    """Return the outcomes of baselines' plans for a study's commands."""
    chosen = {annotation.command.id for annotation in chosen_commands(settings)}
    commands = [c for c in judged_commands(open_corpus(settings.test)) if c.command.id in chosen]
    return {
        name: [judged(c, plan_by_grounder(grounder_named(name), task_of(c))) for c in commands]
        for name in BASELINES
        if name not in missing()
    }


def ratings_so_far(folder: Path, ratings: Path | None) -> Sequence[Judgment]:
    """Return people's ratings, from a corpus, or without one from the app's database."""
    if ratings is not None:
        return Corpus.load(ratings).judgments
    if find_spec("sqlalchemy") is None:
        return ()

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
        people = [_flat(row, study.is_authored) for row in study.people] or None
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
    tables = {"People's judgments": _people(study)} if study.people else {}
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
    lines = [
        NOTE,
        in_a_line(study.validity),
        *lacking,
        f"{failed} of {len(study.records)} plans were stopped in physics; their videos end there",
        f"{len(study.pairs)} pairs of commands and videos to rate by {ANSWERS} people each: "
        f"ct annotate {study.file} --instance {study.file.parent / INSTANCE}",
    ]
    if study.people:
        lines.append(
            "95%: percentile intervals with whole scenarios resampled; scenarios, raters: for "
            "others of both"
        )
    else:
        lines.append(
            "nobody has rated yet; ratings are read from the app's database in the study's folder, "
            "or from --ratings, which `ct annotate export` writes"
        )
    return lines


def _people(study: Study) -> Table:
    papers = () if study.is_authored else ("Paper",)
    headings = ("Agree", "95%", "Scenarios, raters", "Majority", *papers, "n", "Rated pairs")
    table = figure_table(("Configuration", *headings))
    for row in study.people:
        paper = _paper(row, study.is_authored)
        table.add_row(
            row.configuration if row.configuration in PAPER else f"known {row.configuration}",
            f"{row.share.value:.2f}",
            interval(row.share),
            interval(row.two_way),
            f"{row.majority:.2f}",
            *("" if paper is None else f"{paper:.2f}" for _ in papers),
            str(row.judgments),
            f"{row.rated} of {row.n}",
        )
    return table


def _automatic(rows: Sequence[Row]) -> Table:
    headings = ("Ends where the log ends", "95%", "Does what the words say", "95%", "n")
    table = figure_table(("Configuration", *headings))
    for row in rows:
        shares = (estimates_of(row, verdict)[0] for verdict in ("precision", "by_words"))
        cells = (cell for one in shares for cell in (figure(one.value), interval(one)))
        table.add_row(row["configuration"], *cells, str(row["n"]))
    return table


def _paper(row: RatedRow, is_authored: bool) -> float | None:
    return beside(PAPER.get(row.configuration), row.rated, is_authored=is_authored)


def _flat(row: RatedRow, is_authored: bool) -> dict[str, object]:
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
        "paper": _paper(row, is_authored),
    }


MINUTES_EACH = 1


def received(folder: Path) -> Sequence[Judgment]:
    """Return people's ratings so far, from the database in the study's folder."""
    if not (folder / INSTANCE / DATABASE_FILE).exists():
        return ()
    with opened(_instance(folder).database) as engine, reading(engine, one_state=True) as session:
        return ratings(session, find_only_study(session, None))


def offer(
    file: Path,
    platform: str,
    url: str,
    items: int,
    *,
    sandbox: bool = False,
    endpoint: str | None = None,
) -> list[str]:
    """Put a study into the app, and offer as many assignments as its judgments take.

    A repeated offer adds only missing assignments. The result lists the assignments and their
    address.

    The study's file has the pay for a pair, unless only links are made; people reach the app at the
    URL, and an assignment has at most `items` pairs. In the platform's sandbox no money is paid;
    the endpoint is another address of its interface. A FormatError means that there is no such
    platform, nothing is paid, or credentials are missing; a PlatformError that the platform
    refuses.
    """
    provider = find_provider(platform)
    if provider is None:
        raise FormatError.unknown("platform", platform, [p.name for p in providers()])
    study = read_study(file)
    if provider.pays and study.payment is None:
        raise FormatError("the study doesn't say what is paid", where=str(file), fix="give --pay")
    config = _instance(file.parent)
    with opened(config.database) as engine:
        migrate(engine)
        with transaction(engine) as session:
            put_study(session, study, rendered_videos(file.parent / study.videos, study.only))
    # Nobody rates a pair twice.
    items = min(items, len(study.pairs))
    people = -(-ANSWERS * len(study.pairs) // items)
    with open_session(
        provider,
        study.name,
        instance=config.instance,
        database=None,
        sandbox=sandbox,
        endpoint=endpoint,
    ) as session:
        if not provider.pays:
            places = people if study.access == "invited" else 1  # an open link is for all
            return [*publish_links(session, url=url, task="rate", items=items, people=places)]
        posted = publish_posting(
            session,
            url=url,
            task="rate",
            items=items,
            people=people,
            minutes=MINUTES_EACH * items,
            min_approval=0,
            min_approved=0,
        )
    return [f"{posted.added} assignments added, {posted.people} in all", posted.address]


def _instance(folder: Path) -> Config:
    return open_instance(folder / INSTANCE)
