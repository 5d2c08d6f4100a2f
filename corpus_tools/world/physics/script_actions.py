"""What the robot can do, in physics.

An action gets the running simulation and its argument, moves the robot, and says what it wanted to
reach. What it can't do it refuses with an :class:`ActionError`, before moving if it can know.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

from corpus_tools.world.physics.controller import Simulation
from corpus_tools.world.state.robot_script import ScriptAction
from g3.groundings import FloatArray
from g3.registry import Registry
from g3.short_repr import short_repr


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class Goal:
    """Where an action wants something to be."""

    thing: str
    """Id of the object."""
    xyz: FloatArray
    """Position of its frame, shape (3,)."""
    yaw: float


Behaviour: TypeAlias = Callable[[Simulation, Any], "Goal | None"]
"""Takes the id of an object, a :class:`~g3.groundings.Place` or a number, as its action does."""

BEHAVIOURS: Registry[Behaviour] = Registry("action")
"""What actions do, by name."""


def behaviour(action: ScriptAction) -> Callable[[Behaviour], Behaviour]:
    """Register what an action does."""
    return lambda function: BEHAVIOURS.add(function, action.name)
