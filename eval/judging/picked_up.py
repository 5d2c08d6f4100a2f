"""What was picked up: by a plan, by a log, and what in a world could have been."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from corpus_tools.corpus.corpus_model import Corpus
from g3.actions.action_candidates import kind_of, moved
from g3.actions.action_kinds import Action
from g3.actions.logged_actions import centre, recorded
from g3.actions.robot_state import State, start_state
from g3.groundings import Context, PhysicalObject

MOVED_M = 0.5
"""What ends nearer than this to where it was counts as left alone."""
PALLET = "pallet"
LIFTS = ("pick up", "carry")


def picked_up(start: State, actions: Sequence[Action], final: State) -> frozenset[str]:
    """Ids of all that a plan picks up or moves, but for what is on the forks at the start."""
    before = {o.id: o for o in start.context.objects}
    shifted = {
        o.id
        for o in final.context.objects
        if o.id != start.context.agent_id and _shift(before[o.id], o) > MOVED_M
    }
    lifted = {a.object_id for a in actions if a.kind in LIFTS}
    return frozenset(shifted | lifted) - {start.held}


def picked_in_log(context: Context) -> frozenset[str]:
    """Ids of what is picked up in a context's own log."""
    if kind_of(context) == "drive":
        return frozenset()
    return moved(recorded(context)) - {start_state(context).held}


def load_labels(corpus: Corpus) -> frozenset[str]:
    """Labels of what robots carry: pallets, and all that is picked up somewhere in a corpus."""
    picked = {(o.context, thing) for o in corpus.outcomes for thing in o.picked}
    for context in corpus.contexts.values():
        if len(context.agent.trajectory) > 1:
            picked |= {(context.id, thing) for thing in picked_in_log(context)}
    return frozenset({PALLET}).union(
        *(
            o.labels
            for context in corpus.contexts.values()
            for o in context.objects
            if (context.id, o.id) in picked
        )
    )


def loads(context: Context, labels: Iterable[str]) -> tuple[PhysicalObject, ...]:
    """The things of a world that have one of the labels."""
    known = set(labels)
    return tuple(
        o for o in context.objects if o.id != context.agent_id and known.intersection(o.labels)
    )


def _shift(before: PhysicalObject, after: PhysicalObject) -> float:
    return float(np.linalg.norm(centre(after.prism) - centre(before.prism)))
