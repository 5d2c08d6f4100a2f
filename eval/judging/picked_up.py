"""What was picked up: by a plan, and by a log."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from g3.actions.action_kinds import Action
from g3.actions.logged_actions import NOTHING, handling, moved, recorded
from g3.actions.robot_state import State, start_state
from g3.geometry.footprints import centre
from g3.groundings import Context, PhysicalObject

MOVED_M = 0.5
"""What ends nearer than this to where it was counts as left alone."""


def picked_up(start: State, actions: Sequence[Action], final: State) -> frozenset[str]:
    """Ids of all that a plan picks up or moves, but for what is on the forks at the start."""
    before = {o.id: o for o in start.context.objects}
    shifted = {
        o.id
        for o in final.context.objects
        if o.id != start.context.agent_id and _shift(before[o.id], o) > MOVED_M
    }
    lifted = {a.object_id for a in actions if a.kind.takes}
    return frozenset(shifted | lifted) - {start.held}


def picked_in_log(context: Context) -> frozenset[str]:
    """Ids of what is picked up in a context's own log."""
    if handling(context) == NOTHING:
        return frozenset()
    return moved(recorded(context)) - {start_state(context).held}


def _shift(before: PhysicalObject, after: PhysicalObject) -> float:
    return float(np.linalg.norm(centre(after.prism) - centre(before.prism)))
