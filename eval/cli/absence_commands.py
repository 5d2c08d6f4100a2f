"""``ct eval --absent``: how often it is seen that a thing isn't there."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import click

from corpus_tools.options.format_option import FORMAT
from corpus_tools.runtime.progress import progress_bar
from eval.cli.mode_options import OUT, SEED, is_terminal, write


@click.command(
    "--absent",
    short_help="Count alarms about what isn't there, right and false.",
    epilog="\b\nExamples:\n"
    "  ct eval --absent --corpus warehouse\n"
    "  ct eval --absent --corpus warehouse,aaai11,automatic --json",
)
@click.option(
    "--corpus", metavar="CORPUS,...", required=True, help="The corpora whose commands are given."
)
@SEED
@FORMAT
@OUT
def absent(*, corpus: str, seed: int, form: Literal["text", "json"], out: Path | None) -> None:
    """Measure how often "I see no truck here" is the answer, where it is right and where not.

    Each command is given in its own world, in that world without what it means, and nouns of
    WordNet are asked for. Scenarios are held out from what is learned of words.
    """
    from corpus_tools.importers.authored.bundled import open_corpus
    from eval.absence.absence_evidence import absence_evidence
    from eval.absence.absence_report import render

    corpora = [open_corpus(name) for name in corpus.split(",")]
    with progress_bar("looking for what isn't there") as on_progress:
        evidence = absence_evidence(corpora, seed, on_progress)
    metadata = {"corpora": {c.name: c.hash for c in corpora}, "seed": seed}
    write(render(evidence, form, metadata, terminal=is_terminal(out)), out)
