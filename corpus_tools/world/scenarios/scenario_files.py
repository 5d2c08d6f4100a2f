"""The form of scenario and layout files, their JSON Schemas, and scenarios as people write them."""

from __future__ import annotations

import json
import re
from typing import Annotated, Any, TypeAlias

import msgspec

from corpus_tools.world.scenarios.scenario import (
    Bounds,
    Point,
    Region,
    Robot,
    Scenario,
    SiteName,
    Thing,
)
from corpus_tools.world.state.robot_script import ACTIONS
from corpus_tools.world.state.thing_kinds import FORKLIFT, KINDS, OTHER

SCENARIOS = "scenarios"
LAYOUTS = "layouts"
LOGS = "logs"
"""Folders of a dataset."""

KNOWN = tuple(name for name in KINDS if name not in (FORKLIFT.name, OTHER.name))
"""The kinds that scenarios can name."""

Step: TypeAlias = Annotated[dict[str, str | float], msgspec.Meta(min_length=1, max_length=1)]
"""One action and its argument."""
Steps: TypeAlias = Annotated[list[Step], msgspec.Meta(min_length=1)]


class Utterance(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A command, its SDC trees in bracket notation, its clauses' groundings, and whose it is."""

    text: Annotated[str, msgspec.Meta(pattern=r"\S")]
    sdcs: str
    groundings: dict[str, str | tuple[str, ...]]
    subject: str = "authored"


class ScenarioFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A scenario; docs/scenarios.md describes it."""

    title: str
    layout: str
    robot: Robot
    script: Steps
    objects: dict[str, Thing] = {}
    places: dict[str, Region] = {}
    commands: list[Utterance] = []


class LayoutFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A layout; docs/scenarios.md describes it."""

    title: str
    bounds: Bounds
    at: Point = (0.0, 0.0)
    yaw_deg: float = 0.0
    site: SiteName = "yard"
    objects: dict[str, Thing] = {}
    places: dict[str, Region] = {}


def schema(file_type: type[ScenarioFile] | type[LayoutFile]) -> dict[str, Any]:
    """Return the JSON Schema of a file."""
    made = msgspec.json.schema(file_type)
    defined = made["$defs"]
    for definition in defined.values():
        definition["description"], *_ = definition["description"].split("\n")
    defined["Thing"]["properties"]["kind"]["enum"] = list(KNOWN)
    if file_type is ScenarioFile:
        defined["ScenarioFile"]["properties"]["script"]["items"] = {
            "type": "object",
            "minProperties": 1,
            "maxProperties": 1,
            "additionalProperties": False,
            "properties": {
                action.name: {
                    "type": "number" if action.argument == "number" else "string",
                    "description": action.summary,
                }
                for action in ACTIONS.values()
            },
        }
    return made


_PLAIN = re.compile(r"[A-Za-z][A-Za-z0-9]*([ -][A-Za-z0-9]+)*")
_WORDS = {"null", "true", "false"}
_WHOLE = 1e15


def format_scenario(scenario: Scenario) -> str:
    """Return the text of a scenario's file; reading it gives the scenario again."""
    lines = [f"title: {_title(scenario.title)}", f"layout: {_scalar(scenario.layout.name)}"]
    for section, items in (("objects", scenario.objects), ("places", scenario.places)):
        if items:
            lines.append(f"{section}:")
            lines += [f"  {name}: {_flow(item)}" for name, item in items.items()]
    lines.append(f"robot: {_flow(scenario.robot)}")
    lines.append("script:")
    lines += [f"  - {step.action}: {_scalar(step.argument)}" for step in scenario.script]
    return "\n".join(lines) + "\n"


def _flow(item: Thing | Region | Robot) -> str:
    defaults = {field.name: field.default for field in msgspec.structs.fields(item)}
    values = msgspec.structs.asdict(item)
    written = (f"{k}: {_scalar(v)}" for k, v in values.items() if v != defaults[k])
    return "{" + ", ".join(written) + "}"


def _title(text: str) -> str:
    """Return a sentence without quotes where its words, commas and full stop need none."""
    words = text.removesuffix(".").replace(", ", " ")
    return text if _scalar(words) == words else json.dumps(text)


def _scalar(value: Any) -> str:
    if isinstance(value, tuple):
        return "[" + ", ".join(map(_scalar, value)) + "]"
    if isinstance(value, float | int):
        # JSON's numbers are YAML's too.
        return f"{value:.0f}" if value == int(value) and abs(value) < _WHOLE else repr(value)
    text = str(value)
    plain = _PLAIN.fullmatch(text) and text.lower() not in _WORDS
    return text if plain else json.dumps(text)
