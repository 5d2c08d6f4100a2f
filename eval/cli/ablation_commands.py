"""``ct eval --on-trial``: what each rule and feature set wins and loses in each corpus."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from corpus_tools.options.format_option import format_option
from corpus_tools.options.model_options import L2
from corpus_tools.options.parallel_options import WORKERS
from corpus_tools.runtime.progress import progress_bar
from corpus_tools.runtime.terminal import note
from eval.cli.mode_options import MOST, OUT, SEED, TRAIN, is_terminal, write

if TYPE_CHECKING:
    from corpus_tools.runtime.parallel import Workers
    from eval.on_trial.ablation_runs import Clauses
    from eval.tables.formats import Format


def _several(_ctx: click.Context, option: click.Parameter, value: str) -> tuple[str, ...]:
    names = tuple(dict.fromkeys(name for name in value.split(",") if name))
    if not names:
        raise click.BadParameter("name a corpus", param=option)
    return names


@click.command(
    "--on-trial",
    short_help="Switch each rule off in turn, on several corpora.",
    epilog="\b\nExamples:\n"
    "  ct eval --on-trial --train aaai11,warehouse --test aaai11,warehouse --jobs 2\n"
    "  ct eval --on-trial --train aaai11,warehouse --test aaai11,automatic "
    "--potential side --potential ordinal --out trial.json --json\n"
    "  ct eval --on-trial --train aaai11,warehouse --test warehouse --feature-set labels",
)
@TRAIN
@click.option(
    "--test",
    metavar="CORPUS,...",
    required=True,
    callback=_several,
    help="Follow the commands of these corpora, each by itself.",
)
@click.option(
    "--potential",
    "potential_names",
    metavar="NAME",
    multiple=True,
    help="Try this potential only (repeatable) [default: all].",
)
@click.option(
    "--feature-set",
    "set_names",
    metavar="NAME",
    multiple=True,
    help="Try this feature set (repeatable). Each means learning anew.",
)
@click.option(
    "--feature-sets",
    "all_sets",
    is_flag=True,
    help="Try all feature sets too, which takes long: each means learning anew.",
)
@click.option(
    "--clauses",
    type=click.Choice(["gold", "auto"]),
    default="gold",
    show_default=True,
    help="Annotated clauses where there are some, or always extracted ones.",
)
@MOST
@L2
@SEED
@format_option("csv", about="For people, for programs, or for spreadsheets.")
@OUT
@WORKERS
def ablations(
    *,
    train: str,
    test: tuple[str, ...],
    potential_names: tuple[str, ...],
    set_names: tuple[str, ...],
    all_sets: bool,
    clauses: Clauses,
    most: int,
    l2: float | None,
    seed: int,
    form: Format,
    out: Path | None,
    workers: Workers,
) -> None:
    """Switch each potential off in turn, and show what it wins and loses in each test corpus.

    A command is won if its plan is right with the potential and wrong without it. What helps only
    in the corpus that it was invented for shows. Each scenario is held out when it is tested, and
    plans are judged by the automatic judge, as in Table 3. All potentials are tried unless you
    name what to try; feature sets only if you ask, since each means learning anew. With --out,
    scenarios that are done are kept beside the file until it is written, so that a run that was
    stopped goes on.
    """
    from corpus_tools import __version__
    from corpus_tools.importers.authored.bundled import open_corpus
    from eval.on_trial.ablation_report import render, rows
    from eval.on_trial.ablation_runs import Ablations, on_trial, run
    from eval.table_3.kept_outcomes import kept_beside
    from g3.features.feature_registry import CATALOGUE_VERSION

    potentials, sets = on_trial(potential_names, set_names, all_sets=all_sets)
    asked = Ablations(
        tuple(train.split(",")), test, potentials, sets, clauses, l2 or 1.0, seed, most
    )
    hashes = {name: open_corpus(name).hash for name in (*asked.train, *asked.test)}
    settings = {
        "program": __version__,
        "features": CATALOGUE_VERSION,
        "corpora": hashes,
        **{key: list(v) if isinstance(v, tuple) else v for key, v in asdict(asked).items()},
    }
    kept = kept_beside(out, settings) if out else None
    if kept and kept.scenarios:
        note(f"ct: {len(kept.scenarios)} scenarios are done already: {kept.path}")
    with progress_bar("reading corpora") as on_progress:
        outcomes = run(
            asked,
            done=kept.scenarios if kept else {},
            on_part=kept.keep if kept else None,
            workers=workers,
            on_progress=on_progress,
        )
    metadata = {
        "judge": "automatic",
        "protocol": "each scenario held out in turn",
        "clauses": clauses,
        "train": [hashes[name] for name in asked.train],
        "test": [hashes[name] for name in asked.test],
        "l2": asked.l2,
        "seed": seed,
        "most": most,
    }
    found = rows(outcomes, asked.candidates)
    write(render(found, form, metadata, terminal=is_terminal(out)), out)
    if kept:
        kept.path.unlink(missing_ok=True)
