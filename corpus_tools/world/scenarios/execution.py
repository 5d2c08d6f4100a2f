"""Executing scenarios in physics, and the logs of datasets that come of it."""

from __future__ import annotations

from pathlib import Path

from corpus_tools.logs.log_writing import write_log
from corpus_tools.world.physics.execute import Execution, execute
from corpus_tools.world.scenarios.contexts import scenario_context, scenario_places
from corpus_tools.world.scenarios.scenario import Scenario
from corpus_tools.world.scenarios.scenario_logs import FINGERPRINT, fingerprint, log_file
from corpus_tools.world.state.recording import Recording
from g3.errors import CorpusError

LOG_HZ = 5.0
"""Number of states a second in the logs of datasets."""


def execute_scenario(scenario: Scenario, rate_hz: float) -> Execution:
    """Let the robot carry out a scenario's script.

    See :func:`corpus_tools.world.physics.execute.execute`.
    """
    places = scenario_places(scenario)
    return execute(scenario_context(scenario), scenario.script, places=places, rate_hz=rate_hz)


def recorded(scenario: Scenario, rate_hz: float) -> Recording:
    """Return a scenario's recording; CorpusError if the robot doesn't do its script."""
    execution = execute_scenario(scenario, rate_hz)
    if execution.problems:
        raise CorpusError(
            "; ".join(execution.problems), where=scenario.id, fix="correct the scenario"
        )
    return execution.recording


def log_scenario(scenario: Scenario, dataset: Path) -> Path:
    """Execute a scenario, write its log into a dataset, and return the log's path.

    CorpusError if the robot doesn't do its script; there is no log then.
    """
    recording = recorded(scenario, LOG_HZ)
    path = log_file(scenario, dataset)
    path.parent.mkdir(exist_ok=True)
    metadata = {FINGERPRINT: fingerprint(scenario)}
    write_log(recording, path, name=scenario.id, metadata=metadata)
    return path
