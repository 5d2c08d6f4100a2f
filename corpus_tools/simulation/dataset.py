"""Writing of simulated workers' commands as a dataset, which is a corpus wherever one is taken."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path

import numpy as np

from corpus_tools.importers.authored.authored_corpus import clause_names
from corpus_tools.importers.authored.authored_files import read_dataset
from corpus_tools.importers.report import Journal
from corpus_tools.runtime.parallel import WorkerDiedError, Workers, work
from corpus_tools.runtime.progress import OnProgress, no_progress
from corpus_tools.runtime.shipped import DATASET
from corpus_tools.simulation.grammar import Told, Worker, draw_workers, see, tell
from corpus_tools.world.scenarios.execution import log_scenario
from corpus_tools.world.scenarios.random_scenarios import generate
from corpus_tools.world.scenarios.scenario import Layout, Scenario
from corpus_tools.world.scenarios.scenario_files import LAYOUTS, SCENARIOS, format_scenario
from corpus_tools.world.scenarios.scenario_logs import is_logged
from corpus_tools.world.scenarios.scenario_reading import read_layouts
from g3.errors import CorpusError, FormatError
from g3.sdc.clauses import breadth_first
from g3.sdc.sdc_notation import format_brackets
from g3.storage.atomic_file import write_bytes

SOURCE = "Simulated: written by a grammar for random scenarios, by nobody. See docs/simulation.md."


@dataclass(frozen=True, slots=True)
class Plan:
    """Size and seed of a simulation; the same plan gives the same files."""

    scenarios: int
    """Number of scenarios, and of videos."""
    commands: int
    """Number of commands for each scenario, by different workers."""
    workers: int
    seed: int


def write_dataset(
    plan: Plan,
    out: Path,
    basis: Path,
    *,
    workers: Workers | None = None,
    on_progress: OnProgress = no_progress,
) -> list[CorpusError]:
    """Simulate workers, write their commands with scenarios and logs, and return the failures.

    The folder `out` of the dataset is made if it isn't there. What is there already is kept, so
    that an interrupted run resumes where it stopped. Layouts and words are those of the dataset
    `basis`. The files don't depend on the `workers` that execute the scenarios. A scenario is
    left out if the robot can't do its script. FormatError if the folder holds something else, or
    the layouts have no room.
    """
    if plan.commands > plan.workers:
        raise FormatError(
            f"{plan.workers} workers can't write {plan.commands} commands for each scenario",
            fix="ask for more workers, or fewer commands",
        )
    _begin(plan, out, basis, read_layouts(basis))
    simulate = partial(_simulate, plan=plan, out=out.absolute(), basis=basis.absolute())
    failures: dict[int, CorpusError] = {}
    for number, done in enumerate(work(simulate, range(plan.scenarios), workers or Workers()), 1):
        on_progress("simulating", number, plan.scenarios)
        if isinstance(done.error, CorpusError):
            failures[done.item] = done.error
        elif isinstance(done.error, WorkerDiedError):
            failures[done.item] = CorpusError(
                f"scenario {done.item + 1}: {done.error}", fix="run again"
            )
        elif done.error is not None:
            raise done.error
    return [failures[number] for number in sorted(failures)]


def _simulate(number: int, *, plan: Plan, out: Path, basis: Path) -> None:
    """Write a scenario with its log and commands, unless they are there."""
    scenario = generate(plan.seed, number, _layouts(basis))
    if not is_logged(scenario, out):
        log_scenario(scenario, out)
    typists = draw_workers(plan.workers, plan.seed)
    told = commands_for(scenario, typists, plan.commands, plan.seed + number)
    text = format_scenario(scenario) + format_commands(told)
    write_bytes(out / SCENARIOS / f"{scenario.id}.yaml", text.encode())


@lru_cache(maxsize=1)
def _layouts(basis: Path) -> Mapping[str, Layout]:
    return read_layouts(basis)


def commands_for(
    scenario: Scenario, workers: tuple[Worker, ...], count: int, seed: int
) -> list[tuple[Worker, Told]]:
    """Return commands of some of the workers for a scenario, each at most once."""
    rng = np.random.default_rng([seed, count])
    scene = see(scenario)
    chosen = rng.choice(len(workers), size=count, replace=False)
    return [(workers[i], tell(scene, workers[i], rng)) for i in chosen]


def format_commands(told: list[tuple[Worker, Told]]) -> str:
    """Return commands as they stand in a scenario's file."""
    lines = ["commands:"]
    for worker, command in told:
        nodes = list(breadth_first(command.sdcs))
        names = clause_names(command.sdcs, nodes)
        groundings = {
            name: ids[0] if len(ids) == 1 else list(ids)
            for name, node in zip(names, nodes, strict=True)
            if name and (ids := command.wording.grounding(node)) is not None
        }
        lines += [
            f"  - text: {json.dumps(command.wording.text)}",
            f"    sdcs: {json.dumps(format_brackets(command.sdcs))}",
            f"    groundings: {json.dumps(groundings)}",
            f"    subject: {worker.id}",
        ]
    return "\n".join(lines) + "\n"


def _begin(plan: Plan, out: Path, basis: Path, layouts: Mapping[str, Layout]) -> None:
    words = read_dataset(basis, Journal(keep_going=False)).words
    head = {
        "name": f"simulated-{plan.seed}",
        "source": SOURCE,
        "licence": "MIT",
        "seed": plan.seed,
        "words": words,
    }
    content = json.dumps(head, indent=1).encode()
    file = out / DATASET
    is_ours = file.is_file() and file.read_bytes() == content
    if out.exists() and any(out.iterdir()) and not is_ours:
        raise FormatError(
            "this folder holds something else", where=str(out), fix="name a new folder"
        )
    for folder in (SCENARIOS, LAYOUTS):
        (out / folder).mkdir(parents=True, exist_ok=True)
    for name in layouts:
        path = Path(LAYOUTS) / f"{name}.yaml"
        write_bytes(out / path, (basis / path).read_bytes())
    write_bytes(file, content)
