"""``ct eval``: the tables, the learning curve and the error lists of the paper's section 4."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import click

from corpus_tools.format_option import format_option
from corpus_tools.model_options import training_options
from corpus_tools.parallel_options import JOBS, SCHEDULER
from corpus_tools.terminal import say
from eval.command_checks import check_together, read_mode


@click.command(
    "eval",
    epilog="\b\nExamples:\n"
    "  ct eval --table 1 --corpus aaai11 --cv scenario\n"
    "  ct eval --table 1 --corpus aaai11 --split scenario --test-scenarios go_to_truck1,lift3\n"
    "  ct eval --table 1 --train aaai11 --test warehouse --json\n"
    "  ct eval --table 1 --model g3.npz --test warehouse --negatives hard\n"
    "  ct eval --table 1 --corpus aaai11 --cv scenario --ablate labels --format latex\n"
    "  ct eval --learning-curve --corpus aaai11 --out curve.png\n"
    "  ct eval --errors --corpus aaai11 --cv scenario --top 5\n"
    "  ct eval --table 2 --corpus aaai11\n"
    "  ct eval --table 3 --judge automatic --train aaai11 --test aaai11 --json\n"
    "  ct eval --end-to-end study --train aaai11,warehouse --test aaai11 --most 2\n"
    "  ct eval --end-to-end study --train aaai11 --test aaai11 --crowd mturk --sandbox "
    "--pay 0.05 --url https://lab.example.org\n"
    "  ct eval --judge-validity --corpus aaai11\n"
    "  ct eval --report report --corpus aaai11 --plans table-3.json --videos videos\n"
    "  ct eval --power --half-width 0.02 --corpus aaai11\n"
    "  ct eval --sdc --test warehouse --train aaai11 --json\n"
    "  ct eval --sdc --corpus aaai11 --cv scenario",
)
@click.option("--table", type=int, metavar="1|2|3", help="Print this table of the paper.")
@click.option(
    "--judge",
    type=click.Choice(["automatic"]),
    help="Who says for --table 3 whether a plan is right: a comparison with the command's own log.",
)
@click.option("--learning-curve", "curve", is_flag=True, help="Test error by size of training.")
@click.option("--errors", is_flag=True, help="List high- and low-scoring examples by type.")
@click.option("--sdc", is_flag=True, help="Score the extraction of SDC trees from text.")
@click.option(
    "--end-to-end",
    "study_folder",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="FOLDER",
    help="Make plans, runs and videos for people to rate, or go on with it; Table 3 so far.",
)
@click.option(
    "--most",
    type=click.IntRange(min=0),
    default=0,
    show_default="all",
    help="How many commands of each scenario --end-to-end follows.",
)
@click.option(
    "--ratings",
    type=click.Path(path_type=Path, file_okay=False, exists=True),
    help="What `ct annotate export` has written of the study of --end-to-end "
    "[default: what is in the app's database in its folder].",
)
@click.option(
    "--crowd",
    metavar="PROVIDER",
    default="",
    help="Offer the study of --end-to-end as `ct publish` does: links, mturk or prolific.",
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
@click.option(
    "--judge-validity",
    "validity",
    is_flag=True,
    help="Say whether the automatic judge says what people said of the same videos.",
)
@click.option(
    "--report",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="FOLDER",
    help="Write a page with all of it, and the same as JSON, CSV and LaTeX.",
)
@click.option(
    "--plans",
    type=click.Path(path_type=Path, dir_okay=False, exists=True),
    help="What --table 3 --format json has written, to be in the report.",
)
@click.option(
    "--videos",
    type=click.Path(path_type=Path, file_okay=False, exists=True),
    help="What `ct render-videos` has made, to show some in the report.",
)
@click.option("--power", is_flag=True, help="Say how large a rating study must be.")
@click.option(
    "--corpus", metavar="CORPUS", default="", help="The corpus to divide, or that has ratings."
)
@click.option(
    "--cv", type=click.Choice(["scenario"]), help="Leave out each scenario of --corpus in turn."
)
@click.option(
    "--split",
    type=click.Choice(["scenario"]),
    help="Hold out some scenarios of --corpus (the default).",
)
@click.option(
    "--test-scenarios",
    metavar="FILE|A,B,...",
    default="",
    help="Scenarios to hold out; a third drawn with --seed if left out.",
)
@click.option("--train", metavar="CORPUS", default="", help="Train on all of a corpus.")
@click.option("--test", metavar="CORPUS", default="", help="Test on all of a corpus.")
@click.option(
    "--model", type=click.Path(path_type=Path), help="Test a model of `ct train g3` on --test."
)
@training_options
@click.option(
    "--test-negatives",
    type=click.Choice(["random", "hard"]),
    help="Test on other negatives than --negatives, which are then only trained on.",
)
@click.option(
    "--seed",
    type=click.IntRange(min=0),
    default=0,
    show_default=True,
    help="What splits, hard negatives, resamples and orders are drawn with.",
)
@click.option(
    "--threshold",
    type=click.FloatRange(0, 1),
    default=0.5,
    show_default=True,
    help="Probability from which a correspondence is predicted.",
)
@click.option(
    "--draws",
    type=click.IntRange(min=1),
    show_default="2000, for Table 2 10000",
    help="Resamples for the intervals of --table.",
)
@click.option("--study", default="", help="Whose ratings Table 2 counts [default: the largest].")
@click.option(
    "--models",
    is_flag=True,
    help="Fit estimating equations and a cumulative-link model to Table 2's ratings too.",
)
@click.option(
    "--half-width",
    type=click.FloatRange(0.001, 0.5),
    default=0.03,
    show_default=True,
    help="Of the interval that --power plans for.",
)
@click.option(
    "--repeats",
    type=click.IntRange(min=0),
    default=5,
    show_default=True,
    help="Random orders of the commands for the learning curve; 0 leaves it out of a report.",
)
@click.option(
    "--top",
    type=click.IntRange(min=1),
    default=10,
    show_default=True,
    help="Phrases in each list of --errors, or commands listed by --sdc.",
)
@format_option("csv", "latex", about="For people, for programs, or for a paper.")
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    help="Write to a file; for --learning-curve the plot, .png or .svg, with a .csv beside.",
)
@JOBS
@SCHEDULER
@click.pass_context
def evaluate(ctx: click.Context, /, **given: Any) -> None:
    """Measure how well models predict whether SDCs match groundings (section 4.2).

    Give what to make (--table 1, --learning-curve or --errors) and what to train and test
    on: one --corpus that is divided by scenario (--cv or --split), two corpora (--train
    and --test), or a trained --model and a --test corpus.

    --sdc measures how well SDC trees are extracted from text: with --corpus and --cv
    scenario (and --train for a corpus to learn from besides), with --test and --train or
    --model, or with --test alone for the extractor that comes along.

    --table 2 shows how often people agree that a video shows a command, from the ratings in
    --corpus; --power says how many ratings a study needs, which may be like those in --corpus.

    --end-to-end makes videos of the plans and a study in which people rate them, and shows what
    they have said so far. It goes on where it was stopped. --crowd offers the work at a platform.

    --report measures a corpus, each scenario held out in turn, and writes all of it on one page.

    --table 3 follows the commands of --test after learning from --train, with every scenario held
    out that is tested; --judge automatic compares where the plans lead with the commands' logs.
    --jobs and --scheduler follow the commands of several scenarios at once, and make the resamples
    of Tables 1 and 2 and of --judge-validity.
    """
    mode = read_mode(ctx)
    check_together(ctx, mode, given["table"])
    out: Path | None = given["out"]
    if out is not None and not out.parent.is_dir():
        raise click.UsageError(f"--out: there is no folder {out.parent}; make it first.")
    from eval.mode_commands import MAKERS

    text = MAKERS[mode](given, terminal=out is None and sys.stdout.isatty())
    if text is not None:
        _write(text, out)


def _write(text: str, out: Path | None) -> None:
    from corpus_tools.atomic_file import write_bytes

    if out is None:
        say(text, styled=True)
    else:
        write_bytes(out, f"{text}\n".encode())
