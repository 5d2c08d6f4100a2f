"""The logs of a dataset's scenarios, and whether they show the present state of a scenario."""

from __future__ import annotations

import hashlib
from pathlib import Path

import msgspec

from corpus_tools.logs.log_reading import Log, read_log
from corpus_tools.world.scenarios.scenario import Scenario
from corpus_tools.world.scenarios.scenario_files import LOGS
from corpus_tools.world.state.thing_kinds import FORKLIFT, KINDS
from g3.errors import FormatError

FINGERPRINT = "scenario"
"""Key of the fingerprint in a log's metadata."""


def fingerprint(scenario: Scenario) -> str:
    """Return a digest of all that determines the events: all but titles and commands.

    The sizes of the kinds that occur count too.
    """
    layout = scenario.layout
    names = {FORKLIFT.name, *(thing.kind for thing in scenario.all_objects.values())}
    parts = {
        "frame": (layout.at, layout.yaw_deg),
        "objects": {name: _said(thing) for name, thing in scenario.all_objects.items()},
        "places": {name: _said(region) for name, region in scenario.all_places.items()},
        "robot": _said(scenario.robot),
        "script": scenario.script,
        "kinds": [KINDS[name] for name in sorted(names)],
    }
    return hashlib.sha256(msgspec.json.encode(parts, order="sorted")).hexdigest()


def _said(item: msgspec.Struct) -> dict[str, object]:
    """Return the fields that differ from their defaults."""
    values = msgspec.structs.asdict(item)
    fields = msgspec.structs.fields(item)
    return {f.name: values[f.name] for f in fields if values[f.name] != f.default}


def log_file(scenario: Scenario, dataset: Path) -> Path:
    """Return the path of a scenario's log in a dataset."""
    return dataset / LOGS / f"{scenario.id}.mcap"


def scenario_log(scenario: Scenario, dataset: Path) -> Log:
    """Read a scenario's log.

    FormatError if there is none, it can't be read, or it shows the scenario before a
    change.
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
    """Check that a scenario has a log that shows its present state."""
    try:
        scenario_log(scenario, dataset)
    except FormatError:
        return False
    return True
