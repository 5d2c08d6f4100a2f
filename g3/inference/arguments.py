"""What a top-level clause is about: candidates of its theme and goal, and what goes together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from g3.features.bodies import IntArray
from g3.groundings import PhysicalObject
from g3.inference.actions import Action, Focus
from g3.inference.clauses import goal_paths
from g3.inference.proposals import is_load
from g3.inference.scene import Group
from g3.inference.state import State
from g3.inference.things import Candidate, Surroundings, ground_places, ground_thing, likely
from g3.inference.tree import Tree

THEMES, GOALS, PATH_LANDMARKS = 5, 6, 3
FEW_THEMES, FEW_GOALS = 2, 2
"""How many are tried with actions that are about neither."""


@dataclass(frozen=True, slots=True)
class Arguments:
    """Candidates of what a top-level clause is about.

    Parameters
    ----------
    themes, goals
        Candidates of its theme and of its goal; None alone where it has none.
    goal_path
        The PATH whose landmark the goal is, -1 if there is none.
    paths
        Other PATHs with the candidates of their landmarks.
    """

    themes: tuple[Candidate | None, ...]
    goals: tuple[Candidate | None, ...]
    goal_path: int
    paths: Mapping[int, tuple[Candidate | None, ...]]


@dataclass(frozen=True, slots=True)
class Rows:
    """Combinations of an action, a theme and a goal, as indices; -1 for none; each (n,)."""

    action: IntArray
    theme: IntArray
    goal: IntArray


def arguments(tree: Tree, root: int, about: Surroundings) -> Arguments:
    """Ground what a top-level clause is about."""
    kind = tree.nodes[root].type
    if kind == "PATH":
        return Arguments((None,), _marks(tree, root, about, GOALS), root, {})
    objects = tree.below(root, ("l", "l2"), "OBJECT")
    places = tree.below(root, ("l", "l2"), "PLACE")
    paths = tree.below(root, ("l", "l2"), "PATH")
    free = replace(about, load=None)
    themes: tuple[Candidate | None, ...] = (None,)
    if objects:
        beam = ground_thing(tree, objects[0], free)
        themes = tuple(likely([c for c in beam if len(c.group) == 1] or beam, THEMES))
    goals: tuple[Candidate | None, ...] = (None,)
    goal_path = -1
    toward = replace(about, load=about.load or _load(themes, about.state))
    if places:
        goals = tuple(likely(ground_places(tree, places, toward), GOALS))
    elif goal_paths(tree, root):
        for path in goal_paths(tree, root):
            goals = _marks(tree, path, toward, GOALS)
            goal_path = path
            if goals != (None,):
                break
    elif len(objects) > 1:
        goals = tuple(likely(ground_thing(tree, objects[1], free), GOALS))
    others = {p: _marks(tree, p, free, PATH_LANDMARKS) for p in paths if p != goal_path}
    return Arguments(themes, goals, goal_path, others)


def _load(themes: Sequence[Candidate | None], state: State) -> str | None:
    """Id of what a clause moves if it is the best of its themes; None for no load."""
    thing = themes[0].group[0] if themes[0] else None
    if not isinstance(thing, PhysicalObject) or not is_load(state, thing.id):
        return None
    return thing.id


def _marks(tree: Tree, path: int, about: Surroundings, count: int) -> tuple[Candidate | None, ...]:
    """Candidates of a PATH's landmark."""
    children = tree.below(path, ("f", "l", "l2"), "OBJECT", "PLACE")
    if not children:
        return (None,)
    return tuple(likely(ground_thing(tree, children[0], about), count))


def focus_of(state: State, found: Arguments) -> Focus:
    """What the actions for a clause may be about."""
    named = [c for c in found.themes if c is not None]
    ids = [
        g.id
        for c in named
        for g in c.group[:1]
        if isinstance(g, PhysicalObject) and g.id != state.context.agent_id
    ]
    goals = tuple(current(c.group, state) for c in found.goals if c is not None)
    marks = [current(c.group, state) for cs in found.paths.values() for c in cs[:2] if c]
    return Focus(tuple(dict.fromkeys(ids)), goals, bool(named), tuple(marks))


def current(group: Group, state: State) -> Group:
    """The same things where they are now."""
    return tuple(state.thing(g.id) if isinstance(g, PhysicalObject) else g for g in group)


def combine(state: State, actions: Sequence[Action], found: Arguments) -> Rows:
    """All combinations that go together: an action on an object has it as the theme."""
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
