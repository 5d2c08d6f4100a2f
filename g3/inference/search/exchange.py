"""Two loads that change places: "swap the crate and the tires".

The forks hold one load, so that one of the two waits on the ground until its new place is free.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import log

from g3.actions.action_kinds import Action, move, result
from g3.actions.forklift_actions import CARRY
from g3.actions.grounding_candidates import are_free, ground, spots_about, square
from g3.actions.robot_state import State
from g3.geometry.footprints import centre
from g3.geometry.relations import LEVEL_M
from g3.groundings import PhysicalObject, Place
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.frames import frame
from g3.inference.problem.grounding_problem import GroundingProblem, Group
from g3.inference.search.requests import loads_there
from g3.language.lexicon.field_words import bare_words, normalise
from g3.language.lexicon.tables import WORDS

GIVEN = log(0.5)
"""Log-probability of the clause: no log shows an exchange."""


def exchange(
    tree: Tree, root: int, state: State, problem: GroundingProblem
) -> tuple[tuple[Action, ...], dict[int, tuple[Group, float]]] | None:
    """Return the actions by which two loads change places, and what the clause's OBJECTs mean.

    None if the clause asks for something else, or there are no two loads, or no room.

    Parameters
    ----------
    tree, root
        The clause.
    state
        The state that the plan so far leads to.
    problem
        What the clause is grounded in.
    """
    nodes = _exchanged(tree, root) if state.held is None else []
    if not nodes:
        return None
    named = [loads_there(tree, node, problem) for node in nodes]
    pairs = ((one, other) for one in named[0][:1] for other in named[1] if one[0].id != other[0].id)
    (one, score), (other, other_score) = next(pairs, ((None, 0.0), (None, 0.0)))
    if one is None or other is None:
        return None
    one, other = state.thing(one.id), state.thing(other.id)
    aside = _aside(one, state)
    if aside is None:
        return None
    actions = (
        Action(CARRY, one.id, place=aside),
        Action(CARRY, other.id, place=_place_of(one)),
        Action(CARRY, one.id, place=_place_of(other)),
    )
    meant = {nodes[0]: ((one,), score), nodes[1]: ((other,), other_score)}
    return actions, {**meant, root: ((state.context.agent,), GIVEN)}


def after_actions(state: State, actions: tuple[Action, ...]) -> State:
    """Return the state that actions lead to."""
    for action in actions:
        state = result(state, action, move(state, [action]), 0)
    return state


def _swaps(verb: Sequence[str]) -> bool:
    """Check that words say that two things change places: "swap", "change places"."""
    verbal = not WORDS["swapping"].isdisjoint(map(normalise, verb[:1]))
    return verbal or (verb[:1] == ("change",) and not {"place", "places"}.isdisjoint(verb))


def _exchanged(tree: Tree, root: int) -> list[int]:
    """Return the two OBJECTs that change places, "A and B", "A with B", "A for B"; or none."""
    own = frame(tree, root) if tree.nodes[root].type == "EVENT" else None
    if own is None or own.negated or not _swaps(own.verb):
        return []
    found = list(own.objects)
    for node in (*own.paths, *own.places, *own.ways):
        found += tree.below(node, ("l", "l2"), "OBJECT")
    if len(found) == 1 and set(bare_words(tree.nodes[found[0]].relation)) & {"with", "for"}:
        found = tree.below(found[0], ("f", "l"), "OBJECT")
    pair = list(dict.fromkeys(found))
    return pair if len(pair) == 2 else []


def _place_of(thing: PhysicalObject) -> Place:
    yaw = float(thing.trajectory.yaw[0])
    return square(centre(thing.prism), yaw, thing.prism.z_min)


def _aside(thing: PhysicalObject, state: State) -> Place | None:
    """Return a free place on the ground beside a thing, or beside what it stands on."""
    spots = spots_about((thing,), state)
    spots += [
        s for o in state.context.objects if o.id != thing.id for s in spots_about((o,), state)
    ]
    low = [spot for spot in spots if spot.prism.z_min < ground(state) + LEVEL_M]
    free = are_free(low, state, None)
    middle = centre(thing.prism)
    allowed = [spot for spot, is_free in zip(low, free, strict=True) if is_free]
    return min(allowed, key=lambda s: float(abs(centre(s.prism) - middle).sum()), default=None)
