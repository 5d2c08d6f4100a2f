"""``ct eval table1``, ``learning-curve``, ``errors``: predicted correspondences."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import click

from corpus_tools.options import (
    FORMAT,
    OUT,
    TARGET,
    WORKERS,
    corpus_option,
    format_option,
    tell,
    training_options,
)
from corpus_tools.runtime.progress import progress_bar
from corpus_tools.runtime.terminal import note
from eval.cli import modes

if TYPE_CHECKING:
    from corpus_tools.corpus.labelled_corpus import Negatives
    from corpus_tools.runtime.parallel import Workers
    from eval.table_1.divided_examples import Choices
    from eval.tables.formats import Format

TRAINING = ("--ablate", "--with", "--l2")
OF_ONE_CORPUS = (
    modes.OptionSet(("--corpus",), ("--split", "--test-scenarios", *TRAINING)),
    modes.OptionSet(("--corpus", "--cv"), TRAINING),
)
APART = modes.OptionSet(("--train", "--test"), TRAINING)
TRAINED = modes.OptionSet(("--model", "--test"))

_SOURCES = (
    modes.DIVIDED,
    modes.BY_SCENARIO,
    modes.by_scenario("--split", help="Hold out some scenarios of --corpus (the default)."),
    click.option(
        "--test-scenarios",
        metavar="FILE|A,B,...",
        default="",
        help="Scenarios to hold out; a third drawn with --seed if left out.",
    ),
    corpus_option("--train", default="", help="Train on all of a corpus."),
    modes.TESTED,
)
_MODEL = click.option(
    "--model", type=click.Path(path_type=Path), help="Test a model of `ct train g3` on --test."
)
_TEST_NEGATIVES = click.option(
    "--test-negatives",
    type=click.Choice(["random", "hard"]),
    help="Test on other negatives than --negatives, which are then only trained on.",
)


def _trained_and_tested(
    *sets: modes.OptionSet,
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Add the options for training and test data; the command gets ``choices``."""

    def decorate(command: Callable[..., None]) -> Callable[..., None]:
        @wraps(command)
        def chosen(
            *,
            cv: str | None,
            split: str | None,
            corpus: str,
            train: str,
            test: str,
            test_scenarios: str,
            negatives: Negatives,
            test_negatives: Negatives | None,
            ablate: tuple[str, ...],
            plus: tuple[str, ...],
            l2: float | None,
            threshold: float,
            seed: int,
            model: Path | None = None,
            **options: Any,
        ) -> None:
            from eval.table_1.divided_examples import Choices

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
            return command(choices=choices, **options)

        added = modes.takes_one_of(*sets)(chosen)
        for option in (modes.SEED, modes.THRESHOLD, _TEST_NEGATIVES, training_options):
            added = option(added)
        if TRAINED in sets:
            added = _MODEL(added)
        for source in reversed(_SOURCES):
            added = source(added)
        return added

    return decorate


@click.command(
    "table1",
    short_help="Score predictions of the correspondence variable.",
    epilog="\b\nExamples:\n"
    "  ct eval table1 --corpus aaai11 --cv scenario\n"
    "  ct eval table1 --corpus aaai11 --split scenario --test-scenarios go_to_truck1,lift3\n"
    "  ct eval table1 --train aaai11 --test warehouse --json\n"
    "  ct eval table1 --model g3.npz --test warehouse --negatives hard\n"
    "  ct eval table1 --corpus aaai11 --cv scenario --ablate labels --format latex\n"
    "  ct eval table1 --corpus aaai11 --cv scenario --write-tasks form.jsonl\n"
    "  ct eval table1 --corpus aaai11 --cv scenario --predictions mine.jsonl",
)
@_trained_and_tested(*OF_ONE_CORPUS, APART, TRAINED)
@modes.form_options(
    "--predictions",
    "Show predictions of another program beside",
    "each tested clause with its groundings",
)
@modes.draws_option()
@format_option("csv", "latex", about="For people, for programs, or for a paper.")
@OUT
@WORKERS
def table_1(
    *,
    choices: Choices,
    predictions: tuple[Path, ...],
    tasks: Path | None,
    draws: int,
    form: Format,
    out: Path | None,
    workers: Workers,
) -> None:
    """Measure how well models predict whether SDCs match groundings: Table 1 (section 4.2).

    Choose the training and test data in one of three ways: one --corpus that is divided by scenario
    (--cv or --split), two corpora (--train and --test), or a trained --model and a --test corpus.
    Predictions of other programs are compared with the model's, example by example.
    """
    from corpus_tools.runtime.parallel import Executor
    from eval.table_1 import held_out_predictions
    from eval.table_1.correspondence import table_rows
    from eval.table_1.correspondence_table import render
    from eval.table_1.divided_examples import ablated
    from eval.table_1.given_predictions import OURS, compare_predictions, write_form

    if tasks:
        count = write_form(tasks, held_out_predictions.tested_examples(choices))
        tell(form, {"file": tasks, "tasks": count}, f"wrote {tasks}: {count} tasks")
        return
    _, rules = ablated(choices)
    if rules:
        note(
            f"ct: Table 1 makes no plans, so it is the same without {', '.join(sorted(rules))}; "
            "`ct eval table3` shows what potentials are worth"
        )
    with Executor(workers) as executor:
        with progress_bar("extracting features") as on_progress:
            result = held_out_predictions.run(choices, on_progress)
        by_model = {OURS: result.predictions, **held_out_predictions.given(predictions, result)}
        how: dict[str, Any] = {"threshold": choices.threshold, "draws": draws, "seed": choices.seed}
        rows, *others = (
            table_rows(probabilities, **how, executor=executor)
            for probabilities in by_model.values()
        )
    compared = compare_predictions(by_model, **how) if others else []
    metadata = {"table": 1, **result.metadata, "draws": draws}
    named = dict(zip(list(by_model)[1:], others, strict=True))
    if named:
        metadata["predictions"] = list(named)
    terminal = modes.is_terminal(out)
    modes.write(
        render(rows, form, metadata, others=named, compared=compared, terminal=terminal), out
    )


@click.command(
    "errors",
    short_help="List phrases that score high and low, by type.",
    epilog="\b\nExamples:\n"
    "  ct eval errors --corpus aaai11 --cv scenario --top 5\n"
    "  ct eval errors --model g3.npz --test warehouse --json",
)
@_trained_and_tested(*OF_ONE_CORPUS, APART, TRAINED)
@modes.TOP
@FORMAT
@OUT
def errors(*, choices: Choices, top: int, form: Literal["text", "json"], out: Path | None) -> None:
    """List the examples that score high and low, by the type of their SDC.

    Choose the training and test data as for table1.
    """
    from eval.table_1 import held_out_predictions
    from eval.table_1.error_lists import error_lists, render_lists

    with progress_bar("extracting features") as on_progress:
        result = held_out_predictions.run(choices, on_progress)
    lists = error_lists(result.predictions, result.shown, k=top, threshold=choices.threshold)
    metadata = {**result.metadata, "top": top}
    modes.write(render_lists(lists, form, metadata, terminal=modes.is_terminal(out)), out)


def _plot_file(_ctx: click.Context, _option: click.Parameter, out: Path) -> Path:
    if out.suffix.lower() not in (".png", ".svg", ".pdf"):
        raise click.UsageError("The curve needs --out FILE.png, FILE.svg or FILE.pdf.")
    return out


@click.command(
    "learning-curve",
    short_help="Plot the test error by the size of training.",
    epilog="\b\nExamples:\n"
    "  ct eval learning-curve --corpus aaai11 --out curve.png\n"
    "  ct eval learning-curve --train aaai11 --test warehouse --repeats 2 --out curve.svg",
)
@_trained_and_tested(*OF_ONE_CORPUS, APART)
@click.option(
    "--repeats",
    type=click.IntRange(min=1),
    default=5,
    show_default=True,
    help="Random orders of the commands.",
)
@FORMAT
@click.option(
    "--out",
    type=TARGET,
    required=True,
    callback=_plot_file,
    metavar="FILE.png|svg|pdf",
    help="Where the plot goes; a CSV with its numbers is written beside it.",
)
def learning_curve(*, choices: Choices, repeats: int, form: str, out: Path) -> None:
    """Plot how the test error falls as there is more to train on.

    Choose the training and test data as for table1.
    """
    from eval.table_1 import held_out_predictions
    from eval.table_1.learning_curve import write_csv, write_plot

    with progress_bar("extracting features") as on_progress:
        points, metadata = held_out_predictions.learning_curve(choices, repeats, on_progress)
    bounds = f"range of {repeats} random orders"
    write_csv(points, out.with_suffix(".csv"), metadata=metadata)
    write_plot(points, out, metadata=metadata, bounds=bounds)
    files = [out, out.with_suffix(".csv")]
    tell(form, {**metadata, "files": files}, f"wrote {files[0]} and {files[1]}")
