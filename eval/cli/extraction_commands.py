"""``ct eval sdc``: scores of extracted SDC trees."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from corpus_tools.options.corpus_name import corpus_option
from corpus_tools.options.format_option import FORMAT, OUT
from corpus_tools.options.model_options import L2
from corpus_tools.runtime.progress import progress_bar
from corpus_tools.runtime.terminal import note
from eval.cli.modes import (
    DIVIDED,
    PERTURB,
    SEED,
    TESTED,
    OptionSet,
    is_terminal,
    language_model_options,
    parser_of,
    takes_one_of,
    used_of,
    write,
)

if TYPE_CHECKING:
    from corpus_tools.corpus.corpus_model import Division
    from eval.language_model.chat_endpoint import Endpoint


@click.command(
    "sdc",
    short_help="Score the extraction of SDC trees from text.",
    epilog="\b\nExamples:\n"
    "  ct eval sdc --corpus aaai11 --cv scenario\n"
    "  ct eval sdc --corpus aaai11 --cv scenario --train warehouse\n"
    "  ct eval sdc --corpus treebank --cv world\n"
    "  ct eval sdc --test warehouse --train aaai11 --json\n"
    "  ct eval sdc --test aaai11 --model sdc.npz\n"
    "  ct eval sdc --test aaai11 --parser verb-object\n"
    "  ct eval sdc --test aaai11 --parser llm --llm qwen2.5-7b "
    "--endpoint http://localhost:8000/v1\n"
    "  ct eval sdc --test warehouse --train aaai11 --perturb articles --perturb typos",
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
@click.option(
    "--cv",
    type=click.Choice(["scenario", "person", "world"]),
    help="Leave out each scenario of --corpus in turn, or the commands of each person or world.",
)
@corpus_option(
    "--train",
    default="",
    help="Train on all of a corpus; with --corpus, in addition to its other parts.",
)
@TESTED
@click.option(
    "--model", type=click.Path(path_type=Path), help="Test a model of `ct train parser` on --test."
)
@click.option(
    "--parser",
    metavar="NAME",
    default="",
    help="Test another parser on --test: llm, or one of an installed package.",
)
@language_model_options
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
    cv: Division | None,
    train: str,
    test: str,
    model: Path | None,
    parser: str,
    endpoint: Endpoint | None,
    l2: float | None,
    perturb: tuple[str, ...],
    seed: int,
    top: int,
    form: Literal["text", "json"],
    out: Path | None,
) -> None:
    """Measure the accuracy of SDC trees extracted from text (section 3.1).

    Choose the test data in one of three ways: --corpus with --cv (and --train for another
    corpus to learn from); --test with --train, --model or --parser; or --test alone for the
    bundled parser. --perturb adds the same commands as other people may type them.
    """
    from eval.language_model.chat_endpoint import in_words
    from eval.parsing.sdc_scores import SDCChoices, render, run

    another = parser_of(parser, endpoint) if parser else None
    choices = SDCChoices(corpus, train, test, model, another, l2, perturb, seed, cv or "scenario")
    with progress_bar("analysing commands") as on_progress:
        tested, metadata = run(choices, on_progress)
    if metadata.get("seen_scenarios"):
        note(
            "ct: the model was trained on scenarios that are tested; "
            "--corpus with --cv scenario holds them out"
        )
    for purpose, used in used_of(endpoint, parses=True).items():
        metadata |= {"language_model": {purpose: used}}
        note(in_words(purpose, used))
    write(render(tested, form, metadata, top=top, terminal=is_terminal(out)), out)
