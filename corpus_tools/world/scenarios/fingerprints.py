"""Whether a log shows what a scenario says now."""

from __future__ import annotations

import hashlib

import msgspec

from corpus_tools.world.scenarios.scenario import Scenario
from corpus_tools.world.state.thing_kinds import FORKLIFT, KINDS

FINGERPRINT = "scenario"
"""Key of the fingerprint in a log's metadata."""


def fingerprint(scenario: Scenario) -> str:
    """A digest of all that determines what happens: all but titles and commands.

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
    """The fields that aren't as they are when nothing is said of them."""
    values = msgspec.structs.asdict(item)
    fields = msgspec.structs.fields(item)
    return {f.name: values[f.name] for f in fields if values[f.name] != f.default}
