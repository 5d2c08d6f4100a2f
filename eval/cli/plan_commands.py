"""``ct eval --table 3`` and ``--end-to-end``: whether plans for commands are right."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from corpus_tools.options.format_option import FORMAT, format_option
from corpus_tools.options.model_options import ABLATE, L2
from corpus_tools.options.parallel_options import WORKERS
from corpus_tools.runtime.progress import progress_bar
from corpus_tools.runtime.terminal import note
from eval.cli.mode_options import (
    HELD_OUT,
    OUT,
    PERTURB,
    SEED,
    draws_option,
    is_terminal,
    train_and_test,
    write,
)
from eval.cli.option_sets import OptionSet, takes_one_of

if TYPE_CHECKING:
    from corpus_tools.runtime.parallel import Workers
    from eval.tables.formats import Format


@click.command(
    "--table 3",
    short_help="Score plans for commands of held-out scenarios.",
    epilog="\b\nExamples:\n"
    "  ct eval --table 3 --judge automatic --train aaai11 --test aaai11\n"
    "  ct eval --table 3 --judge automatic --train aaai11,warehouse --test aaai11 --json --jobs 2\n"
    "  ct eval --table 3 --judge automatic --train aaai11 --test aaai11 --ablate last-goal\n"
    "  ct eval --table 3 --judge automatic --train aaai11,warehouse --test automatic "
    "--heading loads --heading loads+45 --heading loads-45\n"
    "  ct eval --table 3 --judge automatic --train aaai11 --test warehouse --perturb articles",
)
@train_and_test
@click.option(
    "--judge",
    type=click.Choice(["automatic"]),
    required=True,
    help="Who says whether a plan is right: a program that compares it with the command's own "
    "log or outcome, and with its words. "
    "People's ratings are shown by --table 2.",
)
@HELD_OUT
@click.option(
    "--most",
    type=click.IntRange(min=0),
    default=0,
    show_default="all",
    help="How many commands of each scenario to follow.",
)
@click.option(
    "--heading",
    "headings",
    metavar="RULE",
    multiple=True,
    help="Which way robots face whose heading is assumed, such as loads, things or loads+30; "
    "give several for the mean over them [default: as imported].",
)
@PERTURB
@click.option(
    "--parses",
    type=click.IntRange(1, 20),
    default=3,
    show_default=True,
    help="How many SDC trees of each text to sum over, where the best one is not sure.",
)
@ABLATE
@L2
@SEED
@draws_option()
@format_option("csv", "latex", about="For people, for programs, for spreadsheets, for papers.")
@OUT
@WORKERS
def table_3(
    *,
    train: str,
    test: str,
    judge: Literal["automatic"],
    most: int,
    headings: tuple[str, ...],
    perturb: tuple[str, ...],
    parses: int,
    ablate: tuple[str, ...],
    l2: float | None,
    seed: int,
    draws: int,
    form: Format,
    out: Path | None,
    workers: Workers,
) -> None:
    """Follow the commands of --test after learning from --train: Table 3 (section 4.3).

    Each scenario is held out when it is tested. --judge automatic says of each plan whether it ends
    where the command's log ends, or its outcome where there is no log, and whether it does what
    annotated words say. The table says how valid that is. Baselines without a model are rows of the
    table. With --out, scenarios that are done are kept beside the file until it is written, so
    that a run that was stopped goes on.
    """
    from corpus_tools import __version__
    from corpus_tools.importers.authored.bundled import open_corpus
    from eval.judging.judge_report import in_a_line, with_validity
    from eval.judging.judge_validity import known_validity
    from eval.table_3.baselines import missing
    from eval.table_3.end_to_end import run
    from eval.table_3.judged_commands import OUTCOMES
    from eval.table_3.kept_outcomes import kept_beside
    from eval.table_3.plan_report import NOT_VALIDATED, render
    from g3.features.feature_registry import CATALOGUE_VERSION

    strength = l2 or 1.0
    settings = {
        "corpora": [open_corpus(name).hash for name in (*train.split(","), test)],
        "program": __version__,
        "features": CATALOGUE_VERSION,
        "l2": strength,
        "seed": seed,
        "ablate": sorted(set(ablate)),
        "headings": list(headings),
        "perturb": list(perturb),
        "parses": parses,
        "most": most,
        "missing": sorted(missing()),
    }
    kept = kept_beside(out, settings) if out else None
    if kept and kept.scenarios:
        note(f"ct: {len(kept.scenarios)} scenarios are done already: {kept.path}")
    with progress_bar("reading corpora") as on_progress:
        result = run(
            train,
            test,
            l2=strength,
            seed=seed,
            ablate=ablate,
            headings=headings,
            perturb=perturb,
            parses=parses,
            most=most,
            done=kept.scenarios if kept else {},
            on_scenario=kept.keep if kept else None,
            workers=workers,
            on_progress=on_progress,
        )
    is_by_logs = result.metadata["compared_with"] != OUTCOMES
    corpora = (open_corpus(name) for name in (test, *train.split(",")) if is_by_logs)
    validity = known_validity(corpora, draws=draws, seed=seed)
    text = render(result, form, draws=draws, seed=seed)
    if form == "json":
        text = with_validity(text, validity)
    elif form == "text":
        text = f"{text}\n{in_a_line(validity) if is_by_logs else NOT_VALIDATED}"
    write(text, out)
    if kept:
        kept.path.unlink(missing_ok=True)


def _kinds(_ctx: click.Context, _option: click.Parameter, value: str) -> tuple[str, ...]:
    """The kinds of plans to rate, in their order."""
    named = tuple(dict.fromkeys(value.split(","))) if value else ()
    strange = [kind for kind in named if kind not in ("wrong", "right")]
    if strange:
        raise click.BadParameter(f"there is no kind {strange[0]!r}; give wrong, right or both")
    return named


@click.command(
    "--end-to-end",
    short_help="Have people rate videos of plans (section 4.3).",
    epilog="\b\nExamples:\n"
    "  ct eval --end-to-end study --train aaai11,warehouse --test aaai11 --most 2\n"
    "  ct eval --end-to-end set --train aaai11 --test aaai11 --plans wrong,right --most 200\n"
    "  ct eval --end-to-end study --train aaai11 --test aaai11 --crowd mturk --sandbox "
    "--pay 0.05 --url https://lab.example.org",
)
@takes_one_of(OptionSet(), OptionSet(("--crowd", "--url"), ("--pay", "--items", "--sandbox")))
@click.option(
    "--end-to-end",
    "folder",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="FOLDER",
    required=True,
    help="Where the study is kept.",
)
@train_and_test
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
    type=click.Path(path_type=Path, file_okay=False, exists=True),
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
@SEED
@draws_option()
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
    """Make videos of plans and a study in which people rate them, and show what they said so far.

    A study that was stopped goes on where it was. --crowd offers the work at a platform.

    With --plans you get a rating set. It has plans of all commands, drawn evenly from scenarios and
    configurations, so that people's ratings show how far to believe the automatic judge. Before
    videos are made you see how many there are, how sure the figures will be, and how long people
    take.
    """
    from corpus_tools.video.drawing.gl import choose_back_end

    # Before MuJoCo is imported, which reads what this chooses.
    choose_back_end()
    from eval.plan_study import rating_report, rating_set, whole_study
    from eval.plan_study.study_rating import Crowd, offer
    from eval.plan_study.study_settings import settings_for

    settings = settings_for(train, test, most=most, l2=l2 or 1.0, seed=seed, plans=plans)
    terminal = is_terminal(out)
    if plans:
        with progress_bar("reading corpora") as on_progress:
            drawn = rating_set.prepare(folder, settings, on_progress=on_progress)
        note(*rating_report.lines_planned(drawn.planned))
        with progress_bar("videos") as on_progress:
            rated = rating_set.finish(
                drawn, ratings=ratings, pay=pay, draws=draws, on_progress=on_progress
            )
        file, text = rated.file, rating_report.render(rated, form, terminal=terminal)
    else:
        with progress_bar("reading corpora") as on_progress:
            study = whole_study.go_on(
                folder, settings, ratings=ratings, pay=pay, draws=draws, on_progress=on_progress
            )
        file, text = study.file, whole_study.render(study, form, terminal=terminal)
    if crowd:
        endpoint = os.environ.get("CT_CROWD_ENDPOINT")
        for line in offer(file, Crowd(crowd, url, items, sandbox, endpoint)):
            note(line)
    write(text, out)
