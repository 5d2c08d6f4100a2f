"""``ct eval table2``, ``judge-validity`` and ``power``: people's ratings of videos."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from corpus_tools.options.corpus_name import corpus_option
from corpus_tools.options.format_option import FORMAT, OUT, format_option
from corpus_tools.options.parallel_options import WORKERS
from eval.cli.modes import (
    SEED,
    STUDY,
    VERBOSE,
    draws_option,
    is_terminal,
    judge_of,
    language_model_options,
    used_of,
    write,
)

if TYPE_CHECKING:
    from corpus_tools.runtime.parallel import Workers
    from eval.language_model.chat_endpoint import Endpoint
    from eval.tables.formats import Format

FORMATS = format_option("csv", "latex", about="For people, for programs, or for a paper.")


@click.command(
    "table2",
    short_help="Show how often people agree that a video fits.",
    epilog="\b\nExamples:\n  ct eval table2\n  ct eval table2 --corpus aaai11 --models --json",
)
@corpus_option(
    "--corpus",
    default="warehouse-simulated-ratings",
    show_default=True,
    help="The corpus with ratings; those of the default are simulated.",
)
@STUDY
@click.option(
    "--models",
    is_flag=True,
    help="Fit estimating equations and a cumulative-link model too (extra: study).",
)
@VERBOSE
@SEED
@draws_option(10_000)
@FORMATS
@OUT
@WORKERS
def table_2(
    *,
    corpus: str,
    study: str,
    models: bool,
    verbose: bool,
    seed: int,
    draws: int,
    form: Format,
    out: Path | None,
    workers: Workers,
) -> None:
    """Show how often people agree that a video shows a command: Table 2 (section 4.1).

    The ratings are those in --corpus.
    """
    from corpus_tools.importers.authored.bundled import open_corpus
    from corpus_tools.runtime.parallel import Executor
    from eval.statistics.ratings import check_judgments
    from eval.table_2.rating_shares import table_2 as make
    from eval.table_2.rating_table import render

    rated = open_corpus(corpus)
    check_judgments(rated.judgments, {command.video for command in rated.commands.values()})
    with Executor(workers) as executor:
        results = make(
            rated.judgments, study=study, models=models, seed=seed, draws=draws, executor=executor
        )
    metadata = {"table": 2, "corpus": corpus, "seed": seed, "draws": draws}
    text = render(results, form, metadata, verbose=verbose, terminal=is_terminal(out))
    write(text, out)


@click.command(
    "judge-validity",
    short_help="Compare the automatic judge with people.",
    epilog="\b\nExamples:\n"
    "  ct eval judge-validity --corpus aaai11\n"
    "  ct eval judge-validity --corpus aaai11 --json\n"
    "  ct eval judge-validity --corpus aaai11 --judge llm --llm qwen2.5-7b "
    "--endpoint http://localhost:8000/v1",
)
@corpus_option("--corpus", required=True, help="The corpus with people's ratings.")
@STUDY
@click.option(
    "--judge",
    metavar="NAME",
    default="automatic",
    show_default=True,
    help="Compare this judge as well: llm, or one of an installed package.",
)
@language_model_options
@SEED
@draws_option()
@FORMAT
@OUT
@WORKERS
def judge_validity(
    *,
    corpus: str,
    study: str,
    judge: str,
    endpoint: Endpoint | None,
    seed: int,
    draws: int,
    form: Literal["text", "json"],
    out: Path | None,
    workers: Workers,
) -> None:
    """Compare the automatic judge with people on the same videos.

    With --judge another judge is compared with people on the same pairs.
    """
    from corpus_tools.importers.authored.bundled import open_corpus
    from corpus_tools.runtime.parallel import Executor
    from eval.judging.judge_registry import AUTOMATIC
    from eval.judging.judge_report import render
    from eval.judging.judge_validity import judge_validity as compare

    other = None if judge == AUTOMATIC else judge_of(judge, endpoint)
    with Executor(workers) as executor:
        result = compare(
            open_corpus(corpus),
            study=study,
            seed=seed,
            draws=draws,
            other=other,
            executor=executor,
        )
    metadata: dict[str, object] = {"corpus": corpus, "seed": seed, "draws": draws}
    if other:
        metadata["other_judge"] = {other.name: dict(other.about)}
    used = used_of(endpoint, judge=True)
    if used:
        metadata["language_model"] = used
    write(render(result, form, metadata, terminal=is_terminal(out)), out)


@click.command(
    "power",
    short_help="Say how many ratings a study needs.",
    epilog="\b\nExamples:\n"
    "  ct eval power --half-width 0.02\n"
    "  ct eval power --half-width 0.02 --corpus aaai11",
)
@click.option(
    "--half-width",
    type=click.FloatRange(0.001, 0.5),
    default=0.03,
    show_default=True,
    help="Half the width of the interval to plan for.",
)
@corpus_option("--corpus", default="", help="Expect ratings like those in this corpus.")
@SEED
@FORMATS
@OUT
def power(*, half_width: float, corpus: str, seed: int, form: Format, out: Path | None) -> None:
    """Show the pairs and ratings that a study needs for an interval of a given width."""
    from corpus_tools.importers.authored.bundled import open_corpus
    from eval.statistics.ratings import judged_by, of_study
    from eval.table_2.power_plans import assumptions, plans, render

    judgments = open_corpus(corpus).judgments if corpus else None
    share, correlation = assumptions(judgments)
    metadata = {
        "corpus": corpus or "none",
        **({"judged_by": judged_by(of_study(judgments)[0].study)} if judgments else {}),
        "wanted_half_width": half_width,
        "share": round(share.value, 3),
        "correlation": round(correlation.value, 3),
        **{
            f"{name}_reason": one.reason
            for name, one in (("share", share), ("correlation", correlation))
            if one.reason
        },
        "seed": seed,
    }
    rows = plans(half_width, share, correlation, seed)
    write(render(rows, form, metadata, terminal=is_terminal(out)), out)
