"""Ways that words name: "back up", "turn left", "past the truck"."""

from __future__ import annotations

from math import log

import numpy as np

from g3.actions.action_kinds import Action
from g3.actions.forklift_actions import BACK_UP, GO_STRAIGHT, TURN
from g3.geometry.plane import BoolArray
from g3.inference.potentials.cases import ActionCase, PathCase
from g3.inference.potentials.potential_registry import Measured, potential
from g3.inference.problem.grounding_problem import Arguments, group_key
from g3.inference.problem.phrases import is_measure, names_robot
from g3.language.lexicon.concepts import WAYS, concepts
from g3.language.lexicon.field_words import field_words
from g3.language.lexicon.tables import WORDS
from g3.sdc.clauses import all_words

_STRAIGHT = {GO_STRAIGHT: "front", BACK_UP: "back"}


@potential("way", kind="action", types=("EVENT", "PATH"), weight=log(0.05))
def way(case: ActionCase) -> Measured:
    """An action without a goal goes the way that words name: "back up"."""
    below = (case.tree.nodes[n] for n in case.tree.all_below(case.root))
    things = (sdc for sdc in below if sdc.type == "OBJECT" and not sdc.is_implicit)
    if not all(is_measure(sdc) or names_robot(sdc) for sdc in things):
        return False
    words = field_words(all_words(case.sdc))
    named = WAYS & {*concepts(words), *(("around",) if WORDS["around"].intersection(words) else ())}
    return bool(named) and case.each(lambda a: is_bare(a) and not ways_of(a, case.found) & named)


@potential("asked-kind", kind="action", types=("EVENT", "PATH"), weight=2 * log(0.05))
def asked_kind(case: ActionCase) -> Measured:
    """An action is of a kind that words ask for: "past the truck", "face it"."""
    asked = case.found.asked
    return bool(asked) and case.each(lambda a: a.kind not in asked)


@potential(
    "own-landmark",
    kind="path",
    types=("PATH",),
    roles=("figure", "landmark"),
    weight=2 * log(0.05),
)
def own_landmark(case: PathCase) -> BoolArray:
    """The robot leaves or lines up with the thing that the words name."""
    groups = [group_key(mark.group) if mark else None for mark in case.marks]
    other = np.zeros(case.shape, dtype=bool)
    for i, action in enumerate(case.actions):
        if action.kind.on_request and action.target and action.goal < 0:
            other[i] = [group != group_key(action.target) for group in groups]
    return other


def is_bare(action: Action) -> bool:
    """Check that an action leads to nothing in particular."""
    return not (action.kind.aims or action.kind.handles)


def ways_of(action: Action, found: Arguments) -> set[str]:
    """Return the ways that an action goes by itself; none where it stays, or goes by its thing.

    To turn around is to turn left, too, where words say how much: "180 degrees to the left".
    """
    if action.kind is not TURN:
        return {way for kind, way in _STRAIGHT.items() if kind is action.kind}
    around = {"around"} if abs(action.amount) > 3 * np.pi / 4 else set()
    side = "left" if action.amount > 0 else "right"
    return around if around and found.amounts.radians is None else {side, *around}
