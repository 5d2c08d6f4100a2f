"""The form of scenario and layout files, and their JSON Schemas."""

from __future__ import annotations

from typing import Annotated, Any, TypeAlias

import msgspec

from corpus_tools.world.scenarios.scenario import Bounds, Point, Region, Robot, SiteName, Thing
from corpus_tools.world.state.robot_script import ACTIONS
from corpus_tools.world.state.thing_kinds import FORKLIFT, KINDS, OTHER

SCENARIOS = "scenarios"
LAYOUTS = "layouts"
LOGS = "logs"
"""Folders of a dataset."""

KNOWN = tuple(name for name in KINDS if name not in (FORKLIFT.name, OTHER.name))
"""The kinds that scenarios can name."""

Step: TypeAlias = Annotated[dict[str, str | float], msgspec.Meta(min_length=1, max_length=1)]
"""One action and what it needs."""
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
    """The JSON Schema of a file."""
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
