"""What test worlds are built of: boxes, logs, things, places and a robot."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from g3.geometry.plane import rotate
from g3.groundings import Context, FloatArray, PhysicalObject, Place, Prism, Trajectory


def rectangle(
    xy: Sequence[float], size: Sequence[float], yaw: float = 0.0, ahead_m: float = 0.0
) -> FloatArray:
    """Corners of a rectangle, shape (4, 2); its middle is a way ahead of the point."""
    corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * np.array(size) / 2
    turned: FloatArray = np.array(xy) + rotate(corners + np.array([ahead_m, 0.0]), np.full(4, yaw))
    return turned


def prism(
    x: float,
    y: float,
    size: Sequence[float] = (2, 2),
    z: Sequence[float] = (0, 1),
    yaw: float = 0.0,
) -> Prism:
    """An upright box around (x, y)."""
    return Prism(rectangle((x, y), size, yaw), *z)


def log(
    xy: Sequence[Sequence[float]] | FloatArray,
    yaw: float | Sequence[float] | FloatArray = 0.0,
    z: float | Sequence[float] | FloatArray = 0.0,
    t: Sequence[float] | FloatArray | None = None,
) -> Trajectory:
    """Poses one second apart, unless told otherwise."""
    xy = np.array(xy, dtype=float)
    n = len(xy)
    height, heading = np.broadcast_to(z, n), np.broadcast_to(yaw, n)
    return Trajectory(np.arange(n) if t is None else t, np.column_stack((xy, height)), heading)


def still(x: float, y: float, z: float = 0.0, yaw: float = 0.0) -> Trajectory:
    """The log of what doesn't move."""
    return log([(x, y)], yaw, z)


def line(start: Sequence[float], end: Sequence[float], n: int = 11) -> FloatArray:
    """Points evenly along a line, shape (n, 2)."""
    return np.linspace(start, end, n).astype(float)


def thing(
    id: str,
    labels: str,
    x: float,
    y: float,
    size: Sequence[float] = (2, 2),
    z: Sequence[float] = (0, 1),
    trajectory: Trajectory | None = None,
) -> PhysicalObject:
    """A box that stands still, unless told otherwise."""
    way = trajectory or still(x, y, z[0])
    return PhysicalObject(id, tuple(labels.split()), prism(x, y, size, z), way)


def place(
    name: str,
    xy: tuple[float, float],
    size: tuple[float, float] = (1.2, 1.2),
    yaw: float = 0.0,
    z: float = 0.0,
) -> Place:
    """A named place."""
    return Place(prism(*xy, size, (z, z + 1.0), yaw), name)


def robot(trajectory: Trajectory | None = None) -> PhysicalObject:
    """A forklift, at the origin facing +x unless told otherwise."""
    trajectory = trajectory or still(0, 0)
    x, y = trajectory.xyz[0, :2]
    return thing("robot", "forklift", x, y, (1.5, 1.5), (0, 2), trajectory)


def scene(*objects: PhysicalObject, agent: PhysicalObject | None = None) -> Context:
    """A context with some objects and a robot."""
    own = agent or robot()
    return Context("scene", (*objects, own), (), own.id)


PALLET, OTHER, TRAILER = "pallet-1", "pallet-2", "trailer"


def two_pallets_and_a_trailer() -> tuple[PhysicalObject, ...]:
    """Things ahead and to the left of a robot at (0, 0) that looks along +x."""
    return (
        thing(PALLET, "tire pallet", 6, 0, (1.2, 1.2)),
        thing(OTHER, "box pallet", 6, 5, (1.2, 1.2)),
        thing(TRAILER, "trailer", 0, 12, (6, 3), (0, 0.8)),
    )
