"""The forklift's kinds of moving its forks: up and down, with what is on them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from g3.actions.action_kinds import Action, Focus, action_kind
from g3.actions.courses import Course
from g3.actions.driving_kinds import driven, starts
from g3.actions.motions import LIFT_M
from g3.actions.robot_state import State

RAISE_M = 1.0
HIGHEST_M = 2.0
"""How far the forks go up at most."""


def _move_forks(state: State, actions: Sequence[Action]) -> Course:
    """Stay, while the forks go up or down with what is on them."""
    lead = np.repeat(starts(state, actions), 2, axis=1)
    return driven(state, lead, lift=np.array([a.amount for a in actions]))


def _raising(state: State, focus: Focus) -> list[Action]:
    """Raise the forks, with what is on them."""
    up = min(RAISE_M, HIGHEST_M - state.forks_m)
    return [Action(RAISE_FORKS, object_id=state.held or "", amount=up)] if up > 0 else []


def _lowering(state: State, focus: Focus) -> list[Action]:
    """Lower the forks; what is on them stays off the ground."""
    lowest = LIFT_M if state.held else 0.0
    down = min(lowest - state.forks_m, 0.0)
    return [Action(LOWER_FORKS, object_id=state.held or "", amount=down)]


RAISE_FORKS = action_kind("raise forks", _move_forks, unit="m", on_request=True, moves_forks=True)(
    _raising
)
LOWER_FORKS = action_kind("lower forks", _move_forks, unit="m", on_request=True, moves_forks=True)(
    _lowering
)
