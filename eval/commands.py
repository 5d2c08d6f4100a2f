"""``ct eval``: the tables, the learning curve and the error lists of the paper's section 4."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click
from click.core import ParameterSource

from corpus_tools.model_options import training_options
from corpus_tools.progress import progress_bar

if TYPE_CHECKING:
    from eval.protocol import Choices

DESCRIBED = {"table": "--table", "curve": "--learning-curve", "errors": "--errors"}


@click.command(
    "eval",
    epilog="\b\nExamples:\n"
    "  ct eval --table 1 --corpus aaai11 --cv scenario\n"
    "  ct eval --table 1 --corpus aaai11 --split scenario --test-scenarios go_to_truck1,lift3\n"
    "  ct eval --table 1 --train aaai11 --test warehouse --format json\n"
    "  ct eval --table 1 --model g3.npz --test warehouse --negatives hard\n"
    "  ct eval --table 1 --corpus aaai11 --cv scenario --ablate labels --format latex\n"
    "  ct eval --learning-curve --corpus aaai11 --out curve.png\n"
    "  ct eval --errors --corpus aaai11 --cv scenario --top 5",
)
@click.option("--table", type=int, metavar="1", help="Print this table of the paper: 1.")
@click.option("--learning-curve", "curve", is_flag=True, help="Test error by size of training.")
@click.option("--errors", is_flag=True, help="List high- and low-scoring examples by type.")
@click.option("--corpus", metavar="CORPUS", default="", help="The corpus to divide.")
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
    show_default=True,
    help="Resamples for the intervals of --table.",
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
    help="Phrases in each list of --errors.",
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
    curve: bool,
    errors: bool,
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
    repeats: int,
    top: int,
    form: Literal["table", "json", "csv", "latex"],
    out: Path | None,
) -> None:
    """Measure how well models predict whether SDCs match groundings (section 4.2).

    Give what to make (--table 1, --learning-curve or --errors) and what to train and test
    on: one --corpus that is divided by scenario (--cv or --split), two corpora (--train
    and --test), or a trained --model and a --test corpus.
    """
    mode = _mode(ctx, table, curve, errors)
    _check_sources(ctx)
    _check_options(ctx, mode)
    if out is not None and not out.parent.is_dir():
        raise click.UsageError(f"--out: there is no folder {out.parent}; make it first.")
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


# What is wrong with the options


def _mode(ctx: click.Context, table: int | None, curve: bool, errors: bool) -> str:
    chosen = [name for name in DESCRIBED if _is_given(ctx, name)]
    if len(chosen) != 1:
        raise click.UsageError("Give one of --table 1, --learning-curve and --errors.")
    if table in (2, 3):
        raise click.UsageError(f"Table {table} can't be made yet; tables 2 and 3 come later.")
    if table not in (None, 1):
        raise click.UsageError(f"The paper has no table {table}; give --table 1.")
    return chosen[0]


def _is_given(ctx: click.Context, name: str) -> bool:
    if ctx.get_parameter_source(name) in (ParameterSource.DEFAULT, None):
        return False
    return ctx.params[name] not in (None, False, "", ())


def _check_sources(ctx: click.Context) -> None:
    given = {name for name in ("corpus", "train", "test", "model") if _is_given(ctx, name)}
    if given not in ({"corpus"}, {"train", "test"}, {"model", "test"}):
        raise click.UsageError(
            "Give --corpus (with --cv scenario or --split scenario), --train and --test, "
            "or --model and --test."
        )
    if given != {"corpus"}:
        _refuse(ctx, ("cv", "split", "test_scenarios"), "divides one --corpus")
    if _is_given(ctx, "cv"):
        _refuse(ctx, ("split", "test_scenarios"), "can't go with --cv, which tests all scenarios")
    if "model" in given:
        _refuse(ctx, ("ablate", "plus", "l2"), "is for training, and --model is trained already")


def _check_options(ctx: click.Context, mode: str) -> None:
    of_mode = {"draws": "table", "repeats": "curve", "top": "errors"}
    for name, its_mode in of_mode.items():
        if mode != its_mode:
            _refuse(ctx, (name,), f"is for {DESCRIBED[its_mode]}")
    if mode == "curve":
        _refuse(ctx, ("model",), "can't go with --learning-curve, which trains models")
        _refuse(ctx, ("form",), "can't go with --learning-curve, which writes a plot and a CSV")
    if mode == "errors" and ctx.params["form"] in ("csv", "latex"):
        raise click.UsageError("--errors has the formats table and json.")


def _refuse(ctx: click.Context, names: tuple[str, ...], why: str) -> None:
    for parameter in ctx.command.params:
        if parameter.name in names and _is_given(ctx, parameter.name):
            raise click.UsageError(f"{parameter.opts[0]} {why}.")


# One function for each mode


def _table_1(
    choices: Choices, draws: int, form: Literal["table", "json", "csv", "latex"], *, terminal: bool
) -> str:
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
