"""Scenes for viewers: boxes and outlines of objects with their labels, places, the forks."""

from __future__ import annotations

from typing import Any

import msgspec
import numpy as np

from corpus_tools.logs.foxglove import (
    LINE_LIST,
    LINE_LOOP,
    Color,
    CubePrimitive,
    KeyValuePair,
    LinePrimitive,
    Pose,
    Quaternion,
    SceneEntity,
    TextPrimitive,
    Time,
    Vector3,
)
from corpus_tools.world.state.dimensions import (
    FORK_LENGTH,
    FORK_THICKNESS,
    FORK_WIDTH,
    FORK_Y,
    HEEL_X,
)
from corpus_tools.world.state.paints import PAINTS
from corpus_tools.world.state.shapes import shape_of
from corpus_tools.world.state.thing_kinds import kind_of
from g3.geometry.plane import rotate
from g3.groundings import Context, FloatArray, PhysicalObject, Place

COLOURS = {
    "forklift": (0.95, 0.62, 0.07),
    "tire-pallet": (0.25, 0.25, 0.28),
    "box-pallet": (0.72, 0.53, 0.33),
    "crate": (0.62, 0.44, 0.24),
    "trailer": (0.45, 0.52, 0.60),
    "truck": (0.75, 0.18, 0.18),
    "shelf": (0.20, 0.38, 0.65),
    "barrel": (0.10, 0.45, 0.50),
    "person": (0.35, 0.65, 0.30),
    "cone": (1.0, 0.42, 0.05),
}
"""Red, green and blue of kinds of objects."""
GREY = (0.6, 0.6, 0.62)
PLACE_COLOUR = Color(0.15, 0.55, 0.85, 0.9)
CARRIED_COLOUR = Color(0.2, 0.85, 0.3, 1.0)
LABEL_COLOUR = Color(1.0, 1.0, 1.0, 1.0)
OPACITY = 0.7
LABEL_M = 0.35
OUTLINE_M = 0.04

_UNTURNED = Quaternion(0.0, 0.0, 0.0, 1.0)
_HERE = Pose(Vector3(0.0, 0.0, 0.0), _UNTURNED)
_FOREVER = Time(0, 0)
_EMPTY = SceneEntity(_FOREVER, "", "", _FOREVER, True, (), (), (), (), (), (), (), (), ())


def frames(context: Context) -> tuple[str, str]:
    """Return the names of the site's frame and the forks', which no object has."""
    ids = {item.id for item in context.objects}

    def free(name: str) -> str:
        return name if name not in ids else free(f"{name}_")

    return free("world"), free(f"{context.agent_id}/forks")


def entities(context: Context, carries: str, timestamp: Time) -> tuple[SceneEntity, ...]:
    """Return all drawn entities; the outline of the load, whose id is `carries`, is lit up."""
    site, forks = frames(context)
    return (
        *(_place(place, i, site, timestamp) for i, place in enumerate(context.places)),
        *(_object(item, item.id == carries, timestamp) for item in context.objects),
        _forks(forks, timestamp),
    )


def _object(item: PhysicalObject, carried: bool, timestamp: Time) -> SceneEntity:
    own = [PAINTS[colour] for colour in item.colours]
    red, green, blue = own[0] if own else COLOURS.get(kind_of(item.labels).name, GREY)
    shape, pose = shape_of(item), item.trajectory
    xy = rotate(item.prism.xy - pose.xyz[0, :2], np.full(len(item.prism.xy), -pose.yaw[0]))
    outline = CARRIED_COLOUR if carried else Color(red / 2, green / 2, blue / 2, 1.0)
    x, y, _ = shape.middle.tolist()
    return _entity(
        item.id,
        item.id,
        timestamp,
        metadata=(KeyValuePair("labels", " ".join(item.labels)),),
        cubes=(_cube(shape.middle, shape.size, Color(red, green, blue, OPACITY)),),
        lines=_outlines(xy, float(shape.low[2]), float(shape.high[2]), outline),
        texts=(_label(" ".join(item.labels), x, y, float(shape.high[2]) + LABEL_M),),
    )


def _place(place: Place, number: int, site: str, timestamp: Time) -> SceneEntity:
    prism = place.prism
    x, y = ((prism.xy.min(axis=0) + prism.xy.max(axis=0)) / 2).tolist()
    return _entity(
        site,
        f"place {number}",
        timestamp,
        metadata=(KeyValuePair("name", place.name),),
        lines=_outlines(prism.xy, prism.z_min, prism.z_max, PLACE_COLOUR),
        texts=(_label(place.name, x, y, prism.z_min + LABEL_M),) if place.name else (),
    )


def _forks(frame: str, timestamp: Time) -> SceneEntity:
    size = np.array([FORK_LENGTH, FORK_WIDTH, FORK_THICKNESS])
    colour = Color(*GREY, 1.0)
    return _entity(
        frame,
        frame,
        timestamp,
        cubes=tuple(
            _cube(np.array([HEEL_X + FORK_LENGTH / 2, y, -FORK_THICKNESS / 2]), size, colour)
            for y in (-FORK_Y, FORK_Y)
        ),
    )


def _entity(frame: str, name: str, timestamp: Time, **drawn: Any) -> SceneEntity:
    """Return an entity that stays in its frame until replaced, with all required fields."""
    return msgspec.structs.replace(_EMPTY, timestamp=timestamp, frame_id=frame, id=name, **drawn)


def _cube(middle: FloatArray, size: FloatArray, colour: Color) -> CubePrimitive:
    return CubePrimitive(
        Pose(Vector3(*middle.tolist()), _UNTURNED), Vector3(*size.tolist()), colour
    )


def _outlines(
    xy: FloatArray, z_min: float, z_max: float, colour: Color
) -> tuple[LinePrimitive, ...]:
    """Return the edges of a prism."""
    low, high = ([Vector3(x, y, z) for x, y in xy.tolist()] for z in (z_min, z_max))
    upright = [corner for pair in zip(low, high, strict=True) for corner in pair]
    return tuple(
        LinePrimitive(kind, _HERE, OUTLINE_M, False, tuple(points), colour, (), ())
        for kind, points in ((LINE_LOOP, low), (LINE_LOOP, high), (LINE_LIST, upright))
    )


def _label(text: str, x: float, y: float, z: float) -> TextPrimitive:
    return TextPrimitive(
        Pose(Vector3(x, y, z), _UNTURNED), True, LABEL_M, False, LABEL_COLOUR, text
    )
