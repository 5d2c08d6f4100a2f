"""The channels of a log: topics, the messages on them, and the messages' schemas.

Messages of this project hold the exact state, where the schemas of viewers have no place for it.
Viewers read schemas in which every value is a text, a number, a truth value, an object or a
list of these; hence no lists of lists and no null.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, get_args

import msgspec

from corpus_tools.logs.foxglove import FrameTransforms, Log, Pose, SceneUpdate, Time, Vector3
from corpus_tools.world.state.recording import Step
from g3.groundings import Colour, Context, PhysicalObject, Place, Prism, Trajectory

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


class Corner(msgspec.Struct, frozen=True, gc=False, forbid_unknown_fields=True):
    """A corner of a footprint, in metres."""

    x: float
    y: float


class PrismRecord(msgspec.Struct, frozen=True, gc=False, forbid_unknown_fields=True):
    """An upright prism in the frame of the site, in metres."""

    xy: tuple[Corner, ...]
    z_min: float
    z_max: float


_LIFTABLE: dict[bool | None, str] = {None: "", True: "yes", False: "no"}
"""Values of the field in logs: viewers can't read fields that may be null."""


class ObjectRecord(
    msgspec.Struct, frozen=True, gc=False, forbid_unknown_fields=True, omit_defaults=True
):
    """An object; ``t`` in seconds, ``xyz`` in metres and ``yaw`` in radians are its poses.

    ``liftable`` is "yes" or "no" where somebody has said whether the robot can lift it, else empty.
    ``colours`` are empty where nobody has said what colours it has.
    """

    id: str
    labels: tuple[str, ...]
    prism: PrismRecord
    t: tuple[float, ...]
    xyz: tuple[Vector3, ...]
    yaw: tuple[float, ...]
    liftable: str = ""
    colours: tuple[str, ...] = ()


class PlaceRecord(msgspec.Struct, frozen=True, gc=False, forbid_unknown_fields=True):
    """A region of the world, named or not."""

    name: str
    prism: PrismRecord


class ContextRecord(msgspec.Struct, frozen=True, gc=False, forbid_unknown_fields=True):
    """The world at the start."""

    timestamp: Time
    id: str
    agent_id: str
    objects: tuple[ObjectRecord, ...]
    places: tuple[PlaceRecord, ...]


class RobotRecord(msgspec.Struct, frozen=True, gc=False, forbid_unknown_fields=True):
    """The robot at a moment.

    ``speed_m_s`` is negative when it drives backwards. ``carries`` is the id of the object
    on the forks, empty if there is none.
    """

    timestamp: Time
    pose: Pose
    speed_m_s: float
    fork_height_m: float
    carries: str


class ArgumentRecord(msgspec.Struct, frozen=True, gc=False, forbid_unknown_fields=True):
    """An argument of an action."""

    name: str
    value: str


class StepRecord(msgspec.Struct, frozen=True, gc=False, forbid_unknown_fields=True):
    """A step of the robot's script; times in seconds since the start."""

    action: str
    arguments: tuple[ArgumentRecord, ...]
    start_s: float
    end_s: float


class StepsRecord(msgspec.Struct, frozen=True, gc=False, forbid_unknown_fields=True):
    """All steps of the robot's script."""

    timestamp: Time
    steps: tuple[StepRecord, ...]


def context_record(context: Context, timestamp: Time) -> ContextRecord:
    """Return a context as a message."""
    return ContextRecord(
        timestamp,
        context.id,
        context.agent_id,
        tuple(
            ObjectRecord(
                item.id,
                item.labels,
                _prism_record(item.prism),
                tuple(item.trajectory.t.tolist()),
                tuple(Vector3(*xyz) for xyz in item.trajectory.xyz.tolist()),
                tuple(item.trajectory.yaw.tolist()),
                _LIFTABLE[item.liftable],
                item.colours,
            )
            for item in context.objects
        ),
        tuple(PlaceRecord(place.name, _prism_record(place.prism)) for place in context.places),
    )


def _known_liftable(text: str) -> bool | None:
    for liftable, written in _LIFTABLE.items():
        if text == written:
            return liftable
    raise ValueError(f"liftable must be yes, no or empty, not {text!r}")


def _known_colours(texts: tuple[str, ...]) -> tuple[Colour, ...]:
    try:
        return msgspec.convert(texts, tuple[Colour, ...])
    except msgspec.ValidationError as error:
        raise ValueError(f"colours must be {', '.join(get_args(Colour))}: {error}") from error


def context_of(record: ContextRecord) -> Context:
    """Return a message's context; ValueError for a prism without corners or no agent."""
    context = Context(
        record.id,
        tuple(
            PhysicalObject(
                item.id,
                item.labels,
                _prism_of(item.prism),
                Trajectory(
                    item.t,  # type: ignore[arg-type]
                    [(point.x, point.y, point.z) for point in item.xyz],  # type: ignore[arg-type]
                    item.yaw,  # type: ignore[arg-type]
                ),
                _known_liftable(item.liftable),
                _known_colours(item.colours),
            )
            for item in record.objects
        ),
        tuple(Place(_prism_of(place.prism), place.name) for place in record.places),
        record.agent_id,
    )
    ids = [item.id for item in context.objects]
    if record.agent_id not in ids or len(set(ids)) != len(ids):
        raise ValueError("the objects' ids don't differ, or the agent is none of them")
    return context


def steps_record(steps: tuple[Step, ...], timestamp: Time) -> StepsRecord:
    """Return steps as a message."""
    return StepsRecord(
        timestamp,
        tuple(
            StepRecord(
                step.action,
                tuple(ArgumentRecord(name, value) for name, value in step.arguments),
                step.start_s,
                step.end_s,
            )
            for step in steps
        ),
    )


def steps_of(record: StepsRecord) -> tuple[Step, ...]:
    """Return the steps that a message holds."""
    return tuple(
        Step(
            step.action,
            tuple((argument.name, argument.value) for argument in step.arguments),
            step.start_s,
            step.end_s,
        )
        for step in record.steps
    )


def _prism_record(prism: Prism) -> PrismRecord:
    corners = tuple(Corner(x, y) for x, y in prism.xy.tolist())
    return PrismRecord(corners, float(prism.z_min), float(prism.z_max))


def _prism_of(record: PrismRecord) -> Prism:
    corners = [(corner.x, corner.y) for corner in record.xy]
    return Prism(corners, record.z_min, record.z_max)  # type: ignore[arg-type]


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
