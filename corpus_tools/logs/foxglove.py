"""Messages in the schemas that Foxglove and Lichtblick show by themselves.

Names and types of fields are those of the published schemas, as far as they are used here.
Lists of primitives that nothing makes are left out, which viewers take for empty.
"""

from __future__ import annotations

from typing import Annotated

import msgspec

INFO = 2
"""Level of a :class:`Log`."""
LINE_LOOP, LINE_LIST = 1, 2
"""Types of a :class:`LinePrimitive`."""

Unsigned = Annotated[int, msgspec.Meta(ge=0)]


class Time(msgspec.Struct, frozen=True, gc=False):
    """A time, or a duration."""

    sec: Unsigned
    nsec: Unsigned


class Vector3(msgspec.Struct, frozen=True, gc=False):
    """A vector or a point in metres."""

    x: float
    y: float
    z: float


class Quaternion(msgspec.Struct, frozen=True, gc=False):
    """A rotation."""

    x: float
    y: float
    z: float
    w: float


class Pose(msgspec.Struct, frozen=True, gc=False):
    """A position and an orientation."""

    position: Vector3
    orientation: Quaternion


class Color(msgspec.Struct, frozen=True, gc=False):
    """Red, green, blue and opacity, from 0 to 1."""

    r: float
    g: float
    b: float
    a: float


class FrameTransform(msgspec.Struct, frozen=True, gc=False):
    """Where a frame is in another one."""

    timestamp: Time
    parent_frame_id: str
    child_frame_id: str
    translation: Vector3
    rotation: Quaternion


class FrameTransforms(msgspec.Struct, frozen=True, gc=False):
    """Where frames are."""

    transforms: tuple[FrameTransform, ...]


class KeyValuePair(msgspec.Struct, frozen=True, gc=False):
    """Something to know about an entity."""

    key: str
    value: str


class CubePrimitive(msgspec.Struct, frozen=True, gc=False):
    """A box."""

    pose: Pose
    size: Vector3
    color: Color


class LinePrimitive(msgspec.Struct, frozen=True, gc=False):
    """Lines between points."""

    type: Unsigned
    pose: Pose
    thickness: float
    scale_invariant: bool
    points: tuple[Vector3, ...]
    color: Color


class TextPrimitive(msgspec.Struct, frozen=True, gc=False):
    """A label that faces the viewer if it is a billboard."""

    pose: Pose
    billboard: bool
    font_size: float
    scale_invariant: bool
    color: Color
    text: str


class SceneEntity(msgspec.Struct, frozen=True, gc=False):
    """Something to draw in a frame."""

    timestamp: Time
    frame_id: str
    id: str
    lifetime: Time
    frame_locked: bool
    metadata: tuple[KeyValuePair, ...]
    cubes: tuple[CubePrimitive, ...]
    lines: tuple[LinePrimitive, ...]
    texts: tuple[TextPrimitive, ...]


class SceneEntityDeletion(msgspec.Struct, frozen=True, gc=False):
    """What to draw no longer."""

    timestamp: Time
    type: Unsigned
    id: str


class SceneUpdate(msgspec.Struct, frozen=True, gc=False):
    """Entities to draw, in place of those with the same ids."""

    deletions: tuple[SceneEntityDeletion, ...]
    entities: tuple[SceneEntity, ...]


class Log(msgspec.Struct, frozen=True, gc=False):
    """A line for people to read."""

    timestamp: Time
    level: Unsigned
    message: str
    name: str
    file: str
    line: Unsigned


def time_of(t_ns: int) -> Time:
    """Nanoseconds as seconds and a rest."""
    return Time(*divmod(t_ns, 1_000_000_000))
