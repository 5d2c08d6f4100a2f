"""``ct eval --sdc``: scores of extracted SDC trees."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import click

from corpus_tools.options.format_option import FORMAT, OUT
from corpus_tools.options.model_options import L2
from corpus_tools.runtime.progress import progress_bar
from corpus_tools.runtime.terminal import note
from eval.cli.mode_options import (
    BY_SCENARIO,
    DIVIDED,
    PERTURB,
    SEED,
    TESTED,
    is_terminal,
    write,
)
from eval.cli.modes import OptionSet, takes_one_of


@click.command(
    "--sdc",
    short_help="Score the extraction of SDC trees from text.",
    epilog="\b\nExamples:\n"
    "  ct eval --sdc --corpus aaai11 --cv scenario\n"
    "  ct eval --sdc --corpus aaai11 --cv scenario --train warehouse\n"
    "  ct eval --sdc --test warehouse --train aaai11 --json\n"
    "  ct eval --sdc --test aaai11 --model sdc.npz\n"
    "  ct eval --sdc --test aaai11 --parser verb-object\n"
    "  ct eval --sdc --test warehouse --train aaai11 --perturb articles --perturb typos",
)
@takes_one_of(
    OptionSet(("--corpus", "--cv"), ("--l2",)),
    OptionSet(("--corpus", "--cv", "--train"), ("--l2",)),
    OptionSet(("--test", "--train"), ("--l2",)),
    OptionSet(("--test", "--model")),
    OptionSet(("--test", "--parser")),
    OptionSet(("--test",)),
)
@DIVIDED
@BY_SCENARIO
@click.option(
    "--train",
    metavar="CORPUS",
    default="",
    help="Train on all of a corpus; with --corpus, besides its other scenarios.",
)
@TESTED
@click.option(
    "--model", type=click.Path(path_type=Path), help="Test a model of `ct train sdc` on --test."
)
@click.option(
    "--parser", metavar="NAME", default="", help="Test a parser of an installed package on --test."
)
@L2
@PERTURB
@SEED
@click.option(
    "--top",
    type=click.IntRange(min=1),
    default=10,
    show_default=True,
    help="How many commands to list.",
)
@FORMAT
@OUT
def sdc(
    *,
    corpus: str,
    cv: str | None,
    train: str,
    test: str,
    model: Path | None,
    parser: str,
    l2: float | None,
    perturb: tuple[str, ...],
    seed: int,
    top: int,
    form: Literal["text", "json"],
    out: Path | None,
) -> None:
    """Measure the accuracy of SDC trees extracted from text (section 3.1).

    Choose the test data in one of three ways: --corpus with --cv scenario (and --train for another
    corpus to learn from); --test with --train, --model or --parser; or --test alone for the
    bundled extractor. --perturb adds the same commands as other people may type them.
    """
    from eval.parsing.sdc_report import render
    from eval.parsing.tested_commands import SDCChoices, run

    choices = SDCChoices(corpus, train, test, model, parser, l2, perturb, seed)
    with progress_bar("analysing commands") as on_progress:
        tested, metadata = run(choices, on_progress)
    if metadata.get("seen_scenarios"):
        note(
            "ct: the model was trained on scenarios that are tested; "
            "--corpus with --cv scenario holds them out"
        )
    write(render(tested, form, metadata, top=top, terminal=is_terminal(out)), out)
