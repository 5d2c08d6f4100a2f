"""``ct eval table3``: the share of plans that are right."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from corpus_tools.options import ABLATE, L2, OUT, WORKERS, format_option, tell
from corpus_tools.runtime.progress import progress_bar
from corpus_tools.runtime.terminal import note
from eval.cli import modes

if TYPE_CHECKING:
    from corpus_tools.runtime.parallel import Workers
    from eval.language_model.chat_endpoint import Endpoint
    from eval.table_3.grounder_registry import PlanGrounder
    from eval.table_3.outcomes import Kept
    from eval.tables.formats import Format


@click.command(
    "table3",
    short_help="Score plans for commands of held-out scenarios.",
    epilog="\b\nExamples:\n"
    "  ct eval table3 --test aaai11\n"
    "  ct eval table3 --train aaai11,warehouse --test aaai11 --json --jobs 2\n"
    "  ct eval table3 --test aaai11 --ablate last-goal\n"
    "  ct eval table3 --train aaai11,warehouse --test automatic "
    "--heading loads --heading loads+45 --heading loads-45\n"
    "  ct eval table3 --train aaai11 --test warehouse --perturb articles\n"
    "  ct eval table3 --train aaai11 --test warehouse --write-tasks form.jsonl"
    "\n"
    "  ct eval table3 --train aaai11 --test warehouse --plans mine.jsonl\n"
    "  ct eval table3 --train aaai11 --test warehouse --grounder llm "
    "--llm qwen2.5-7b --endpoint http://localhost:8000/v1",
)
@modes.TRAIN
@modes.FOLLOWED
@click.option(
    "--judge",
    metavar="NAME",
    default="automatic",
    show_default=True,
    help="Judge of plans: automatic, a program that compares them with the "
    "command's own log or outcome, and with its words; llm, a language model; or a judge of an "
    "installed package. People's ratings are shown by table2.",
)
@click.option(
    "--grounder",
    "grounders",
    metavar="NAME",
    multiple=True,
    help="Add a row of another grounder: llm, or one of an installed package (repeatable).",
)
@click.option(
    "--parser",
    "parsers",
    metavar="NAME",
    multiple=True,
    help="Add a row of the model with another parser: llm, or one of an installed package "
    "(repeatable).",
)
@modes.form_options(
    "--plans",
    "Add a row of plans that another program has made",
    "each command with its world, to be filled in",
)
@modes.language_model_options
@modes.LLM_TREES
@modes.HELD_OUT
@modes.MOST
@click.option(
    "--heading",
    "headings",
    metavar="RULE",
    multiple=True,
    help="Which way robots face whose heading is assumed, such as loads, things or loads+30; "
    "give several for the mean over them [default: as imported].",
)
@modes.PERTURB
@click.option(
    "--parses",
    type=click.IntRange(1, 20),
    default=4,
    show_default=True,
    help="How many SDC trees of each text to sum over, where the best one is not sure.",
)
@ABLATE
@L2
@modes.VERBOSE
@modes.SEED
@modes.draws_option()
@format_option("csv", "latex", about="For people, for programs, for spreadsheets, for papers.")
@OUT
@WORKERS
def table_3(
    *,
    train: str,
    test: str,
    judge: str,
    grounders: tuple[str, ...],
    parsers: tuple[str, ...],
    plans: tuple[Path, ...],
    tasks: Path | None,
    endpoint: Endpoint | None,
    llm_trees: int,
    most: int,
    headings: tuple[str, ...],
    perturb: tuple[str, ...],
    parses: int,
    ablate: tuple[str, ...],
    l2: float | None,
    verbose: bool,
    seed: int,
    draws: int,
    form: Format,
    out: Path | None,
    workers: Workers,
) -> None:
    """Follow the commands of --test after learning from --train: Table 3 (section 4.3).

    Each scenario is held out when it is tested. --judge automatic compares the end of each
    plan with the end of the command's log, or with its outcome where there is no log. It also
    compares the plan with annotated words. The table shows the validity of both verdicts. Baselines
    without a model are rows of the table, and so are other grounders on request. With --out,
    finished scenarios are kept beside the file until it is written, so that an interrupted run can
    be resumed.
    """
    from corpus_tools import __version__
    from corpus_tools.importers.authored.bundled import open_corpus
    from eval.language_model.chat_endpoint import in_words
    from eval.table_3.baselines import missing
    from eval.table_3.end_to_end import run, tasks_of
    from eval.table_3.following import CONFIGURATIONS
    from eval.table_3.given_plans import write_tasks
    from eval.table_3.plan_report import with_judge
    from g3.features.feature_registry import CATALOGUE_VERSION

    train = train or test
    if tasks:
        count = write_tasks(tasks, tasks_of(open_corpus(test), headings, most))
        tell(form, {"file": tasks, "tasks": count}, f"wrote {tasks}: {count} tasks")
        return
    asked_judge, others = modes.judge_of(judge, endpoint), _others(grounders, plans, endpoint)
    parsed_by = [modes.parser_of(name, endpoint, llm_trees) for name in dict.fromkeys(parsers)]
    strength = l2 or 1.0
    settings = {
        "corpora": [open_corpus(name).hash for name in (*train.split(","), test)],
        "program": __version__,
        "features": CATALOGUE_VERSION,
        "l2": strength,
        "seed": seed,
        "ablate": sorted(set(ablate)),
        "headings": list(headings),
        "perturb": list(perturb),
        "parses": parses,
        "most": most,
        "rows": list(CONFIGURATIONS),
        "missing": sorted(missing()),
        "judge": {judge: dict(asked_judge.about)},
        "grounders": {grounder.name: dict(grounder.about) for grounder in others},
        "parsers": [parser.name for parser in parsed_by],
        "parsed_by": {parser.name: dict(parser.about) for parser in parsed_by if parser.about},
    }
    kept = _kept(out, settings)
    with progress_bar("reading corpora") as on_progress:
        result = run(
            train,
            test,
            grounders=others,
            parsers=parsed_by,
            judge=asked_judge,
            l2=strength,
            seed=seed,
            ablate=ablate,
            headings=headings,
            perturb=perturb,
            parses=parses,
            most=most,
            done=kept.scenarios if kept else {},
            on_scenario=kept.keep if kept else None,
            workers=workers,
            on_progress=on_progress,
        )
    used = modes.used_of(
        endpoint,
        plans=modes.NAME in grounders,
        parses=modes.NAME in parsers,
        judge=judge == modes.NAME,
    )
    if used:
        result = result.with_metadata({"language_model": used})
    corpora = (open_corpus(name) for name in (test, *train.split(",")))
    notes = [in_words(purpose, used_model) for purpose, used_model in used.items()]
    modes.write(
        with_judge(result, corpora, draws=draws, seed=seed, notes=notes, verbose=verbose)(form), out
    )
    if kept:
        kept.path.unlink(missing_ok=True)


def _others(
    names: Sequence[str], plans: Sequence[Path], endpoint: Endpoint | None
) -> list[PlanGrounder]:
    """Return the additional grounders, by name and as files of plans."""
    from eval.language_model.model_answers import LanguageModelGrounder
    from eval.table_3.baselines import BASELINES
    from eval.table_3.given_plans import read_plans
    from eval.table_3.grounder_registry import grounder_named

    others = [name for name in dict.fromkeys(names) if name not in BASELINES]  # these are there
    result: list[PlanGrounder] = [
        LanguageModelGrounder(endpoint) if name == modes.NAME and endpoint else grounder_named(name)
        for name in others
    ]
    return [*result, *(read_plans(file) for file in plans)]


def _kept(out: Path | None, settings: Mapping[str, object]) -> Kept | None:
    """Return the results that an interrupted run kept beside its output file, if there are any."""
    from eval.table_3.outcomes import kept_beside

    kept = kept_beside(out, settings) if out else None
    if kept and kept.scenarios:
        note(f"ct: {len(kept.scenarios)} scenarios are done already: {kept.path}")
    return kept
