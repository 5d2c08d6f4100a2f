"""``ct eval end-to-end``: people rate videos of plans."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Literal

import click

from corpus_tools.options.format_option import FORMAT, OUT, TARGET_FOLDER
from corpus_tools.options.model_options import L2
from corpus_tools.runtime.progress import progress_bar
from corpus_tools.runtime.terminal import note
from eval.cli.modes import (
    FOLLOWED,
    SEED,
    TRAIN,
    OptionSet,
    draws_option,
    is_terminal,
    takes_one_of,
    write,
)


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
@takes_one_of(OptionSet(), OptionSet(("--crowd", "--url"), ("--pay", "--items", "--sandbox")))
@click.argument("folder", metavar="FOLDER", type=TARGET_FOLDER)
@TRAIN
@FOLLOWED
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
    terminal = is_terminal(out)
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
    write(text, out)
