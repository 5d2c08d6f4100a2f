"""Scripts: the robot's actions, step by step.

An action of scripts is a kind of action (:mod:`g3.actions.forklift_actions`) with one sort of
argument. What the steps do in physics is in :mod:`corpus_tools.world.physics.execute`; this
module knows no simulator.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from g3.actions import forklift_actions as forklift
from g3.actions.action_kinds import ActionKind
from g3.registry import Registry
from g3.short_repr import short_repr

Argument: TypeAlias = Literal["object", "place", "number"]
"""Argument of an action: the id of an object, the name of a place, or a number."""


@short_repr
@dataclass(frozen=True, slots=True)
class ScriptAction:
    """Something that the robot can do."""

    name: str
    """Name in scripts."""
    kind: ActionKind
    argument: Argument
    summary: str


@dataclass(frozen=True, slots=True)
class ScriptStep:
    """One step of a script."""

    action: str
    """Name of the action, one of :data:`ACTIONS`."""
    argument: str | float
    """Id of an object, name of a place, or a number in the unit that the action's name ends
    with."""

    @property
    def kind(self) -> ActionKind | None:
        """Kind of action; None for a name that isn't known."""
        action = ACTIONS.get(self.action)
        return action.kind if action else None


Script: TypeAlias = tuple[ScriptStep, ...]

ACTIONS: Registry[ScriptAction] = Registry("action")
"""All actions by name."""


def register_action(action: ScriptAction) -> ScriptAction:
    """Make an action known to scripts.

    Raises
    ------
    ValueError
        If another action has its name.
    """
    return ACTIONS.add(action)


def in_script(kind: ActionKind, argument: Argument) -> ScriptAction | None:
    """Return the scripts' action of a kind with a sort of argument; None if there is none."""
    matching = (a for a in ACTIONS.values() if a.kind is kind and a.argument == argument)
    return next(matching, None)


def _forklift_action(name: str, kind: ActionKind, argument: Argument, summary: str) -> ScriptAction:
    return register_action(ScriptAction(name, kind, argument, f"{summary}."))


DRIVE_TO = _forklift_action(
    "drive_to",
    forklift.DRIVE_TO,
    "place",
    "Drive into a place and stop with the robot in its middle",
)
DRIVE_PAST = _forklift_action(
    "drive_past",
    forklift.DRIVE_PAST,
    "object",
    "Drive past an object and stop some metres beyond it",
)
APPROACH = _forklift_action(
    "approach",
    forklift.DRIVE_TO,
    "object",
    "Drive up to an object and stop in front of it, facing it",
)
TURN = _forklift_action(
    "turn_deg", forklift.TURN, "number", "Turn on the spot by an angle in degrees, left if positive"
)
FORWARD = _forklift_action(
    "forward_m", forklift.GO_STRAIGHT, "number", "Drive straight ahead by a distance"
)
BACK_UP = _forklift_action(
    "back_up_m", forklift.BACK_UP, "number", "Drive straight back by a distance"
)
PICK_UP = _forklift_action(
    "pick_up",
    forklift.PICK_UP,
    "object",
    "Drive up to a load, lift it with the forks and back out with it",
)
PUT_DOWN = _forklift_action(
    "put_down",
    forklift.PUT_DOWN,
    "place",
    "Put the load on the forks down in the middle of a place",
)
WAIT = _forklift_action("wait_s", forklift.WAIT, "number", "Stand still for some seconds")
FACE = _forklift_action(
    "face", forklift.FACE, "object", "Turn on the spot until the robot faces an object"
)
TURN_AWAY = _forklift_action(
    "turn_away",
    forklift.TURN_AWAY,
    "object",
    "Turn on the spot until an object is behind the robot",
)
DRIVE_AWAY = _forklift_action(
    "drive_away",
    forklift.DRIVE_AWAY,
    "object",
    "Drive some metres away from an object, with it behind the robot",
)
LINE_UP = _forklift_action(
    "line_up", forklift.LINE_UP, "object", "Stop in front of a side of an object, square to it"
)
PARK = _forklift_action("park", forklift.PARK, "object", "Stop beside an object, parallel to it")
RAISE_FORKS = _forklift_action(
    "raise_forks_m",
    forklift.RAISE_FORKS,
    "number",
    "Raise the forks, with what is on them, by a distance",
)
LOWER_FORKS = _forklift_action(
    "lower_forks_m",
    forklift.LOWER_FORKS,
    "number",
    "Lower the forks, with what is on them, by a distance",
)
