"""Scenarios executed in physics: how many reach their goals, how exactly, and how fast.

``python -m benchmarks.script_execution --generated 200``
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator

import numpy as np

from benchmarks.timing import heading
from corpus_tools.runtime.shipped import bundled
from corpus_tools.world.physics.execute import Execution
from corpus_tools.world.scenarios.contexts import scenario_places
from corpus_tools.world.scenarios.execution import execute_scenario
from corpus_tools.world.scenarios.library import read_layouts, scenario_files
from corpus_tools.world.scenarios.random.generation import generate
from corpus_tools.world.scenarios.scenario import Scenario
from corpus_tools.world.scenarios.scenario_reading import read_scenario

SEED = 2011


def scenarios(generated: int, seed: int) -> Iterator[Scenario]:
    """The bundled ones, and generated ones."""
    folder = bundled()["warehouse"]
    for path in scenario_files(folder).values():
        yield read_scenario(path)
    layouts = read_layouts(folder)
    for number in range(generated):
        yield generate(seed, number, layouts)


def off_middle(scenario: Scenario, execution: Execution) -> list[float]:
    """How far the goals of steps lie from the middles of the places that the script names."""
    middles = {
        name: place.prism.xy.mean(axis=0) for name, place in scenario_places(scenario).items()
    }
    return [
        float(np.linalg.norm(outcome.goal.xyz[:2] - middles[outcome.step.argument]))
        for outcome in execution.outcomes
        if outcome.goal is not None and outcome.step.argument in middles
    ]


def run(generated: int, seed: int) -> None:
    heading(f"Execution in physics: the bundled scenarios and {generated} generated ones")
    errors: list[tuple[float, float]] = []
    moved: list[float] = []
    simulated: list[float] = []
    reached = total = 0
    began = time.process_time()
    for scenario in scenarios(generated, seed):
        execution = execute_scenario(scenario, 25.0)
        total += 1
        reached += not execution.problems
        for problem in execution.problems:
            print(f"  {scenario.id}: {problem}", flush=True)
        errors += [(o.error_m, o.error_deg) for o in execution.outcomes if o.goal is not None]
        moved += off_middle(scenario, execution)
        simulated.append(float(execution.recording.t_s[-1]))
    spent = time.process_time() - began
    share = np.percentile(np.array(errors), (50, 90, 99, 100), axis=0)
    print(f"reached their goals: {reached} of {total} ({reached / total:.1%})")
    for name, row in zip(("median", "90 %", "99 %", "largest"), share, strict=True):
        print(f"end error, {name}: {row[0] * 100:.1f} cm, {row[1]:.2f} degrees")
    if moved:
        away = np.array(moved)
        print(
            f"goals beside the middle of their place: {np.mean(away > 0.01):.1%}, "
            f"at most {away.max():.2f} m"
        )
    print(
        f"simulated: median {np.median(simulated):.0f} s, longest {max(simulated):.0f} s; "
        f"{sum(simulated) / spent:.0f} simulated seconds per second of one core"
    )


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.script_execution", description=__doc__
    )
    parser.add_argument("--generated", type=int, default=200, metavar="N")
    parser.add_argument("--seed", type=int, default=SEED)
    arguments = parser.parse_args()
    run(arguments.generated, arguments.seed)


if __name__ == "__main__":
    main()
