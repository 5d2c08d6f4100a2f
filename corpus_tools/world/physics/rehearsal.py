"""Rehearsals: scripts carried out without physics, to find impossible steps.

The behaviours are those of the simulation, with the same tests of free space. In a rehearsal the
robot gets exactly where it drives, and loads stay where they are put. What only contact shows, such
as a load that slips, no rehearsal finds. No simulator is needed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from corpus_tools.world.physics import (  # noqa: F401 - they register
    forklift_behaviours,
)
from corpus_tools.world.physics.behaviours import (
    ActionError,
    Load,
    behave,
    load_of,
    script_arguments,
)
from corpus_tools.world.physics.pacing import Limits
from corpus_tools.world.planning.curves import Way, end_of
from corpus_tools.world.state.dimensions import ENTRY_HEIGHT, LIFT_RANGE, LOW
from corpus_tools.world.state.recording import upright
from corpus_tools.world.state.robot_script import Script
from corpus_tools.world.state.shapes import Shape, shape_of
from corpus_tools.world.state.start import starting
from g3.geometry.plane import rotate
from g3.groundings import Context, FloatArray, Place
from g3.short_repr import short_repr


def rehearse(
    context: Context,
    script: Script,
    *,
    places: Mapping[str, Place] | None = None,
    forks_m: float = 0.0,
    held: str | None = None,
) -> ActionError | None:
    """Return the reason why a script can't be carried out; None if none is seen.

    The parameters, and the errors for a script that is wrong, are those of
    :func:`~corpus_tools.world.physics.execute.execute`.
    """
    arguments = script_arguments(context, script, places)
    robot = _standing(context, forks_m, held)
    for step, argument in zip(script, arguments, strict=True):
        try:
            behave(robot, step, argument)
        except ActionError as error:
            return error
    return None


@short_repr
@dataclass(slots=True, eq=False)
class _RehearsingRobot:
    """A robot that is at once where it goes, with what is on its forks."""

    start: Context
    pose: FloatArray
    forks_m: float
    poses: dict[str, FloatArray]
    """Positions and headings of objects, shape (4,) each."""
    load: Load | None = None
    grip: str | None = None
    support: str | None = None
    ground_m: float = field(init=False)

    def __post_init__(self) -> None:
        self.ground_m = float(self.start.agent.trajectory.xyz[0, 2])

    def index(self, thing: str) -> int:
        return next(i for i, item in enumerate(self.start.objects) if item.id == thing)

    def shape(self, thing: str) -> Shape:
        return shape_of(self.start.objects[self.index(thing)])

    def body_pose(self, thing: str) -> tuple[FloatArray, FloatArray]:
        pose = self.poses[thing]
        return pose[:3].copy(), upright(pose[3:])[0]

    def take(self, thing: str) -> None:
        self.load = load_of(self, thing)

    def drive(self, way: Way, limits: Limits | None = None) -> None:
        for motion in way:
            self.pose = end_of(self.pose, motion)
        if self.load is not None:
            xy = self.pose[:2] + rotate(self.load.xy, self.pose[2])
            self.poses[self.load.id][[0, 1, 3]] = *xy, self.pose[2] + self.load.yaw

    def lift(self, to_m: float) -> None:
        """Bring the forks to a height; what they are under goes with them, down to its support."""
        self.forks_m = to_m
        if self.grip is None:
            return
        rest = 0.0
        if self.support is not None:
            rest = float(self.body_pose(self.support)[0][2] + self.shape(self.support).high[2])
            rest -= self.ground_m
        bottom = self.ground_m + max(rest, to_m - (ENTRY_HEIGHT - LOW))
        self.poses[self.grip][2] = bottom - float(self.shape(self.grip).low[2])

    def wait(self, duration_s: float) -> None:
        """Stand still: nothing changes."""


def _standing(context: Context, forks_m: float, held: str | None) -> _RehearsingRobot:
    """Return the robot at the start of a context, as :func:`execute` has it."""
    start, held, forks = starting(context, held)
    poses = {
        item.id: np.array([*item.trajectory.xyz[0], item.trajectory.yaw[0]])
        for item in start.objects
    }
    agent = poses[start.agent_id]
    up = min(forks_m, LIFT_RANGE) if held is None else forks
    robot = _RehearsingRobot(start, agent[[0, 1, 3]], up, poses)
    if held is not None:
        robot.grip = held
        robot.take(held)
    return robot
