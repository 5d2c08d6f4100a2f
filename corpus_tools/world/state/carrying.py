"""The load on the robot's forks, derived from the poses of things."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from corpus_tools.world.state.dimensions import ENTRY_HEIGHT
from corpus_tools.world.state.recording import Recording, heading
from corpus_tools.world.state.shapes import Shape, shape_of
from corpus_tools.world.state.thing_kinds import kind_of
from g3.actions.logged_actions import REACH_M
from g3.geometry.plane import BoolArray, rotate
from g3.groundings import FloatArray

NEAR_M = (0.5, REACH_M + 0.3)
"""Distance ahead of the robot of the middle of a load on the forks, from and to, in metres."""
ASIDE_M = 0.4
TOUCH_M = 0.01
"""Forks this near to the underside of a pallet's deck are taken to touch it."""

NOTHING = -1


def carried(recording: Recording) -> npt.NDArray[np.int64]:
    """Return the object on the forks at every moment: its index into ``start.objects``, (n,).

    One that can be carried, is straight ahead within reach, and touches the forks; :data:`NOTHING`
    where they are empty.
    """
    start = recording.start
    robot = [item.id for item in start.objects].index(start.agent_id)
    yaw = heading(recording.orientation)
    pose = recording.position[:, robot], yaw[:, robot]
    forks = recording.position[:, robot, 2] + recording.fork_height_m
    load = np.full(len(recording.t_ns), NOTHING, dtype=np.int64)
    for i, item in enumerate(start.objects):
        if i == robot or not kind_of(item.labels).carriable:
            continue
        shape = shape_of(item)
        opening = recording.position[:, i, 2] + shape.low[2] + ENTRY_HEIGHT
        near = within_reach(from_robot(recording.position[:, i], yaw[:, i], shape, *pose))
        load[near & (np.abs(opening - forks) < TOUCH_M)] = i
    return load


def from_robot(
    xyz: FloatArray, yaw: FloatArray, shape: Shape, robot_xyz: FloatArray, robot_yaw: FloatArray
) -> FloatArray:
    """Return the middles of an object's footprint in the robot's frame, shape (n, 2).

    `xyz` and `yaw` are the object's poses, shapes (n, 3) and (n,), `shape` its box in its own
    frame, `robot_xyz` and `robot_yaw` the robot's poses at the same times.
    """
    middle = xyz[:, :2] + rotate(np.broadcast_to(shape.middle[:2], (len(yaw), 2)), yaw)
    return rotate(middle - robot_xyz[:, :2], -robot_yaw)


def within_reach(middle: FloatArray) -> BoolArray:
    """Mark the things with middles (n, 2) in the robot's frame that can be on the forks."""
    near: BoolArray = (
        (middle[:, 0] > NEAR_M[0]) & (middle[:, 0] < NEAR_M[1]) & (np.abs(middle[:, 1]) < ASIDE_M)
    )
    return near
