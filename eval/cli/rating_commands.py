"""``ct eval table2``, ``judge-validity``, ``power``, ``end-to-end``: people's ratings of videos."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from corpus_tools.options import (
    FORMAT,
    L2,
    OUT,
    TARGET_FOLDER,
    WORKERS,
    ExistingPath,
    corpus_option,
    format_option,
)
from corpus_tools.runtime.progress import progress_bar
from corpus_tools.runtime.terminal import note
from eval.cli import modes

if TYPE_CHECKING:
    from corpus_tools.runtime.parallel import Workers
    from eval.language_model.chat_endpoint import Endpoint
    from eval.tables.formats import Format


FORMATS = format_option("csv", "latex", about="For people, for programs, or for a paper.")


@click.command(
    "table2",
    short_help="Show how often people agree that a video fits.",
    epilog="\b\nExamples:\n  ct eval table2\n  ct eval table2 --corpus aaai11 --models --json",
)
@corpus_option(
    "--corpus",
    default="warehouse-simulated-ratings",
    show_default=True,
    help="The corpus with ratings; those of the default are simulated.",
)
@modes.STUDY
@click.option(
    "--models",
    is_flag=True,
    help="Fit estimating equations and a cumulative-link model too (extra: study).",
)
@modes.VERBOSE
@modes.SEED
@modes.draws_option(10_000)
@FORMATS
@OUT
@WORKERS
def table_2(
    *,
    corpus: str,
    study: str,
    models: bool,
    verbose: bool,
    seed: int,
    draws: int,
    form: Format,
    out: Path | None,
    workers: Workers,
) -> None:
    """Show how often people agree that a video shows a command: Table 2 (section 4.1).

    The ratings are those in --corpus.
    """
    from corpus_tools.importers.authored.bundled import open_corpus
    from corpus_tools.runtime.parallel import Executor
    from eval.statistics.ratings import check_judgments
    from eval.table_2.rating_shares import table_2 as make
    from eval.table_2.rating_table import render

    rated = open_corpus(corpus)
    check_judgments(rated.judgments, {command.video for command in rated.commands.values()})
    with Executor(workers) as executor:
        results = make(
            rated.judgments, study=study, models=models, seed=seed, draws=draws, executor=executor
        )
    metadata: dict[str, object] = {
        "table": 2,
        "corpus": corpus,
        "is_authored": rated.is_authored,
        "seed": seed,
        "draws": draws,
    }
    text = render(results, form, metadata, verbose=verbose, terminal=modes.is_terminal(out))
    modes.write(text, out)


@click.command(
    "judge-validity",
    short_help="Compare the automatic judge with people.",
    epilog="\b\nExamples:\n"
    "  ct eval judge-validity --corpus aaai11\n"
    "  ct eval judge-validity --corpus aaai11 --json\n"
    "  ct eval judge-validity --corpus aaai11 --judge llm --llm qwen2.5-7b "
    "--endpoint http://localhost:8000/v1",
)
@corpus_option("--corpus", required=True, help="The corpus with people's ratings.")
@modes.STUDY
@click.option(
    "--judge",
    metavar="NAME",
    default="automatic",
    show_default=True,
    help="Compare this judge as well: llm, or one of an installed package.",
)
@modes.language_model_options
@modes.SEED
@modes.draws_option()
@FORMAT
@OUT
@WORKERS
def judge_validity(
    *,
    corpus: str,
    study: str,
    judge: str,
    endpoint: Endpoint | None,
    seed: int,
    draws: int,
    form: Literal["text", "json"],
    out: Path | None,
    workers: Workers,
) -> None:
    """Compare the automatic judge with people on the same videos.

    With --judge another judge is compared with people on the same pairs.
    """
    from corpus_tools.importers.authored.bundled import open_corpus
    from corpus_tools.runtime.parallel import Executor
    from eval.judging.judge_registry import AUTOMATIC
    from eval.judging.judge_report import render
    from eval.judging.judge_validity import judge_validity as compare

    other = None if judge == AUTOMATIC else modes.judge_of(judge, endpoint)
    with Executor(workers) as executor:
        result = compare(
            open_corpus(corpus),
            study=study,
            seed=seed,
            draws=draws,
            other=other,
            executor=executor,
        )
    metadata: dict[str, object] = {"corpus": corpus, "seed": seed, "draws": draws}
    if other:
        metadata["other_judge"] = {other.name: dict(other.about)}
    used = modes.used_of(endpoint, judge=True)
    if used:
        metadata["language_model"] = used
    modes.write(render(result, form, metadata, terminal=modes.is_terminal(out)), out)


@click.command(
    "power",
    short_help="Say how many ratings a study needs.",
    epilog="\b\nExamples:\n"
    "  ct eval power --half-width 0.02\n"
    "  ct eval power --half-width 0.02 --corpus aaai11",
)
@click.option(
    "--half-width",
    type=click.FloatRange(0.001, 0.5),
    default=0.03,
    show_default=True,
    help="Half the width of the interval to plan for.",
)
@corpus_option("--corpus", default="", help="Expect ratings like those in this corpus.")
@modes.SEED
@FORMATS
@OUT
def power(*, half_width: float, corpus: str, seed: int, form: Format, out: Path | None) -> None:
    """Show the pairs and ratings that a study needs for an interval of a given width."""
    from corpus_tools.importers.authored.bundled import open_corpus
    from eval.statistics.ratings import judged_by, of_study
    from eval.table_2.power_plans import assumptions, plans, render

    judgments = open_corpus(corpus).judgments if corpus else None
    share, correlation = assumptions(judgments)
    metadata = {
        "corpus": corpus or "none",
        **({"judged_by": judged_by(of_study(judgments)[0].study)} if judgments else {}),
        "wanted_half_width": half_width,
        "share": round(share.value, 3),
        "correlation": round(correlation.value, 3),
        **{
            f"{name}_reason": one.reason
            for name, one in (("share", share), ("correlation", correlation))
            if one.reason
        },
        "seed": seed,
    }
    rows = plans(half_width, share, correlation, seed)
    modes.write(render(rows, form, metadata, terminal=modes.is_terminal(out)), out)


def _kinds(_ctx: click.Context, _option: click.Parameter, value: str) -> tuple[str, ...]:
    """Parse the kinds of plans to rate, in their order."""
    named = tuple(dict.fromkeys(value.split(","))) if value else ()
    strange = [kind for kind in named if kind not in ("wrong", "right")]
    if strange:
        raise click.BadParameter(f"there is no kind {strange[0]!r}; give wrong, right or both")
    return named


@click.command(
    "end-to-end",
    short_help="Have people rate videos of plans (section 4.3).",
    epilog="\b\nExamples:\n"
    "  ct eval end-to-end study --train aaai11,warehouse --test aaai11 --most 2\n"
    "  ct eval end-to-end set --train aaai11 --test aaai11 --plans wrong,right --most 200\n"
    "  ct eval end-to-end study --train aaai11 --test aaai11 --crowd mturk --sandbox "
    "--pay 0.05 --url https://lab.example.org",
)
@modes.takes_one_of(
    modes.OptionSet(), modes.OptionSet(("--crowd", "--url"), ("--pay", "--items", "--sandbox"))
)
@click.argument("folder", metavar="FOLDER", type=TARGET_FOLDER)
@modes.TRAIN
@modes.FOLLOWED
@click.option(
    "--most",
    type=click.IntRange(min=0),
    default=0,
    show_default="all",
    help="How many commands of each scenario to follow; with --plans, how many plans to rate.",
)
@click.option(
    "--plans",
    callback=_kinds,
    metavar="KIND,...",
    default="",
    help="Have people rate plans that the automatic judge calls wrong, right or both, to check "
    "the judge. The kind that you name first gets most of the pairs.",
)
@click.option(
    "--ratings",
    type=ExistingPath(file_okay=False),
    help="What `ct annotate export` has written of the study "
    "[default: what is in the app's database in its folder].",
)
@click.option(
    "--crowd",
    metavar="PROVIDER",
    default="",
    help="Offer the study as `ct crowd publish` does: links, mturk or prolific.",
)
@click.option(
    "--url", metavar="URL", default="", help="Address at which the people of --crowd reach it."
)
@click.option(
    "--pay",
    type=click.FloatRange(0.01, 100),
    help="What the people of --crowd get for a pair, in dollars.",
)
@click.option(
    "--items",
    type=click.IntRange(1, 1000),
    default=20,
    show_default=True,
    help="How many pairs an assignment of --crowd asks for.",
)
@click.option("--sandbox", is_flag=True, help="Use the platform's test mode, without money.")
@L2
@modes.SEED
@modes.draws_option()
@FORMAT
@OUT
def end_to_end(
    *,
    folder: Path,
    train: str,
    test: str,
    most: int,
    plans: tuple[str, ...],
    ratings: Path | None,
    crowd: str,
    url: str,
    pay: float | None,
    items: int,
    sandbox: bool,
    l2: float | None,
    seed: int,
    draws: int,
    form: Literal["text", "json"],
    out: Path | None,
) -> None:
    """Make videos of plans and a study for people to rate them, and show the ratings so far.

    The study is kept in FOLDER. An interrupted one is resumed. --crowd offers the work at a
    platform.

    With --plans you get a rating set. It has plans of all commands, drawn evenly from scenarios and
    configurations, so that people's ratings show how far to believe the automatic judge. Before
    videos are made it shows their number, the expected precision of the figures, and the time for
    people to rate.
    """
    from corpus_tools.video.drawing.gl import choose_back_end

    # Before MuJoCo is imported, which reads what this chooses.
    choose_back_end()
    from eval.plan_study import rating_set, whole_study
    from eval.plan_study.study_plans import settings_for
    from eval.plan_study.whole_study import offer

    settings = settings_for(train or test, test, most=most, l2=l2 or 1.0, seed=seed, plans=plans)
    terminal = modes.is_terminal(out)
    if plans:
        with progress_bar("reading corpora") as on_progress:
            drawn = rating_set.prepare(folder, settings, on_progress=on_progress)
        note(*rating_set.lines_planned(drawn.planned))
        with progress_bar("videos") as on_progress:
            rated = rating_set.finish(
                drawn, ratings=ratings, pay=pay, draws=draws, on_progress=on_progress
            )
        file, text = rated.file, rating_set.render(rated, form, terminal=terminal)
    else:
        with progress_bar("reading corpora") as on_progress:
            study = whole_study.go_on(
                folder, settings, ratings=ratings, pay=pay, draws=draws, on_progress=on_progress
            )
        file, text = study.file, whole_study.render(study, form, terminal=terminal)
    if crowd:
        endpoint = os.environ.get("CT_CROWD_ENDPOINT")
        for line in offer(file, crowd, url, items, sandbox=sandbox, endpoint=endpoint):
            note(line)
    modes.write(text, out)
