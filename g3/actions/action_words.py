"""Actions and groundings in words."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from g3.actions.action_kinds import Action
from g3.geometry.plane import rotate
from g3.groundings import FloatArray, Grounding, Path, PhysicalObject, Place

Frame = tuple[float, float, float]
"""Pose of a frame in the map's: x and y in metres, yaw in radians."""
MAP: Frame = (0.0, 0.0, 0.0)
"""The frame of the map itself."""


def described(action: Action, frame: Frame = MAP) -> str:
    """Describe an action and its object.

    Parameters
    ----------
    frame
        The frame of coordinates, in metres, of places without a name.
    """
    target = " and ".join(_called(g, frame) for g in action.target if not isinstance(g, Path))
    words = [action.kind.name, action.object_id, target]
    if action.place is not None:
        up = round(float(action.place.prism.z_min), 1)
        words.append(f"at {place_called(action.place, frame)}" + (f", {up} m up" if up else ""))
    if action.kind.unit == "rad":
        words.append(f"{np.rad2deg(action.amount):.0f} degrees")
    elif action.amount:  # also of a kind that mostly has none: "drive away", by so many metres
        words.append(f"{abs(action.amount):.3g} {action.kind.unit or 'm'}")
    return " ".join(word for word in words if word)


def grounded(group: Sequence[Grounding], frame: Frame = MAP) -> str:
    """Describe a clause's groundings; coordinates are in metres in a frame."""
    if any(isinstance(g, Path) for g in group):
        return "the way there"
    things = [g.id for g in group if isinstance(g, PhysicalObject)]
    places = [f"the place at {place_called(g, frame)}" for g in group if isinstance(g, Place)]
    return " and ".join((*things, *places))


def place_called(place: Place, frame: Frame = MAP) -> str:
    """Return the name of a place; without one, its middle in metres in a frame."""
    x, y = in_frame(place.prism.xy.mean(axis=0), frame) + 0.0
    return place.name or f"({x:.1f}, {y:.1f})"


def in_frame(point: FloatArray, frame: Frame) -> FloatArray:
    """Return a point (2,) of the map in a frame, rounded to millimetres."""
    x, y, yaw = frame
    moved: FloatArray = rotate(point - np.array([x, y]), np.array(-yaw)).round(3)
    return moved


def _called(target: Grounding, frame: Frame) -> str:
    return place_called(target, frame) if isinstance(target, Place) else getattr(target, "id", "")
