"""Parts of a log: what a clause of a compound command refers to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from annotation_app.items.scenes import footprint_at
from g3.groundings import FloatArray, PhysicalObject, Prism, Trajectory


def shifted(item: PhysicalObject, seconds: float) -> PhysicalObject:
    """The same on another clock."""
    path = item.trajectory
    return replace(item, trajectory=Trajectory(path.t + seconds, path.xyz, path.yaw))


def trimmed(item: PhysicalObject, start: float, end: float) -> PhysicalObject:
    """What an object does between two times of its clock; its shape is that at the first."""
    path = item.trajectory
    first, last = np.clip([start, end], path.t[0], path.t[-1])
    inner = path.t[(path.t > first) & (path.t < last)]
    t = np.unique(np.concatenate(([first], inner, [last])))
    xyz = np.column_stack([np.interp(t, path.t, path.xyz[:, k]) for k in range(3)])
    part = Trajectory(t, xyz, _interpolated_yaw(path, t))
    rise = float(xyz[0, 2] - path.xyz[0, 2])
    prism = Prism(
        footprint_at(item, float(first)), item.prism.z_min + rise, item.prism.z_max + rise
    )
    return replace(item, prism=prism, trajectory=part)


def _interpolated_yaw(path: Trajectory, t: FloatArray) -> FloatArray:
    yaw: FloatArray = np.interp(t, path.t, np.unwrap(path.yaw))
    return yaw
