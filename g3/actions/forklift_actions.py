"""The forklift's kinds of actions by their names, of all modules that define them."""

from g3.actions.driving_kinds import (
    BACK_UP,
    DRIVE_AROUND,
    DRIVE_BETWEEN,
    DRIVE_PAST,
    DRIVE_TO,
    GO_STRAIGHT,
    TURN,
    WAIT,
)
from g3.actions.handling_kinds import CARRY, LOWER_FORKS, PICK_UP, PUT_DOWN, RAISE_FORKS
from g3.actions.pose_kinds import DRIVE_AWAY, FACE, LINE_UP, PARK, TURN_AWAY

__all__ = [
    "BACK_UP",
    "CARRY",
    "DRIVE_AROUND",
    "DRIVE_AWAY",
    "DRIVE_BETWEEN",
    "DRIVE_PAST",
    "DRIVE_TO",
    "FACE",
    "GO_STRAIGHT",
    "LINE_UP",
    "LOWER_FORKS",
    "PARK",
    "PICK_UP",
    "PUT_DOWN",
    "RAISE_FORKS",
    "TURN",
    "TURN_AWAY",
    "WAIT",
]
