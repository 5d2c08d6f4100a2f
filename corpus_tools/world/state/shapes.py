"""Boxes of objects, in the objects' frames."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from g3.geometry.plane import rotate
from g3.groundings import FloatArray, PhysicalObject
from g3.short_repr import short_repr


@short_repr
@dataclass(frozen=True, slots=True)
class Shape:
    """A box in the frame of an object: x along its heading, y to the left, z up."""

    low: FloatArray
    high: FloatArray
    """Opposite corners, shape (3,), metres."""

    @property
    def middle(self) -> FloatArray:
        """Middle of the box, shape (3,)."""
        middle: FloatArray = (self.low + self.high) / 2
        return middle

    @property
    def size(self) -> FloatArray:
        """Lengths of the box's edges, shape (3,)."""
        size: FloatArray = self.high - self.low
        return size


def shape_of(item: PhysicalObject) -> Shape:
    """Return the box around an object's prism, along its heading at its first pose."""
    pose = item.trajectory
    xy = rotate(item.prism.xy - pose.xyz[0, :2], np.full(len(item.prism.xy), -pose.yaw[0]))
    z = pose.xyz[0, 2]
    return Shape(
        np.array([*xy.min(axis=0), item.prism.z_min - z]),
        np.array([*xy.max(axis=0), item.prism.z_max - z]),
    )
