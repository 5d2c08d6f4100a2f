"""Messages in the schemas that Foxglove and Lichtblick show by themselves.

Names and types of fields are those of the published JSON schemas
(github.com/foxglove/foxglove-sdk, ``schemas/jsonschema``), all that these require. What the
published schemas call optional (``message_id``, ``lineage``) is left out.
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
    nsec: Annotated[int, msgspec.Meta(ge=0, lt=1_000_000_000)]


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


class ArrowPrimitive(msgspec.Struct, frozen=True, gc=False):
    """An arrow along x."""

    pose: Pose
    shaft_length: float
    shaft_diameter: float
    head_length: float
    head_diameter: float
    color: Color


class CubePrimitive(msgspec.Struct, frozen=True, gc=False):
    """A box."""

    pose: Pose
    size: Vector3
    color: Color


class SpherePrimitive(msgspec.Struct, frozen=True, gc=False):
    """A sphere or an ellipsoid."""

    pose: Pose
    size: Vector3
    color: Color


class CylinderPrimitive(msgspec.Struct, frozen=True, gc=False):
    """A cylinder, an elliptic one, or a cone."""

    pose: Pose
    size: Vector3
    bottom_scale: float
    top_scale: float
    color: Color


class LinePrimitive(msgspec.Struct, frozen=True, gc=False):
    """Lines between points: in their order unless `indices`, of one colour unless `colors`."""

    type: Unsigned
    pose: Pose
    thickness: float
    scale_invariant: bool
    points: tuple[Vector3, ...]
    color: Color
    colors: tuple[Color, ...]
    indices: tuple[Unsigned, ...]


class TriangleListPrimitive(msgspec.Struct, frozen=True, gc=False):
    """Triangles, three points each."""

    pose: Pose
    points: tuple[Vector3, ...]
    color: Color
    colors: tuple[Color, ...]
    indices: tuple[Unsigned, ...]


class TextPrimitive(msgspec.Struct, frozen=True, gc=False):
    """A label that faces the viewer if it is a billboard."""

    pose: Pose
    billboard: bool
    font_size: float
    scale_invariant: bool
    color: Color
    text: str


class ModelPrimitive(msgspec.Struct, frozen=True, gc=False):
    """A 3D model from an address, or embedded as Base64."""

    pose: Pose
    scale: Vector3
    color: Color
    override_color: bool
    url: str
    media_type: str
    data: str


class SceneEntity(msgspec.Struct, frozen=True, gc=False):
    """Something to draw in a frame."""

    timestamp: Time
    frame_id: str
    id: str
    lifetime: Time
    frame_locked: bool
    metadata: tuple[KeyValuePair, ...]
    arrows: tuple[ArrowPrimitive, ...]
    cubes: tuple[CubePrimitive, ...]
    spheres: tuple[SpherePrimitive, ...]
    cylinders: tuple[CylinderPrimitive, ...]
    lines: tuple[LinePrimitive, ...]
    triangles: tuple[TriangleListPrimitive, ...]
    texts: tuple[TextPrimitive, ...]
    models: tuple[ModelPrimitive, ...]


class SceneEntityDeletion(msgspec.Struct, frozen=True, gc=False):
    """Entities to remove from the drawing."""

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
    """Return nanoseconds as seconds and a rest."""
    return Time(*divmod(t_ns, 1_000_000_000))
