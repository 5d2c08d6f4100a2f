"""Arguments of a top-level clause: candidates of its theme and goal, and their combinations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from g3.actions.action_kinds import Action, Focus
from g3.actions.grounding_candidates import ground, square
from g3.actions.robot_state import State, is_load
from g3.features.bodies import IntArray
from g3.geometry.footprints import centre
from g3.groundings import PhysicalObject, Place
from g3.inference.potentials.cases import ReferentCase
from g3.inference.potentials.potential_registry import added
from g3.inference.problem.asked_kinds import amounts_said, asked_kinds, puts_here, returns
from g3.inference.problem.clause_roles import is_goal, is_source, tells_place
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.frames import Frame, frame, leads_aboard
from g3.inference.problem.grounding_problem import Arguments, Candidate, GroundingProblem, things_of
from g3.inference.problem.packed_scene import Group
from g3.inference.search.requests import at_source
from g3.inference.search.thing_search import (
    as_argument,
    ground_argument,
    ground_place,
    ground_places,
    ground_thing,
    landmarks_of,
    likely,
    reached,
)
from g3.language.discourse.groups import noun_words
from g3.language.lexicon.field_words import field_words
from g3.language.lexicon.tables import WORDS
from g3.short_repr import short_repr

THEMES, GOALS, PATH_LANDMARKS = 5, 6, 3
FEW_THEMES, FEW_GOALS = 2, 2
"""Numbers of themes and goals that are tried with actions that involve neither."""


@short_repr
@dataclass(frozen=True, slots=True)
class Rows:
    """Combinations of an action, a theme and a goal, as indices; -1 for none; each (n,)."""

    action: IntArray
    theme: IntArray
    goal: IntArray


def arguments(tree: Tree, root: int, problem: GroundingProblem) -> Arguments:
    """Ground what a top-level clause is about."""
    asked, amounts = asked_kinds(tree, root), amounts_said(tree, root)
    if tree.nodes[root].type == "PATH":
        marks = _marks(tree, root, problem, GOALS)
        return Arguments((None,), marks, root, {}, problem, problem, asked, amounts)
    own = frame(tree, root)
    free = replace(problem, load=None, told_side="")
    if returns(tree, root):
        start = Candidate((_start(problem.state),), 0.0, {})
        return Arguments((None,), (start,), -1, {}, free, free, asked, amounts)
    themes, left = _themes(tree, own, free)
    if puts_here(tree, own) and problem.held is not None:
        spot = Candidate((_under(problem.held, problem.state),), 0.0, {})
        return Arguments(themes, (spot,), -1, {}, free, free, asked, amounts)
    toward = replace(problem, load=problem.load or _load(themes, problem.state))
    if leads_aboard(tree, own, problem.state.context.agent.labels):
        return Arguments(themes, (None,), -1, {}, free, toward, asked, amounts)
    goals, goal_path = _goals(tree, own, toward, to_be_put=bool(themes[0]))
    if goals == (None,) and goal_path < 0 and left:
        goals = tuple(likely(ground_thing(tree, left[0], free), GOALS))
    if own.down or (goals == (None,) and own.leaves_open):
        goals = tuple(likely(reached(tree, root, toward), GOALS)) or goals
    others = {way: _marks(tree, way, free, PATH_LANDMARKS) for way in own.ways if way != goal_path}
    return Arguments(themes, goals, goal_path, others, free, toward, asked, amounts)


def _start(state: State) -> Place:
    """Return the place where the robot is when a command is given."""
    x, y, yaw = state.pose.tolist()
    return square(np.array([x, y]), yaw, ground(state))


def _under(load: str, state: State) -> Place:
    """Return the place on the ground under a load on the forks."""
    return square(centre(state.thing(load).prism), float(state.pose[2]), ground(state))


def _themes(
    tree: Tree, own: Frame, problem: GroundingProblem
) -> tuple[tuple[Candidate | None, ...], Sequence[int]]:
    """Return candidates of the theme, the first OBJECT of a clause, and the other OBJECTs."""
    if not own.objects:
        return (_unnamed(tree, own, problem) if own.takes_unnamed else ()) or (None,), ()
    theme, *left = own.objects
    if problem.held is not None:  # of all things, so that what is on the forks is among them
        problem = replace(problem, width=max(problem.width, len(problem.scene.groups)))
    beam = ground_thing(tree, theme, problem)
    there = at_source(tree, own, problem)
    beam = [c for c in beam if there.intersection(t.id for t in things_of(c.group))] or beam
    if own.empties and problem.held is None:
        beam = _emptied(beam, problem)
    if left and noun_words(tree.nodes[left[0]])[-1:] == ["one"]:
        beam = _same(beam, ground_thing(tree, left.pop(0), problem))
    beam = as_argument(beam, tree, theme, problem, role="theme", within=own.node)
    found = likely([c for c in beam if len(c.group) == 1] or beam, THEMES)
    held = [problem.held]
    on_forks = [c for c in beam if [t.id for t in things_of(c.group)] == held and c not in found]
    return (*found, *on_forks), left


def _emptied(beam: Sequence[Candidate], problem: GroundingProblem) -> list[Candidate]:
    """Replace each thing by the things that stand on it: "unload the truck"."""
    state = problem.state
    loads: dict[str, list[PhysicalObject]] = {}
    for upper, lower in problem.carriers.items():
        if is_load(state, upper):
            loads.setdefault(lower, []).append(state.thing(upper))
    found = []
    for c in beam:
        ids = [thing.id for thing in things_of(c.group)]
        on = [load for name in ids for load in loads.get(name, ()) if not is_load(state, name)]
        found += [replace(c, group=(load,)) for load in on] or [c]
    return found


def _unnamed(tree: Tree, own: Frame, problem: GroundingProblem) -> tuple[Candidate, ...]:
    """Return candidates of a load that isn't named: one mentioned before, or any load.

    "Drive to the pallet and pick up" means that pallet.
    """
    state = problem.state
    if problem.held is not None:
        return ()
    groups = tuple((thing,) for thing in state.context.objects if is_load(state, thing.id))
    scores = added(ReferentCase(tree, own.node, problem, groups, is_theme=True))
    found = [Candidate(g, float(x), {}) for g, x in zip(groups, scores, strict=True)]
    return tuple(likely(sorted(found, key=lambda c: -c.score), THEMES))


def _goals(
    tree: Tree, own: Frame, problem: GroundingProblem, *, to_be_put: bool
) -> tuple[tuple[Candidate | None, ...], int]:
    """Return candidates of an EVENT's goal, and the PATH that names it, -1 if none does."""
    goals: tuple[Candidate | None, ...] = (None,)
    path = -1
    if own.places:
        return tuple(likely(ground_places(tree, own.places, problem), GOALS)), -1
    paths = [tree.nodes[p] for p in own.paths]
    if own.end is not None and not any(is_goal(p) and p.landmark1 for p in paths):  # "to the left"
        return tuple(likely(ground_thing(tree, own.end, problem), GOALS)), -1
    for path in own.paths:
        if to_be_put and tells_place(tree.nodes[path]):
            return tuple(likely(ground_place(tree, path, problem), GOALS)), -1
        goals = _marks(tree, path, problem, GOALS)
        if goals != (None,):
            break
    return goals, path


def _same(beam: Sequence[Candidate], again: Sequence[Candidate]) -> list[Candidate]:
    """Return candidates that two OBJECTs name: "the pallet ahead, the one on the right"."""
    joined = [
        Candidate(a.group, a.score + b.score, {**a.nodes, **b.nodes})
        for a in beam
        for b in again
        if [id(g) for g in a.group] == [id(g) for g in b.group]
    ]
    return sorted(joined, key=lambda c: -c.score) or list(beam)


def _load(themes: Sequence[Candidate | None], state: State) -> str | None:
    """Return the id of the load that a clause moves with its best theme; None for no load."""
    thing = themes[0].group[0] if themes[0] else None
    if not isinstance(thing, PhysicalObject) or not is_load(state, thing.id):
        return None
    return thing.id


def _marks(
    tree: Tree, path: int, problem: GroundingProblem, count: int
) -> tuple[Candidate | None, ...]:
    """Return candidates of a PATH's landmark."""
    children = tree.below(path, ("f", "l", "l2"), "OBJECT", "PLACE")
    if not children:
        return (None,)
    sdc = tree.nodes[path]
    between = WORDS["between"].intersection(field_words(sdc.relation))
    if len(children) > 1 and between and not is_source(sdc):
        return tuple(landmarks_of(tree, path, problem)[:count])
    beam = ground_argument(tree, children[0], problem, role="goal", within=path)
    return tuple(likely(beam, count))


def focus_of(state: State, found: Arguments) -> Focus:
    """Return the things and places that the actions for a clause may be about."""
    named = [c for c in found.themes if c is not None]
    ids = [
        g.id
        for c in named
        for g in c.group[:1]
        if isinstance(g, PhysicalObject) and g.id != state.context.agent_id
    ]
    goals = tuple(current(c.group, state) for c in found.goals if c is not None)
    marks = [current(c.group, state) for cs in found.paths.values() for c in cs[:2] if c]
    return Focus(
        tuple(dict.fromkeys(ids)), goals, bool(ids), tuple(marks), found.asked, found.amounts
    )


def current(group: Group, state: State) -> Group:
    """Return the things of a group at their present poses."""
    return tuple(state.thing(g.id) if isinstance(g, PhysicalObject) else g for g in group)


def combine(state: State, actions: Sequence[Action], found: Arguments) -> Rows:
    """Return all valid combinations: an action on an object has it as the theme."""
    rows: list[tuple[int, int, int]] = []
    theme_of = {
        c.group[0].id: i
        for i, c in reversed(list(enumerate(found.themes)))
        if c is not None and isinstance(c.group[0], PhysicalObject)
    }
    some_goals = range(len(found.goals)) if found.goals != (None,) else (-1,)
    few_themes = range(min(FEW_THEMES, len(found.themes))) if found.themes != (None,) else (-1,)
    for i, action in enumerate(actions):
        goals = (action.goal,) if action.goal >= 0 else tuple(some_goals)[:FEW_GOALS]
        if action.object_id:
            themes: Sequence[int] = (theme_of.get(action.object_id, -1),)
        elif len(action.target) == 1 and isinstance(action.target[0], PhysicalObject):
            own = theme_of.get(action.target[0].id)
            themes = (own,) if own is not None and action.goal < 0 else tuple(few_themes)
        else:
            themes = tuple(few_themes)
        rows += [(i, t, g) for t in themes for g in goals]
    table = np.array(rows, dtype=np.intp).reshape(-1, 3)
    return Rows(table[:, 0], table[:, 1], table[:, 2])
