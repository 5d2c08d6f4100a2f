"""Groundings: the aspects of the world that clauses of a command refer to (section 3).

Lengths are in metres, angles in radians counter-clockwise from +x, times in seconds;
all coordinates are in the frame of the site that the context describes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from g3.data_frames import data_frame
from g3.short_repr import short_repr

if TYPE_CHECKING:
    import pandas as pd

FloatArray: TypeAlias = npt.NDArray[np.float64]
# fmt: off
Colour = Literal[
    "black", "white", "grey", "red", "green", "yellow", "blue", "brown", "orange", "pink", "purple",
]
"""A colour that a map can say of a thing: the eleven basic ones of English."""
# fmt: on


def _array(value: npt.ArrayLike, shape: tuple[int | None, ...], name: str) -> FloatArray:
    array = np.array(value, dtype=np.float64)
    if array.ndim != len(shape) or any(
        n is not None and n != m for n, m in zip(shape, array.shape, strict=True)
    ):
        raise ValueError(f"{name} has shape {array.shape}, expected {shape}")
    if not np.isfinite(array).all():
        raise ValueError(f"{name} holds a value that is not finite")
    array.setflags(write=False)
    return array


def _same(a: object, b: object) -> bool:
    if type(a) is not type(b):
        return False
    for field in fields(a):  # type: ignore[arg-type]
        x, y = getattr(a, field.name), getattr(b, field.name)
        equal = np.array_equal(x, y) if isinstance(x, np.ndarray) else x == y
        if not equal:
            return False
    return True


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class Prism:
    """An upright prism: a simple polygon between two heights.

    Parameters
    ----------
    xy
        Corners of the footprint, shape (k, 2) with k >= 3.
    z_min, z_max
        Heights of the bottom and the top.
    """

    xy: FloatArray
    z_min: float
    z_max: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "xy", _array(self.xy, (None, 2), "prism xy"))
        if len(self.xy) < 3:
            raise ValueError(f"a prism needs at least 3 corners, not {len(self.xy)}")
        if not (np.isfinite(self.z_min) and np.isfinite(self.z_max)) or self.z_min > self.z_max:
            raise ValueError(f"prism heights {self.z_min} to {self.z_max} are not an interval")

    def __eq__(self, other: object) -> bool:
        return _same(self, other)

    def __hash__(self) -> int:
        return hash((len(self.xy), self.z_min, self.z_max))


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """Poses over time.

    Parameters
    ----------
    t
        Times, shape (n,), n >= 1, never decreasing.
    xyz
        Positions, shape (n, 3).
    yaw
        Headings, shape (n,).
    """

    t: FloatArray
    xyz: FloatArray
    yaw: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "t", _array(self.t, (None,), "trajectory t"))
        n = len(self.t)
        if n == 0:
            raise ValueError("a trajectory needs at least one pose")
        object.__setattr__(self, "xyz", _array(self.xyz, (n, 3), "trajectory xyz"))
        object.__setattr__(self, "yaw", _array(self.yaw, (n,), "trajectory yaw"))
        if (np.diff(self.t) < 0).any():
            raise ValueError("trajectory times run backwards")

    def __len__(self) -> int:
        return len(self.t)

    def __eq__(self, other: object) -> bool:
        return _same(self, other)

    def __hash__(self) -> int:
        return hash((len(self.t), float(self.t[0])))


@short_repr
@dataclass(frozen=True, slots=True)
class PhysicalObject:
    """A thing in the world: a pallet, a truck, a person, the robot itself.

    Parameters
    ----------
    id
        Stable within a context.
    labels
        Names in the semantic map, such as ("tire", "pallet").
    prism
        Its shape at the first pose of the trajectory.
    trajectory
        Poses over time; a single pose if it does not move.
    liftable
        True if the robot can lift it; None where nobody recorded it.
    colours
        Its colours, the most frequent first; none where nobody recorded them.
    """

    id: str
    labels: tuple[str, ...]
    prism: Prism
    trajectory: Trajectory
    liftable: bool | None = None
    colours: tuple[Colour, ...] = ()


@short_repr
@dataclass(frozen=True, slots=True)
class Place:
    """A region of the world, named or not."""

    prism: Prism
    name: str = ""


@short_repr
@dataclass(frozen=True, slots=True)
class Path:
    """A path or a fragment of a path through the world."""

    trajectory: Trajectory


Grounding: TypeAlias = PhysicalObject | Place | Path


def object_ids(group: Sequence[Grounding]) -> tuple[str, ...]:
    """Return the ids of the objects of a grounding."""
    return tuple(g.id for g in group if isinstance(g, PhysicalObject))


Aspect = Literal["labels", "size", "position", "heading"]
"""Properties of an object that may be assumed."""


@short_repr
@dataclass(frozen=True, slots=True)
class Context:
    """The semantic map that a command was given in.

    Parameters
    ----------
    id
        Names the context in its corpus.
    objects
        All objects, the agent among them.
    places
        Regions that a command might refer to.
    agent_id
        Id of the robot among the objects.
    assumed
        Assumed properties that nobody has recorded: ids of objects and aspects.
    """

    id: str
    objects: tuple[PhysicalObject, ...]
    places: tuple[Place, ...]
    agent_id: str
    assumed: tuple[tuple[str, Aspect], ...] = ()

    def to_pandas(self) -> pd.DataFrame:
        """Return a row for each object: labels, colours, first position (metres, radians)."""
        return data_frame(
            {
                "id": thing.id,
                "labels": ", ".join(thing.labels),
                "colours": ", ".join(thing.colours),
                **dict(zip("xyz", map(float, thing.trajectory.xyz[0]), strict=True)),
                "yaw": float(thing.trajectory.yaw[0]),
            }
            for thing in self.objects
        )

    @property
    def agent(self) -> PhysicalObject:
        """The robot."""
        return next(o for o in self.objects if o.id == self.agent_id)
