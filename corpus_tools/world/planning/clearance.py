"""Room around the robot, in the plane.

Poses are rows x, y, yaw; everything that stands in the world is upright boxes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.ndimage import map_coordinates

from g3.geometry.plane import rotate
from g3.groundings import FloatArray
from g3.short_repr import short_repr

_SPACING_M = 0.2
_CELL_M = 0.1
_FAR = 1e3


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class Boxes:
    """Upright boxes."""

    middle: FloatArray
    yaw: FloatArray
    half: FloatArray
    """Footprints: middles (n, 2), headings (n,), half lengths along and across (n, 2)."""
    z: FloatArray
    """Bottoms and tops above the ground, shape (n, 2)."""

    def __len__(self) -> int:
        return len(self.yaw)

    def between(self, low: float, high: float) -> Boxes:
        """Return the boxes that a thing between two heights could touch."""
        return self.where((self.z[:, 1] > low) & (self.z[:, 0] < high))

    def where(self, chosen: npt.NDArray[np.bool_]) -> Boxes:
        """Return the chosen boxes."""
        return Boxes(self.middle[chosen], self.yaw[chosen], self.half[chosen], self.z[chosen])

    def corners(self) -> FloatArray:
        """Return the corners of the footprints, shape (n, 4, 2)."""
        signs = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
        local = signs * self.half[:, None]
        corners: FloatArray = self.middle[:, None] + rotate(local, self.yaw[:, None])
        return corners


@short_repr
@dataclass(frozen=True, slots=True)
class Rect:
    """A rectangle in the robot's frame: from and to along x and y, in metres."""

    x: tuple[float, float]
    y: tuple[float, float]


def outline(rects: Sequence[Rect]) -> FloatArray:
    """Return points (m, 2) around rectangles, so dense that nothing slips between two of them."""
    return np.concatenate([_border(rect) for rect in rects])


def placed(points: FloatArray, poses: FloatArray) -> FloatArray:
    """Move points (m, 2) of the robot's frame to poses (..., 3); shape (..., m, 2)."""
    moved: FloatArray = poses[..., None, :2] + rotate(points, poses[..., None, 2])
    return moved


def distance(points: FloatArray, boxes: Boxes) -> FloatArray:
    """Return metres from points (..., 2) to the nearest box, negative inside, shape (...)."""
    nearest = np.full(points.shape[:-1], _FAR)
    for middle, yaw, half in zip(boxes.middle, boxes.yaw, boxes.half, strict=True):
        # By coordinates: numpy is slow where an axis has two elements.
        ahead, aside = np.moveaxis(np.abs(rotate(points - middle, -yaw)) - half, -1, 0)
        outside = np.hypot(np.maximum(ahead, 0), np.maximum(aside, 0))
        nearest = np.minimum(nearest, outside + np.minimum(np.maximum(ahead, aside), 0))
    return nearest


def room(poses: FloatArray, points: FloatArray, boxes: Boxes) -> FloatArray:
    """Return the room that an outline (m, 2) has at each of poses (n, 3), in metres, shape (n,)."""
    least: FloatArray = distance(placed(points, poses), boxes).min(axis=-1)
    return least


def clearance(poses: FloatArray, points: FloatArray, boxes: Boxes) -> float:
    """Return the least room that an outline (m, 2) has at poses (n, 3), in metres."""
    return float(room(poses, points, boxes).min())


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class Field:
    """Distances to boxes, looked up in a grid."""

    origin: FloatArray
    """Position of the first cell, shape (2,)."""
    metres: FloatArray
    """Distances at the cells, shape (nx, ny)."""

    def at(self, points: FloatArray) -> FloatArray:
        """Return distances at points (..., 2); there is no room beyond the grid."""
        cells = np.moveaxis((points - self.origin) / _CELL_M, -1, 0)
        found: FloatArray = map_coordinates(self.metres, cells, order=1, cval=-1.0)
        return found


def field_of(boxes: Boxes, around: FloatArray, border_m: float) -> Field:
    """Return distances to boxes in all the region that the robot might drive in.

    Points `around`, shape (m, 2), lie inside, at least a border away from the edge.
    """
    points = np.concatenate((boxes.corners().reshape(-1, 2), around))
    origin = points.min(axis=0) - border_m
    shape = np.ceil((points.max(axis=0) + border_m - origin) / _CELL_M).astype(int) + 1
    grid = np.moveaxis(np.indices(tuple(shape)), 0, -1) * _CELL_M + origin
    return Field(origin, distance(grid, boxes))


def _border(rect: Rect) -> FloatArray:
    (x0, x1), (y0, y1) = rect.x, rect.y
    across = np.linspace(y0, y1, max(int(np.ceil((y1 - y0) / _SPACING_M)), 1) + 1)
    along = np.linspace(x0, x1, max(int(np.ceil((x1 - x0) / _SPACING_M)), 1) + 1)
    sides = [np.column_stack((np.full(len(across), x), across)) for x in (x0, x1)]
    sides += [np.column_stack((along, np.full(len(along), y))) for y in (y0, y1)]
    return np.concatenate(sides)
