"""Tests that a candidate action is surely wrong for a clause that a log is right for."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from g3.actions.action_kinds import Action, move
from g3.actions.forklift_actions import WAIT
from g3.actions.grounding_candidates import footprint_of
from g3.actions.logged_actions import Outcome, end_of, moved
from g3.actions.robot_state import State
from g3.annotation import Annotation
from g3.geometry.footprints import apart
from g3.geometry.plane import convex_hull, point_gap, rotate, wrap
from g3.groundings import Context, FloatArray, Grounding, Path, PhysicalObject, Place
from g3.sdc.clauses import SDC, Field, breadth_first, child_indices
from g3.short_repr import short_repr

ELSEWHERE_M = 3.0
"""A load put down this far from where the log puts it is somewhere else."""
AWAY_M = 4.0
"""So is an agent that ends this far from where the log ends."""
AT_M = 3.0
"""Distance from a thing's border within which the agent may count as being there."""
LOAD_AT_M = 2.0
"""Distance from a border within which the middle of a load may count as being there."""
PASSING_M = 2.0
SAME_PLACE_M = 2.5
"""Places of the search nearer than this to each other may both be right."""
OTHER_WAY_RAD = np.pi / 4

Thing = PhysicalObject | Place


@short_repr
@dataclass(frozen=True, slots=True)
class Clause:
    """A clause of a positive annotation and what is grounded in it.

    Parameters
    ----------
    things
        Objects and places grounded anywhere below it, without the agent.
    landmarks
        Those of them below its landmark fields.
    themes
        Objects that are direct landmarks of it, without the agent.
    """

    sdc: SDC
    groundings: tuple[Grounding, ...]
    things: tuple[Thing, ...]
    landmarks: tuple[Thing, ...]
    themes: tuple[PhysicalObject, ...]
    context: Context

    @staticmethod
    def of(annotation: Annotation, node: int) -> Clause:
        """Look a clause up by its index in breadth-first order."""
        nodes = list(breadth_first(annotation.sdcs))
        children = child_indices(annotation.sdcs)
        direct = [c for field in ("l", "l2") for c in children[node].get(field, ())]
        figures = children[node].get("f", ())
        landmarks = _things(annotation, below(children, direct))
        themes = _things(annotation, (n for n in direct if nodes[n].type == "OBJECT"))
        return Clause(
            nodes[node],
            annotation.groundings[node],
            (*_things(annotation, below(children, figures)), *landmarks),
            landmarks,
            tuple(g for g in themes if isinstance(g, PhysicalObject)),
            annotation.context,
        )


def below(children: Sequence[Mapping[Field, tuple[int, ...]]], nodes: Iterable[int]) -> list[int]:
    """Return some clauses and all clauses below them."""
    found = list(nodes)
    for n in found:
        found.extend(c for group in children[n].values() for c in group)
    return found


def _things(annotation: Annotation, nodes: Iterable[int]) -> tuple[Thing, ...]:
    agent = annotation.context.agent_id
    return tuple(
        g
        for n in nodes
        for g in annotation.groundings[n]
        if not isinstance(g, Path) and not (isinstance(g, PhysicalObject) and g.id == agent)
    )


def is_wrong(clause: Clause, log: Outcome, action: Outcome) -> bool:
    """Check that an action can't be meant by an EVENT or PATH that a log is right for.

    An EVENT about an object that the log moves is about that object: an action is wrong
    if it leaves the object alone or, where the clause says where to, takes it elsewhere.
    All others are about where the agent goes.
    """
    themes = {g.id for g in clause.themes} & moved(log) if clause.sdc.type == "EVENT" else set()
    if not themes:
        return _goes_elsewhere(clause, log, action)
    if not themes & moved(action):
        return True
    return all(_put_elsewhere(clause, theme, log, action) for theme in sorted(themes))


def other_actions(tried: Sequence[Action], right: Action, state: State) -> list[Action]:
    """Return the actions in a state that a clause can't mean, where that is known.

    Search gives each clause an action of its own, where the corpus gives all clauses of a command
    the whole log. So an action is wrong too that handles another load, handles it in another way,
    or leads elsewhere, for any words of the clause.

    Parameters
    ----------
    right
        Meaning of the clause. If it drives, its target is where it ends.
    """
    if right.kind.handles:
        return [a for a in tried if _handles_otherwise(a, right)]
    drives = [a for a in tried if a.kind is not WAIT and not a.kind.handles]
    ends = move(state, drives).xyz[:, -1, :2] if drives else np.zeros((0, 2))
    goal = footprint_of(right.target).mean(axis=0)
    near = np.linalg.norm(ends - goal, axis=1) <= AWAY_M
    left_out = {id(a) for a, is_near in zip(drives, near, strict=True) if is_near}
    return [a for a in tried if id(a) not in left_out]


def _handles_otherwise(action: Action, right: Action) -> bool:
    if action.kind is not right.kind or action.object_id != right.object_id:
        return True
    if action.place is None or right.place is None:
        return False
    return apart(action.place.prism, right.place.prism) > SAME_PLACE_M


def _put_elsewhere(clause: Clause, theme: str, log: Outcome, action: Outcome) -> bool:
    """Check that a load ends away from its end in the log, and from its named landmark."""
    before, after = (
        end_of(next(o for o in outcome.objects if o.id == theme)) for outcome in (log, action)
    )
    goals = [
        thing
        for thing in clause.things
        if not (isinstance(thing, PhysicalObject) and thing.id == theme)
        and _gap(before, thing) < LOAD_AT_M
    ]
    far = float(np.linalg.norm(after - before)) > ELSEWHERE_M
    return bool(goals) and far and all(_gap(after, goal) > LOAD_AT_M for goal in goals)


def _goes_elsewhere(clause: Clause, log: Outcome, action: Outcome) -> bool:
    """Check that the agent ends elsewhere than in the log, not at the named thing."""
    path = action.agent.trajectory.xyz[:, :2]
    before = log.agent.trajectory.xyz[-1, :2]
    if float(np.linalg.norm(path[-1] - before)) <= AWAY_M:
        return False
    if not clause.things:
        return _goes_another_way(log, action)
    for thing in clause.things:
        if _gap(path[-1], thing) <= AT_M:
            return False
        only_passed = _gap(before, thing) > AWAY_M
        if only_passed and _gaps(path, thing).min() <= PASSING_M:
            return False
    return True


def _goes_another_way(log: Outcome, action: Outcome) -> bool:
    """Check that the agent ends in another direction from the start than in the log."""

    def bearing(outcome: Outcome) -> float:
        track = outcome.agent.trajectory
        net = rotate(track.xyz[-1, :2] - track.xyz[0, :2], -track.yaw[0])
        return float(np.arctan2(net[1], net[0]))

    return bool(abs(wrap(np.array(bearing(log) - bearing(action)))) > OTHER_WAY_RAD)


def _gap(point: FloatArray, thing: Thing) -> float:
    """Distance in metres from a point to a footprint, at the thing's first pose."""
    return float(_gaps(point[None], thing)[0])


def _gaps(points: FloatArray, thing: Thing) -> FloatArray:
    """Return the distances from points (n, 2) to a footprint, in metres."""
    gaps: FloatArray = point_gap(points[None], convex_hull(thing.prism.xy)[None])[0]
    return gaps
