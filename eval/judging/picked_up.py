"""Loads picked up by a plan, and by a log."""

from __future__ import annotations

from collections.abc import Sequence

from eval.judging.judge import shifted
from g3.actions.action_kinds import Action
from g3.actions.logged_actions import NOTHING, handling, moved, recorded
from g3.actions.robot_state import State, start_state
from g3.groundings import Context


def picked_up(start: State, actions: Sequence[Action], final: State) -> frozenset[str]:
    """Return the ids of loads that a plan picks up or moves, but for the one held at the start."""
    lifted = {a.object_id for a in actions if a.kind.takes}
    return frozenset(shifted(start, final) | lifted) - {start.held}


def picked_in_log(context: Context) -> frozenset[str]:
    """Return the ids of loads that are picked up in a context's own log."""
    if handling(context) == NOTHING:
        return frozenset()
    return moved(recorded(context)) - {start_state(context).held}
