"""``ct eval``: the tables, the learning curve and the error lists of the paper's section 4."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import click

from corpus_tools.model_options import training_options
from corpus_tools.progress import progress_bar
from eval.command_checks import check_together, is_given, read_mode

if TYPE_CHECKING:
    from eval.protocol import Choices
    from eval.sdc_trials import SDCChoices

Form = Literal["table", "json", "csv", "latex"]
STUDY_DRAWS = 10_000
"""Resamples for Table 2, which has but a few numbers for each."""


@click.command(
    "eval",
    epilog="\b\nExamples:\n"
    "  ct eval --table 1 --corpus aaai11 --cv scenario\n"
    "  ct eval --table 1 --corpus aaai11 --split scenario --test-scenarios go_to_truck1,lift3\n"
    "  ct eval --table 1 --train aaai11 --test warehouse --format json\n"
    "  ct eval --table 1 --model g3.npz --test warehouse --negatives hard\n"
    "  ct eval --table 1 --corpus aaai11 --cv scenario --ablate labels --format latex\n"
    "  ct eval --learning-curve --corpus aaai11 --out curve.png\n"
    "  ct eval --errors --corpus aaai11 --cv scenario --top 5\n"
    "  ct eval --table 2 --corpus aaai11\n"
    "  ct eval --table 3 --judge automatic --train aaai11 --test aaai11 --format json\n"
    "  ct eval --power --half-width 0.02 --corpus aaai11\n"
    "  ct eval --sdc --test warehouse --train aaai11 --format json\n"
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
    default=2000,
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
    type=click.IntRange(min=1),
    default=5,
    show_default=True,
    help="Random orders of the commands for --learning-curve.",
)
@click.option(
    "--top",
    type=click.IntRange(min=1),
    default=10,
    show_default=True,
    help="Phrases in each list of --errors, or commands listed by --sdc.",
)
@click.option(
    "--format",
    "form",
    type=click.Choice(["table", "json", "csv", "latex"]),
    default="table",
    show_default=True,
    help="For people, for programs, or for a paper.",
)
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    help="Write to a file; for --learning-curve the plot, .png or .svg, with a .csv beside.",
)
@click.pass_context
def evaluate(
    ctx: click.Context,
    *,
    table: int | None,
    judge: str | None,
    curve: bool,
    errors: bool,
    sdc: bool,
    power: bool,
    corpus: str,
    cv: str | None,
    split: str | None,
    test_scenarios: str,
    train: str,
    test: str,
    model: Path | None,
    negatives: Literal["random", "hard"],
    test_negatives: Literal["random", "hard"] | None,
    ablate: tuple[str, ...],
    plus: tuple[str, ...],
    l2: float | None,
    seed: int,
    threshold: float,
    draws: int,
    study: str,
    models: bool,
    half_width: float,
    repeats: int,
    top: int,
    form: Form,
    out: Path | None,
) -> None:
    """Measure how well models predict whether SDCs match groundings (section 4.2).

    Give what to make (--table 1, --learning-curve or --errors) and what to train and test
    on: one --corpus that is divided by scenario (--cv or --split), two corpora (--train
    and --test), or a trained --model and a --test corpus.

    --sdc measures how well SDC trees are extracted from text: with --corpus and --cv
    scenario (and --train for a corpus to learn from besides), with --test and --train or
    --model, or with --test alone for the extractor that comes along.

    --table 2 shows how often people agree that a video shows a command, from the ratings in
    --corpus; --power says how many ratings a study needs, which may be like those in --corpus.

    --table 3 follows the commands of --test after learning from --train, with every scenario held
    out that is tested; --judge automatic compares where the plans lead with the commands' logs.
    """
    mode = read_mode(ctx, table, curve, errors)
    check_together(ctx, mode, table)
    if out is not None and not out.parent.is_dir():
        raise click.UsageError(f"--out: there is no folder {out.parent}; make it first.")
    if mode == "power":
        _write(_power(corpus, half_width, seed, form, terminal=_is_terminal(out)), out)
        return
    if table == 2:
        chosen = draws if is_given(ctx, "draws") else STUDY_DRAWS
        options = {"seed": seed, "draws": chosen, "study": study, "models": models}
        _write(_table_2(corpus, options, form, terminal=_is_terminal(out)), out)
        return
    if table == 3:
        options = {"l2": l2 or 1.0, "seed": seed}
        _write(_table_3(train, test, options, draws, form), out)
        return
    if mode == "sdc":
        from eval.sdc_trials import SDCChoices

        extraction = SDCChoices(corpus, train, test, model, l2)
        _write(_sdc(extraction, top, form, terminal=_is_terminal(out)), out)
        return
    from eval.protocol import Choices

    choices = Choices(
        corpus=corpus,
        train=train,
        test=test,
        model=model,
        division="cv" if cv else "split",
        test_scenarios=test_scenarios,
        negatives=negatives,
        test_negatives=test_negatives,
        ablate=ablate,
        plus=plus,
        l2=l2,
        threshold=threshold,
        seed=seed,
    )
    if mode == "curve":
        _learning_curve(choices, repeats, out)
    elif mode == "errors":
        _write(_errors(choices, top, form, terminal=_is_terminal(out)), out)
    else:
        _write(_table_1(choices, draws, form, terminal=_is_terminal(out)), out)


# One function for each mode


def _table_1(choices: Choices, draws: int, form: Form, *, terminal: bool) -> str:
    from eval import trials
    from eval.correspondence import table_rows
    from eval.formats import render

    with progress_bar("extracting features") as on_progress:
        result = trials.run(choices, on_progress)
    rows = table_rows(
        result.predictions, threshold=choices.threshold, draws=draws, seed=choices.seed
    )
    metadata = {"table": 1, **result.metadata, "draws": draws}
    return render(rows, form, metadata, terminal=terminal)


def _table_2(corpus: str, options: dict[str, Any], form: Form, *, terminal: bool) -> str:
    from corpus_tools.bundled import open_corpus
    from eval.studies.ratings import check_judgments
    from eval.studies.table_2 import render, table_2

    found = open_corpus(corpus)
    check_judgments(found.judgments, {command.video for command in found.commands.values()})
    results = table_2(found.judgments, **options)
    metadata = {"table": 2, "corpus": corpus, "seed": options["seed"], "draws": options["draws"]}
    return render(results, form, metadata, terminal=terminal)


def _table_3(train: str, test: str, options: dict[str, Any], draws: int, form: Form) -> str:
    from eval.end_to_end import run
    from eval.plan_report import render

    with progress_bar("reading corpora") as on_progress:
        result = run(train, test, on_progress=on_progress, **options)
    return render(result, "json" if form == "json" else "table", draws=draws, seed=options["seed"])


def _power(corpus: str, half_width: float, seed: int, form: Form, *, terminal: bool) -> str:
    from corpus_tools.bundled import open_corpus
    from eval.studies.plans import assumptions, plans, render

    share, correlation = assumptions(open_corpus(corpus).judgments if corpus else ())
    metadata = {
        "corpus": corpus or "none",
        "wanted_half_width": half_width,
        "share": round(share, 3),
        "correlation": round(correlation, 3),
        "seed": seed,
    }
    rows = plans(half_width, share, correlation, seed)
    return render(rows, form, metadata, terminal=terminal)


def _sdc(choices: SDCChoices, top: int, form: str, *, terminal: bool) -> str:
    from eval.sdc_report import render
    from eval.sdc_trials import run

    with progress_bar("analysing commands") as on_progress:
        trials, metadata = run(choices, on_progress)
    if metadata.get("seen_scenarios"):
        click.echo(
            "ct: the model was trained on scenarios that are tested; "
            "--corpus with --cv scenario holds them out",
            err=True,
        )
    shown: Literal["table", "json"] = "json" if form == "json" else "table"
    return render(trials, shown, metadata, top=top, terminal=terminal)


def _errors(choices: Choices, top: int, form: str, *, terminal: bool) -> str:
    from eval import trials
    from eval.error_lists import error_lists, render_lists

    with progress_bar("extracting features") as on_progress:
        result = trials.run(choices, on_progress)
    lists = error_lists(result.predictions, result.shown, k=top, threshold=choices.threshold)
    metadata = {**result.metadata, "top": top}
    return render_lists(lists, "json" if form == "json" else "table", metadata, terminal=terminal)


def _learning_curve(choices: Choices, repeats: int, out: Path | None) -> None:
    if out is None or out.suffix.lower() not in (".png", ".svg"):
        raise click.UsageError("--learning-curve needs --out FILE.png or FILE.svg.")
    from eval import trials
    from eval.learning_curve import write_csv, write_plot

    with progress_bar("extracting features") as on_progress:
        points, metadata = trials.curve(choices, repeats, on_progress)
    bounds = f"range of {repeats} random orders"
    write_csv(points, out.with_suffix(".csv"), metadata=metadata)
    write_plot(points, out, metadata=metadata, bounds=bounds)
    click.echo(f"wrote {out} and {out.with_suffix('.csv')}")


# Output


def _is_terminal(out: Path | None) -> bool:
    return out is None and sys.stdout.isatty()


def _write(text: str, out: Path | None) -> None:
    from corpus_tools.atomic_file import write_bytes

    if out is None:
        click.echo(text)
    else:
        write_bytes(out, f"{text}\n".encode())
