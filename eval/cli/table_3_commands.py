"""``ct eval --table 3`` and ``--on-trial``: whether plans are right, and by which rules."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from corpus_tools.options.format_option import OUT, format_option, tell
from corpus_tools.options.model_options import ABLATE, L2
from corpus_tools.options.parallel_options import WORKERS
from corpus_tools.runtime.progress import progress_bar
from corpus_tools.runtime.terminal import note
from eval.cli.language_model_options import (
    NAME,
    judge_of,
    language_model_options,
    used_of,
)
from eval.cli.mode_options import (
    FOLLOWED,
    HELD_OUT,
    MOST,
    PERTURB,
    SEED,
    TRAIN,
    draws_option,
    form_options,
    is_terminal,
    write,
)

if TYPE_CHECKING:
    from corpus_tools.runtime.parallel import Workers
    from eval.language_model.chat_endpoint import Endpoint
    from eval.on_trial.ablation_runs import Clauses
    from eval.table_3.grounder_registry import PlanGrounder
    from eval.table_3.kept_outcomes import Kept
    from eval.tables.formats import Format


@click.command(
    "--table 3",
    short_help="Score plans for commands of held-out scenarios.",
    epilog="\b\nExamples:\n"
    "  ct eval --table 3 --judge automatic --train aaai11 --test aaai11\n"
    "  ct eval --table 3 --judge automatic --train aaai11,warehouse --test aaai11 --json --jobs 2\n"
    "  ct eval --table 3 --judge automatic --train aaai11 --test aaai11 --ablate last-goal\n"
    "  ct eval --table 3 --judge automatic --train aaai11,warehouse --test automatic "
    "--heading loads --heading loads+45 --heading loads-45\n"
    "  ct eval --table 3 --judge automatic --train aaai11 --test warehouse --perturb articles\n"
    "  ct eval --table 3 --judge automatic --train aaai11 --test warehouse --write-tasks form.jsonl"
    "\n"
    "  ct eval --table 3 --judge automatic --train aaai11 --test warehouse --plans mine.jsonl\n"
    "  ct eval --table 3 --judge automatic --train aaai11 --test warehouse --grounder llm "
    "--llm qwen2.5-7b --endpoint http://localhost:8000/v1",
)
@TRAIN
@FOLLOWED
@click.option(
    "--judge",
    metavar="NAME",
    required=True,
    help="Who says whether a plan is right: automatic, a program that compares it with the "
    "command's own log or outcome, and with its words; llm, a language model; or a judge of an "
    "installed package. People's ratings are shown by --table 2.",
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
    help="Add a row of the model with another parser, of an installed package (repeatable).",
)
@form_options(
    "--plans",
    "Add a row of plans that another program has made",
    "each command with its world, to be filled in",
)
@language_model_options
@HELD_OUT
@MOST
@click.option(
    "--heading",
    "headings",
    metavar="RULE",
    multiple=True,
    help="Which way robots face whose heading is assumed, such as loads, things or loads+30; "
    "give several for the mean over them [default: as imported].",
)
@PERTURB
@click.option(
    "--parses",
    type=click.IntRange(1, 20),
    default=3,
    show_default=True,
    help="How many SDC trees of each text to sum over, where the best one is not sure.",
)
@ABLATE
@L2
@SEED
@draws_option()
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
    most: int,
    headings: tuple[str, ...],
    perturb: tuple[str, ...],
    parses: int,
    ablate: tuple[str, ...],
    l2: float | None,
    seed: int,
    draws: int,
    form: Format,
    out: Path | None,
    workers: Workers,
) -> None:
    """Follow the commands of --test after learning from --train: Table 3 (section 4.3).

    Each scenario is held out when it is tested. --judge automatic says of each plan whether it ends
    where the command's log ends, or its outcome where there is no log. It also says whether the
    plan does what annotated words say. The table says how valid that is. Baselines without a model
    are rows of the table, and so are other grounders if you ask for them. With --out, scenarios
    that are done are kept beside the file until it is written, so that a run that was stopped goes
    on.
    """
    from corpus_tools import __version__
    from corpus_tools.importers.authored.bundled import open_corpus
    from eval.language_model.usage import in_words
    from eval.table_3.baselines import missing
    from eval.table_3.end_to_end import run, tasks_of
    from eval.table_3.given_plans import write_tasks
    from eval.table_3.plan_report import with_judge
    from g3.features.feature_registry import CATALOGUE_VERSION

    if tasks:
        count = write_tasks(tasks, tasks_of(open_corpus(test), headings, most))
        tell(form, {"file": tasks, "tasks": count}, f"wrote {tasks}: {count} tasks")
        return
    asked_judge, others = judge_of(judge, endpoint), _others(grounders, plans, endpoint)
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
        "missing": sorted(missing()),
        "judge": {judge: dict(asked_judge.about)},
        "grounders": {own.name: dict(own.about) for own in others},
        "parsers": list(parsers),
    }
    kept = _kept(out, settings)
    with progress_bar("reading corpora") as on_progress:
        result = run(
            train,
            test,
            grounders=others,
            parsers=tuple(dict.fromkeys(parsers)),
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
    used = used_of(endpoint, plans=NAME in grounders, judge=judge == NAME)
    if used:
        result = result.with_metadata({"language_model": used})
    corpora = (open_corpus(name) for name in (test, *train.split(",")))
    notes = [in_words(purpose, told) for purpose, told in used.items()]
    write(with_judge(result, corpora, draws=draws, seed=seed, notes=notes)(form), out)
    if kept:
        kept.path.unlink(missing_ok=True)


def _others(
    names: Sequence[str], plans: Sequence[Path], endpoint: Endpoint | None
) -> list[PlanGrounder]:
    """The grounders that are asked for besides, and files of plans as grounders."""
    from eval.language_model.model_answers import LanguageModelGrounder
    from eval.table_3.baselines import BASELINES
    from eval.table_3.given_plans import read_plans
    from eval.table_3.grounder_registry import grounder_named

    wanted = [name for name in dict.fromkeys(names) if name not in BASELINES]  # these are there
    found: list[PlanGrounder] = [
        LanguageModelGrounder(endpoint) if name == NAME and endpoint else grounder_named(name)
        for name in wanted
    ]
    return [*found, *(read_plans(file) for file in plans)]


def _kept(out: Path | None, settings: Mapping[str, object]) -> Kept | None:
    """What is kept of a run with a file, until that is written."""
    from eval.table_3.kept_outcomes import kept_beside

    kept = kept_beside(out, settings) if out else None
    if kept and kept.scenarios:
        note(f"ct: {len(kept.scenarios)} scenarios are done already: {kept.path}")
    return kept


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
    kept = _kept(out, settings)
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
