"""``ct simulate-workers``: simulated commands and ratings, for studies of load and scale."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from corpus_tools.options import FORMAT, WORKERS, out_folder, tell, with_default
from corpus_tools.runtime.terminal import note

if TYPE_CHECKING:
    from corpus_tools.runtime.parallel import Workers

SEED = with_default("--seed", default=0, type=click.IntRange(min=0), help="Seed of all chance.")
COUNT = click.IntRange(min=1)


@click.group("simulate-workers")
def simulate_workers() -> None:
    """Simulate workers who type commands and rate videos.

    Use it only to study load, scale and power. All that is made is labelled simulated. A figure
    that was measured on it says nothing about people. docs/simulation.md has the models.

    \b
    Example:
      ct simulate-workers describe --scenarios 20 --commands 10 --out simulated
    """


@simulate_workers.command()
@with_default("--scenarios", default=20, type=COUNT, help="How many, at random.")
@with_default("--commands", default=10, type=COUNT, help="How many a scenario.")
@with_default("--workers", "typists", default=45, type=COUNT, help="How many type them.")
@SEED
@with_default("--dataset", default="warehouse", help="Folder or name of a dataset with layouts.")
@out_folder("Folder of the new dataset.")
@WORKERS
@FORMAT
def describe(
    *,
    scenarios: int,
    commands: int,
    typists: int,
    seed: int,
    dataset: str,
    out: Path,
    workers: Workers,
    form: str,
) -> None:
    """Write a dataset of random scenarios with simulated commands.

    The scenarios are executed in physics; the commands have trees and groundings.

    It can be named wherever a corpus is taken. The same options give the same files, more
    scenarios change none of the others, and an interrupted run resumes where it stopped. Scenarios
    that the robot fails at are left out and named, and the exit status is 2 then.

    \b
    Examples:
      ct simulate-workers describe --out simulated
      ct simulate-workers describe --scenarios 1000 --commands 40 --seed 7 --out simulated --jobs 4
      ct eval table1 --corpus simulated --cv scenario
    """
    from corpus_tools.runtime.progress import progress_bar
    from corpus_tools.video.drawing.gl import check_packages

    check_packages()
    from corpus_tools.simulation.dataset import Plan, write_dataset
    from corpus_tools.world.scenarios.scenario_reading import dataset_folder

    plan = Plan(scenarios, commands, typists, seed)
    with progress_bar("simulating") as on_progress:
        failures = write_dataset(
            plan,
            out,
            dataset_folder(dataset),
            workers=workers,
            on_progress=on_progress,
        )
    done = scenarios - len(failures)
    record = {
        "folder": out,
        "scenarios": done,
        "commands": done * commands,
        "failed": [str(failure) for failure in failures],
    }
    tell(form, record, f"simulated {done * commands} commands for {done} scenarios in {out}")
    for failure in failures:
        note(f"ct: {failure}")
    if failures:
        click.get_current_context().exit(2)


@simulate_workers.command()
@click.option("--corpus", required=True, help="Whose commands and videos are rated.")
@with_default("--raters", default=45, type=COUNT, help="How many there are.")
@with_default("--judgments", default=5, type=COUNT, help="How many a pair.")
@SEED
@out_folder("Folder of the new corpus.")
@FORMAT
def rate(*, corpus: str, raters: int, judgments: int, seed: int, out: Path, form: str) -> None:
    """Write a corpus with simulated judgments.

    Each command is rated with its own video and with another one.

    The corpus's own judgments are not kept, so that simulated ones are never among people's.

    \b
    Examples:
      ct simulate-workers rate --corpus warehouse --out rated
      ct eval table2 --corpus rated
    """
    from corpus_tools.corpus.corpus_model import Corpus
    from corpus_tools.importers.authored.bundled import open_corpus
    from corpus_tools.simulation.simulated_raters import with_simulated_ratings

    Corpus.check_target(out)
    made = with_simulated_ratings(
        open_corpus(corpus), raters=raters, judgments=judgments, seed=seed
    )
    made.save(out)
    given = made.judgments
    record = {"folder": out, "judgments": len(given)}
    tell(form, record, f"simulated {len(given)} judgments in {out}")
