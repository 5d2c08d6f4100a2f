"""Recordings of a world: the state of everything at every moment.

Simulations and replays of corpora both give recordings; logs and videos are made of them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from g3.groundings import Context, FloatArray, PhysicalObject, Trajectory
from g3.short_repr import short_repr

NS_PER_S = 1_000_000_000


@short_repr
@dataclass(frozen=True, slots=True)
class Step:
    """A step of the robot's script, and when it was done."""

    action: str
    """Name of the action, such as ``pick_up``."""
    arguments: tuple[tuple[str, str], ...]
    """Names and values, in order: ids of objects and places, or numbers as text."""
    start_s: float
    end_s: float
    """Seconds since the recording's start."""


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class Recording:
    """The states of a world over time."""

    start: Context
    """The world at the first moment: every object with its labels, its prism and one pose, and the
    named places. The agent is the robot."""
    t_ns: npt.NDArray[np.int64]
    """Nanoseconds since the recording's start, shape (n,), int64, growing."""
    position: FloatArray
    """Positions of the objects of ``start.objects`` in their order, shape (n, b, 3), metres."""
    orientation: FloatArray
    """Unit quaternions w, x, y, z of the objects' frames, shape (n, b, 4). An object's frame is at
    its pose, with x along its heading."""
    fork_height_m: FloatArray
    """Height of the forks' upper side above the ground that the robot stands on, (n,)."""
    steps: tuple[Step, ...] = ()
    """Steps of the robot with their times."""

    def __post_init__(self) -> None:
        n, b = len(self.t_ns), len(self.start.objects)
        for name, shape in (
            ("t_ns", (n,)),
            ("position", (n, b, 3)),
            ("orientation", (n, b, 4)),
            ("fork_height_m", (n,)),
        ):
            given = getattr(self, name)
            if given.shape != shape:
                raise ValueError(f"{name} has shape {given.shape}, expected {shape}")
            if not np.isfinite(given).all():
                raise ValueError(f"{name} holds a value that is not finite")
            given.setflags(write=False)
        if n == 0 or self.t_ns[0] < 0 or (np.diff(self.t_ns) <= 0).any():
            raise ValueError("a recording needs times, from 0 on and growing")

    @property
    def t_s(self) -> FloatArray:
        """Seconds since the start, shape (n,)."""
        seconds: FloatArray = self.t_ns / NS_PER_S
        return seconds


def heading(orientation: FloatArray) -> FloatArray:
    """Return the yaw of unit quaternions w, x, y, z of shape (..., 4), in radians."""
    w, x, y, z = np.moveaxis(orientation, -1, 0)
    yaw: FloatArray = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return yaw


def upright(yaw: FloatArray) -> FloatArray:
    """Return unit quaternions (..., 4) of headings (...)."""
    half = np.asarray(yaw) / 2
    zero = np.zeros_like(half)
    return np.stack((np.cos(half), zero, zero, np.sin(half)), axis=-1)


def to_context(recording: Recording, start_s: float = 0.0) -> Context:
    """Return the context with the trajectories that the recording holds.

    Objects that never move have one pose, as in the paper's corpus.

    Parameters
    ----------
    start_s
        Time of the recording's start on the corpus's clock.
    """
    t = start_s + recording.t_s
    yaw = np.unwrap(heading(recording.orientation), axis=0)

    def moved(i: int, item: PhysicalObject) -> PhysicalObject:
        xyz = recording.position[:, i]
        still = (xyz == xyz[0]).all() and (yaw[:, i] == yaw[0, i]).all()
        keep = slice(1) if still and item.id != recording.start.agent_id else slice(None)
        return replace(item, trajectory=Trajectory(t[keep], xyz[keep], yaw[keep, i]))

    objects = tuple(moved(i, item) for i, item in enumerate(recording.start.objects))
    return replace(recording.start, objects=objects)
