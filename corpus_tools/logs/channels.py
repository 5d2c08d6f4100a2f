"""The channels of a log: topics, the messages on them, and the messages' schemas."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import msgspec

from corpus_tools.logs.foxglove import FrameTransforms, Log, SceneUpdate
from corpus_tools.logs.log_records import ContextRecord, RobotRecord, StepsRecord

VERSION = 1
"""Version of the format."""
LIBRARY = "corpus-tools-g3"
"""In the file's header, and the name of the metadata with the version and the scenario."""
METADATA = "metadata"
"""Name of the writer's metadata."""

CONTEXT, STEPS, TF, SCENE, ROBOT, ACTIONS = (
    "/context",
    "/steps",
    "/tf",
    "/scene",
    "/robot",
    "/actions",
)


@dataclass(frozen=True, slots=True)
class Channel:
    """Type of messages on a topic."""

    message: type[msgspec.Struct]
    schema: str
    """Name of their schema; viewers know those that begin with ``foxglove.``."""


CHANNELS: Mapping[str, Channel] = MappingProxyType(
    {
        CONTEXT: Channel(ContextRecord, "g3.Context"),
        STEPS: Channel(StepsRecord, "g3.Steps"),
        TF: Channel(FrameTransforms, "foxglove.FrameTransforms"),
        SCENE: Channel(SceneUpdate, "foxglove.SceneUpdate"),
        ROBOT: Channel(RobotRecord, "g3.Robot"),
        ACTIONS: Channel(Log, "foxglove.Log"),
    }
)
"""All channels by topic, in the order of the file."""


def json_schema(message: type[msgspec.Struct], name: str) -> dict[str, Any]:
    """Return the JSON Schema of a type of messages, without references.

    Viewers follow no references, so each is replaced by what it refers to.
    """
    schema = msgspec.json.schema(message)
    definitions = schema["$defs"]

    def resolved(part: Any) -> Any:
        if isinstance(part, list):
            return [resolved(item) for item in part]
        if not isinstance(part, dict):
            return part
        if "$ref" in part:
            return resolved(definitions[part["$ref"].removeprefix("#/$defs/")])
        return {key: resolved(value) for key, value in part.items()}

    return {**resolved({"$ref": schema["$ref"]}), "title": name}
