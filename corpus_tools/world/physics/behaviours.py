"""Behaviours: effects of scripts' actions on a robot, in a simulation or in a rehearsal.

A behaviour (:data:`BEHAVIOURS`) gets a robot and the argument of its action, moves the robot, and
returns where it wants something to be. It refuses what it can't do with an :class:`ActionError`,
before it moves if it can know. This module knows no simulator.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol, TypeAlias

import numpy as np

from corpus_tools.world.physics.pacing import Limits
from corpus_tools.world.planning.curves import Way
from corpus_tools.world.state.recording import heading
from corpus_tools.world.state.robot_script import ACTIONS, Script, ScriptAction, ScriptStep
from corpus_tools.world.state.shapes import Shape
from g3.errors import CorpusError
from g3.geometry.relations import in_frame
from g3.groundings import Context, FloatArray, Place
from g3.registry import Registry
from g3.short_repr import short_repr


class ActionError(CorpusError):
    """Something that the robot could not do, or that went wrong while it did it."""


@short_repr
@dataclass(frozen=True, slots=True)
class Load:
    """The load on the forks, in the robot's frame."""

    id: str
    xy: FloatArray
    yaw: float
    """Pose of its frame, shape (2,) and radians."""


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class Goal:
    """Pose at which an action wants a thing to be."""

    thing: str
    """Id of the object."""
    xyz: FloatArray
    """Position of its frame, shape (3,)."""
    yaw: float


class Robot(Protocol):
    """A robot in a world, as behaviours see and move it."""

    start: Context
    """The world before anything moved."""
    load: Load | None
    grip: str | None
    """Id of the object that the forks may touch."""
    support: str | None
    """Id of the object that the load may touch, apart from the forks and the ground."""

    @property
    def pose(self) -> FloatArray:
        """Pose of the robot: x, y, yaw, shape (3,)."""
        ...

    @property
    def forks_m(self) -> float:
        """Height of the forks, in metres."""
        ...

    @property
    def ground_m(self) -> float:
        """Height of the ground."""
        ...

    def index(self, thing: str) -> int:
        """Return the index of an object among all objects."""
        ...

    def shape(self, thing: str) -> Shape:
        """Return the box of an object."""
        ...

    def body_pose(self, thing: str) -> tuple[FloatArray, FloatArray]:
        """Return the position (3,) and orientation (4,) of an object."""
        ...

    def take(self, thing: str) -> None:
        """Note that an object is on the forks, where it is now."""
        ...

    def drive(self, way: Way, limits: Limits | None = None) -> None:
        """Drive a way that starts at the robot's pose."""
        ...

    def lift(self, to_m: float) -> None:
        """Bring the forks to a height above their lowest."""
        ...

    def wait(self, duration_s: float) -> None:
        """Stand still."""
        ...


def load_of(robot: Robot, thing: str) -> Load:
    """Return the load of an object that is on the forks, at its present pose."""
    xyz, orientation = robot.body_pose(thing)
    pose = robot.pose
    return Load(thing, in_frame(xyz[:2], pose), float(heading(orientation) - pose[2]))


Behaviour: TypeAlias = Callable[[Robot, Any], "Goal | None"]
"""Takes the id of an object, a :class:`~g3.groundings.Place` or a number, as its action does."""

BEHAVIOURS: Registry[Behaviour] = Registry("action")
"""Behaviours of actions, by name."""


def behaviour(action: ScriptAction) -> Callable[[Behaviour], Behaviour]:
    """Register the behaviour of an action."""
    return lambda function: BEHAVIOURS.add(function, action.name)


def behave(robot: Robot, step: ScriptStep, argument: str | float | Place) -> Goal | None:
    """Carry out a step of a script; an ActionError names the step."""
    try:
        return BEHAVIOURS[step.action](robot, argument)
    except ActionError as error:
        raise ActionError(error.what, where=step_text(step), fix=error.fix) from error


def script_arguments(
    context: Context, script: Script, places: Mapping[str, Place] | None
) -> list[str | float | Place]:
    """Return the arguments of a script's steps as behaviours take them.

    Parameters
    ----------
    places
        By the names that the script uses; the context's places by their names if None.
    """
    if places is None:
        places = {place.name: place for place in context.places if place.name}
    return [_argument(context, places, step, i) for i, step in enumerate(script)]


def _argument(
    context: Context, places: Mapping[str, Place], step: ScriptStep, number: int
) -> str | float | Place:
    where = f"step {number + 1} of the script"
    if step.action not in ACTIONS or step.action not in BEHAVIOURS:
        raise CorpusError.unknown("action", step.action, BEHAVIOURS, where=where)
    kind, given = ACTIONS[step.action].argument, step.argument
    if kind == "number":
        if isinstance(given, str) or not np.isfinite(given):
            raise CorpusError(f"{step.action} needs a number, not {given!r}", where=where)
        return float(given)
    if kind == "object":
        things = [item.id for item in context.objects if item.id != context.agent_id]
        if given not in things:
            raise CorpusError.unknown("object", given, things, where=where)
        return str(given)
    if given not in places:
        raise CorpusError.unknown("place", given, places, where=where)
    return places[str(given)]


def step_text(step: ScriptStep) -> str:
    """Return a step in words: its action and its argument."""
    return f"{step.action} {argument_text(step)}"


def argument_text(step: ScriptStep) -> str:
    """Return the argument of a step in words."""
    return step.argument if isinstance(step.argument, str) else f"{step.argument:g}"
