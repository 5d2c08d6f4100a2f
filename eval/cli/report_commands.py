"""``ct eval report``: all measurements of a corpus, on one page."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from corpus_tools.options.corpus_name import corpus_option
from corpus_tools.options.format_option import FORMAT, TARGET_FOLDER, tell
from corpus_tools.options.model_options import L2, NEGATIVES
from corpus_tools.runtime.progress import progress_bar
from eval.cli.modes import HELD_OUT, SEED, STUDY, THRESHOLD, TOP, draws_option


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
@HELD_OUT
@click.option(
    "--plans",
    type=click.Path(path_type=Path, dir_okay=False, exists=True),
    multiple=True,
    help="The JSON of table3, or of end-to-end without --plans, to show in the report "
    "(repeatable; corpora that weren't learned from come first).",
)
@click.option(
    "--videos",
    type=click.Path(path_type=Path, file_okay=False, exists=True),
    help="What `ct render-videos` has made, to show some in the report.",
)
@STUDY
@NEGATIVES
@L2
@THRESHOLD
@SEED
@draws_option()
@TOP
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
