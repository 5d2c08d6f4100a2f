"""``ct eval``: its commands, of which ``sdc`` and ``report`` are here."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import click

from corpus_tools.options import (
    FORMAT,
    L2,
    NEGATIVES,
    OUT,
    TARGET_FOLDER,
    ExistingPath,
    corpus_option,
    tell,
)
from corpus_tools.runtime.progress import progress_bar
from corpus_tools.runtime.terminal import note
from eval.cli import modes
from eval.cli.prediction_commands import errors, learning_curve, table_1
from eval.cli.rating_commands import end_to_end, judge_validity, power, table_2
from eval.cli.step_commands import subtasks
from eval.cli.table_3_commands import table_3

if TYPE_CHECKING:
    from corpus_tools.corpus.corpus_model import Division
    from eval.language_model.chat_endpoint import Endpoint


@click.command(
    "report",
    short_help="Write all results of a corpus on one page.",
    epilog="\b\nExamples:\n"
    "  ct eval report report --corpus aaai11\n"
    "  ct eval report report --corpus aaai11 --plans table-3.json --videos videos\n"
    "  ct eval report report --corpus aaai11 --plans new-worlds.json --plans table-3.json",
)
@click.argument("folder", metavar="FOLDER", type=TARGET_FOLDER)
@corpus_option("--corpus", required=True, help="The corpus to measure.")
@modes.HELD_OUT
@click.option(
    "--plans",
    type=ExistingPath(dir_okay=False),
    multiple=True,
    help="The JSON of table3, or of end-to-end without --plans, to show in the report "
    "(repeatable; corpora that weren't learned from come first).",
)
@click.option(
    "--videos",
    type=ExistingPath(file_okay=False),
    help="What `ct render-videos` has made, to show some in the report.",
)
@modes.STUDY
@NEGATIVES
@L2
@modes.THRESHOLD
@modes.SEED
@modes.draws_option()
@modes.TOP
@click.option(
    "--repeats",
    type=click.IntRange(min=0),
    default=5,
    show_default=True,
    help="Random orders of the commands for the learning curve; 0 leaves it out.",
)
@FORMAT
def report(*, folder: Path, form: str, **choices: Any) -> None:
    """Measure a corpus with each scenario held out in turn, and write all of it on one page.

    The page, report.html, goes into FOLDER, with its plots as SVG and PDF, and its figures as JSON,
    CSV and LaTeX. A report that is there already is replaced.
    """
    from eval.report.report_contents import ReportChoices, gather
    from eval.report.report_page import check_writable, write_report

    check_writable(folder)
    with progress_bar("extracting features") as on_progress:
        contents = gather(ReportChoices(**choices), on_progress)
    names = write_report(contents, folder)
    count = f"wrote {len(names)} files to {folder}"
    record = {"folder": folder, "files": list(names)}
    tell(form, record, f"{count}; open {folder / 'report.html'} in a browser")


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
@modes.takes_one_of(
    modes.OptionSet(("--corpus", "--cv"), ("--l2",)),
    modes.OptionSet(("--corpus", "--cv", "--train"), ("--l2",)),
    modes.OptionSet(("--test", "--train"), ("--l2",)),
    modes.OptionSet(("--test", "--model")),
    modes.OptionSet(("--corpus", "--cv", "--parser"), ("--llm-trees",)),
    modes.OptionSet(("--test", "--train", "--parser"), ("--llm-trees",)),
    modes.OptionSet(("--test", "--parser"), ("--llm-trees",)),
    modes.OptionSet(("--test",)),
)
@modes.DIVIDED
@modes.by_scenario(
    "--cv",
    "person",
    "world",
    help="Leave out each scenario of --corpus in turn, or the commands of each person or world.",
)
@corpus_option(
    "--train",
    default="",
    help="Train on all of a corpus; with --corpus, in addition to its other parts.",
)
@modes.TESTED
@click.option(
    "--model", type=click.Path(path_type=Path), help="Test a model of `ct train parser` on --test."
)
@click.option(
    "--parser",
    metavar="NAME",
    default="",
    help="Test another parser: llm, or one of an installed package. It may learn from the other "
    "parts of --corpus, or from --train.",
)
@modes.language_model_options
@modes.LLM_TREES
@L2
@modes.PERTURB
@modes.SEED
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
    llm_trees: int,
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

    another = modes.parser_of(parser, endpoint, llm_trees) if parser else None
    choices = SDCChoices(corpus, train, test, model, another, l2, perturb, seed, cv or "scenario")
    with progress_bar("analysing commands") as on_progress:
        tested, metadata = run(choices, on_progress)
    if metadata.get("seen_scenarios"):
        note(
            "ct: the model was trained on scenarios that are tested; "
            "--corpus with --cv scenario holds them out"
        )
    for purpose, used in modes.used_of(endpoint, parses=True).items():
        metadata |= {"language_model": {purpose: used}}
        note(in_words(purpose, used))
    modes.write(render(tested, form, metadata, top=top, terminal=modes.is_terminal(out)), out)


evaluate = modes.Modes(
    "eval",
    commands=[
        table_1,
        table_2,
        table_3,
        learning_curve,
        errors,
        sdc,
        end_to_end,
        judge_validity,
        report,
        power,
        subtasks,
    ],
    help="""Measure models and plans: the paper's tables, and more.

    Each command has options of its own: see `ct eval table1 --help`.
    """,
    options_metavar="",
    epilog="\b\nExamples:\n"
    "  ct eval table1 --corpus aaai11 --cv scenario\n"
    "  ct eval table2\n"
    "  ct eval table3 --test aaai11\n"
    "  ct eval table3 --help",
)
