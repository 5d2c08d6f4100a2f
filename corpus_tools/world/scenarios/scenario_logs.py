"""The logs of a dataset's scenarios."""

from __future__ import annotations

from pathlib import Path

from corpus_tools.logs.log_reading import Log, read_log
from corpus_tools.world.scenarios.fingerprints import FINGERPRINT, fingerprint
from corpus_tools.world.scenarios.scenario import Scenario
from corpus_tools.world.scenarios.scenario_files import LOGS
from g3.errors import FormatError


def log_file(scenario: Scenario, dataset: Path) -> Path:
    """Where a scenario's log is in a dataset."""
    return dataset / LOGS / f"{scenario.id}.mcap"


def scenario_log(scenario: Scenario, dataset: Path) -> Log:
    """Read a scenario's log.

    FormatError if there is none, it can't be read, or it shows what the scenario said before it was
    changed.
    """
    path = log_file(scenario, dataset)
    fix = f"run: ct scenarios log {scenario.id} --dataset {dataset}"
    if not path.is_file():
        raise FormatError("there is no log", where=str(path), fix=fix)
    log = read_log(path)
    if log.metadata.get(FINGERPRINT) != fingerprint(scenario):
        raise FormatError("the scenario was changed after its log", where=str(path), fix=fix)
    return log


def is_logged(scenario: Scenario, dataset: Path) -> bool:
    """Whether a scenario has a log that shows what it says now."""
    try:
        scenario_log(scenario, dataset)
    except FormatError:
        return False
    return True
