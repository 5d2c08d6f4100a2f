"""Scripts: what the robot is told to do, step by step.

What the steps do is in :mod:`corpus_tools.world.physics.script_actions`; this module knows no
simulator.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal, TypeAlias

Argument: TypeAlias = Literal["object", "place", "number"]
"""What an action needs: the id of an object, the name of a place, or a number."""


@dataclass(frozen=True, slots=True)
class Action:
    """Something that the robot can be told to do.

    Parameters
    ----------
    name
        As scripts write it.
    argument
        What it needs.
    summary
        What it does, in one sentence.
    """

    name: str
    argument: Argument
    summary: str


@dataclass(frozen=True, slots=True)
class ScriptStep:
    """One step of a script.

    Parameters
    ----------
    action
        Name of the action, one of :data:`ACTIONS`.
    argument
        Id of an object, name of a place, or a number in the unit that the action's name ends with.
    """

    action: str
    argument: str | float


Script: TypeAlias = tuple[ScriptStep, ...]

_ACTIONS: dict[str, Action] = {}

ACTIONS: Mapping[str, Action] = MappingProxyType(_ACTIONS)
"""All actions by name."""


def register_action(action: Action) -> Action:
    """Make an action known to scripts.

    Raises
    ------
    ValueError
        If another action has its name.
    """
    if _ACTIONS.setdefault(action.name, action) != action:
        raise ValueError(f"there is an action {action.name!r} already")
    return action


DRIVE_TO = register_action(
    Action("drive_to", "place", "Drive into a place and stop with the robot in its middle.")
)
DRIVE_PAST = register_action(
    Action("drive_past", "object", "Drive past an object and stop some metres beyond it.")
)
APPROACH = register_action(
    Action("approach", "object", "Drive up to an object and stop in front of it, facing it.")
)
TURN = register_action(
    Action("turn_deg", "number", "Turn on the spot by an angle in degrees, left if positive.")
)
FORWARD = register_action(Action("forward_m", "number", "Drive straight ahead by a distance."))
BACK_UP = register_action(Action("back_up_m", "number", "Drive straight back by a distance."))
PICK_UP = register_action(
    Action("pick_up", "object", "Drive up to a load, lift it with the forks and back out with it.")
)
PUT_DOWN = register_action(
    Action("put_down", "place", "Put the load on the forks down in the middle of a place.")
)
WAIT = register_action(Action("wait_s", "number", "Stand still for some seconds."))
