"""Examples of EVENTs and PATHs in the search's own space of actions.

The corpus grounds each EVENT and PATH of a command to the whole log (section 4.1). At inference
each top-level clause has an action of its own, which starts where the one before it ended. So the
log is shared out among the clauses: those about the object that the log moves, or about where it
goes, pick it up and put it down; a log that only drives belongs to the last clause. A clause's
other actions in the same state, those that surely do something else, are its negatives; clauses
that nothing is known of have no examples.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from g3.actions.action_kinds import (
    Action,
    ActionKind,
    Focus,
    kind_that,
    move,
    possible_actions,
    result,
)
from g3.actions.forklift_actions import CARRY, DRIVE_TO, PICK_UP, PUT_DOWN
from g3.actions.grounding_candidates import beneath, footprint_of, ground, square
from g3.actions.logged_actions import NOTHING, Handling, end_of, handling, moved, recorded
from g3.actions.robot_state import State, start_state
from g3.annotation import Annotation
from g3.geometry.footprints import centre
from g3.geometry.plane import point_gap
from g3.groundings import Grounding, Path, PhysicalObject, Place
from g3.inference.problem.clause_roles import goal_paths
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.frames import asked
from g3.inference.problem.grounding_problem import Arguments, Candidate
from g3.inference.problem.packed_scene import Group
from g3.inference.search.arguments import combine
from g3.inference.search.stage import Trial, event_batch, path_batch
from g3.learning.factor_matrix import Labelled
from g3.negatives.wrongness import AWAY_M, other_actions
from g3.short_repr import short_repr

NEGATIVES = 14
"""Wrong actions that are taken for each right one."""
OTHER_LANDMARKS = 3


@short_repr
@dataclass(frozen=True, slots=True)
class Log:
    """What a context's log does.

    Parameters
    ----------
    handling
        What it does to its load.
    load
        Id of what it moves; empty if nothing.
    place
        Where the load ends.
    end
        Where the robot ends, as a place.
    """

    handling: Handling
    load: str
    place: Place
    end: Place


def log_of(state: State, annotation: Annotation) -> Log:
    """Look at what the log does."""
    log = recorded(annotation.context)
    done = handling(annotation.context)
    ids = sorted(moved(log))
    load = state.held if state.held in ids else (ids[0] if ids else "")
    track = log.agent.trajectory
    end = square(track.xyz[-1, :2], float(track.yaw[-1]), ground(state))
    place = end
    if load:
        thing = next(o for o in log.objects if o.id == load)
        rise = thing.trajectory.xyz[-1, 2] - thing.trajectory.xyz[0, 2]
        bottom = thing.prism.z_min + float(rise)
        place = square(end_of(thing), float(thing.trajectory.yaw[-1]), bottom)
        under = beneath(place, state, load)
        level = ground(state) if under is None else under.prism.z_max
        place = square(end_of(thing), float(thing.trajectory.yaw[-1]), level)
    return Log(done, load or "", place, end)


def action_examples(annotation: Annotation, rng: np.random.Generator) -> Iterator[Labelled]:
    """Labelled factors of a positive annotation's EVENTs and PATHs."""
    tree = Tree(annotation.sdcs)
    state = start_state(annotation.context)
    log = log_of(state, annotation)
    roots = [n for n in asked(tree) if tree.nodes[n].type in ("EVENT", "PATH")]
    for root, action in _shared_out(tree, roots, annotation, state, log):
        found = _annotated(tree, root, annotation)
        focus = _focus(state, found, rng)
        tried = possible_actions(state, focus)
        if action is None:
            rights, wrong = _on_the_way(annotation, tried)
        else:
            rights = _rights(action, tried, state, log)
            wrong = other_actions(tried, action, state)
        if len(wrong) > NEGATIVES:
            wrong = [wrong[i] for i in sorted(_spread(wrong, rng))]
        if rights or wrong:
            goal = 0 if found.goals != (None,) else -1
            actions = [replace(a, goal=goal) for a in (*rights, *wrong)]
            rows = combine(state, actions, found)
            trial = Trial(tree, root, state, found, actions, rows)
            yield from _labelled(trial, annotation, rows.action < len(rights))
        if action is not None:
            state = result(state, action, move(state, [action]), 0)


def _focus(state: State, found: Arguments, rng: np.random.Generator) -> Focus:
    """What a clause is about, and a few other things to drive to."""
    theme = found.themes[0]
    ids = tuple(
        g.id
        for g in (theme.group[:1] if theme else ())
        if isinstance(g, PhysicalObject) and g.id != state.context.agent_id
    )
    goals: tuple[Group, ...] = tuple(c.group for c in found.goals if c)
    marks = tuple(c.group for cs in found.paths.values() for c in cs if c)
    return Focus(ids, goals, theme is not None, (*marks, *_others(state, goals, rng)))


def _on_the_way(
    annotation: Annotation, tried: Sequence[Action]
) -> tuple[list[Action], list[Action]]:
    """For a clause that another clause's action follows or goes before: what it may be.

    It handles nothing. It drives to its goal if the log comes there.
    """
    track = annotation.context.agent.trajectory.xyz[:, :2]
    rights = [
        a
        for a in tried
        if a.kind is DRIVE_TO
        and a.goal >= 0
        and float(point_gap(track[None], footprint_of(a.target)[None]).min()) < AWAY_M
    ]
    return rights, [a for a in tried if a.kind.handles]


def _shared_out(
    tree: Tree, roots: Sequence[int], annotation: Annotation, state: State, log: Log
) -> list[tuple[int, Action | None]]:
    """Which part of the log each clause is about; None where that isn't known."""
    own = [r for r in roots if _is_about(tree, r, annotation, log)]
    parts: dict[int, Action] = {}
    if log.handling == NOTHING:
        last = own[-1] if own else roots[-1] if roots else -1
        parts[last] = Action(DRIVE_TO, target=(log.end,))
    elif log.handling == CARRY.handling and len(own) > 1:
        parts[own[0]] = Action(PICK_UP, log.load)
        parts[own[-1]] = Action(PUT_DOWN, log.load, place=log.place)
    elif own or len(roots) == 1:
        last = own[-1] if own else roots[-1]
        place = log.place if log.handling.leaves else None
        parts[last] = Action(kind_that(log.handling), log.load, place=place)
    return [(r, parts.get(r)) for r in roots]


def _is_about(tree: Tree, root: int, annotation: Annotation, log: Log) -> bool:
    things = [
        g
        for n in tree.below(root, ("l", "l2"), "OBJECT")
        for g in annotation.groundings[n]
        if isinstance(g, PhysicalObject) and g.id != annotation.context.agent_id
    ]
    goal = tree.below(root, ("l", "l2"), "PLACE", "PATH")
    if log.handling == NOTHING:
        return bool(goal) or bool(things)
    if things:
        return any(g.id == log.load for g in things)
    return bool(tree.below(root, ("l", "l2"), "PLACE")) and log.handling.leaves


def _annotated(tree: Tree, root: int, annotation: Annotation) -> Arguments:
    """The annotated groundings as the only candidates."""

    def given(nodes: Sequence[int]) -> tuple[Candidate | None, ...]:
        things = [g for n in nodes for g in annotation.groundings[n] if not isinstance(g, Path)]
        return (Candidate(tuple(things), 0.0, {}),) if things else (None,)

    def marks(path: int) -> tuple[Candidate | None, ...]:
        return given(tree.below(path, ("f", "l", "l2"), "OBJECT", "PLACE")[:1])

    if tree.nodes[root].type == "PATH":
        return Arguments((None,), marks(root), root, {})
    objects = tree.below(root, ("l", "l2"), "OBJECT")
    places = tree.below(root, ("l", "l2"), "PLACE")
    paths = tree.below(root, ("l", "l2"), "PATH")
    themes = given(objects[:1])
    goals: tuple[Candidate | None, ...] = (None,)
    goal_path = -1
    if places:
        goals = given(places[:1])
    elif goal_paths(tree, root):
        for path in goal_paths(tree, root):
            goals, goal_path = marks(path), path
            if goals != (None,):
                break
    elif len(objects) > 1:
        goals = given(objects[1:2])
    others = {p: marks(p) for p in paths if p != goal_path}
    return Arguments(themes, goals, goal_path, others)


def _labelled(
    trial: Trial, annotation: Annotation, correct: npt.NDArray[np.bool_]
) -> Iterator[Labelled]:
    tree, found = trial.tree, trial.found
    batch, stage, _ = event_batch(trial)
    if tree.nodes[trial.root].type == "EVENT":
        yield Labelled(annotation, batch, correct)
    for path, marks_of in {found.goal_path: found.goals, **found.paths}.items():
        if path < 0 or marks_of == (None,) or marks_of[0] is None:
            continue
        bodies, index = stage.scene.indices([marks_of[0].group])
        if len(bodies.z_min) > len(stage.scene.bodies.z_min) and path != found.goal_path:
            continue
        landmark = batch.goal if path == found.goal_path else np.full(len(batch), index[0])
        of_path = path_batch(tree, path, stage, batch.figure, landmark)
        yield Labelled(annotation, of_path, correct)


def _rights(right: Action, tried: Sequence[Action], state: State, log: Log) -> list[Action]:
    """The right action; for driving those of the search's that end where the log does."""
    if log.handling != NOTHING:
        return [right]
    drives = [a for a in tried if a.kind.aims]
    if not drives:
        return [right]
    motion = move(state, drives)
    ends = np.linalg.norm(motion.xyz[:, -1, :2] - centre(log.end.prism), axis=1)
    near = [drives[i] for i in np.argsort(ends, kind="stable")[:2] if ends[i] < AWAY_M]
    return near or [right]


def _others(state: State, goals: Sequence[Group], rng: np.random.Generator) -> list[Group]:
    """A few other things to drive to."""
    meant = {g.id for group in goals for g in group if isinstance(g, PhysicalObject)}
    things: list[Grounding] = [
        o
        for o in state.context.objects
        if o.id not in meant and o.id not in (state.context.agent_id, state.held)
    ]
    return [(things[i],) for i in rng.permutation(len(things))[:OTHER_LANDMARKS]]


def _spread(actions: Sequence[Action], rng: np.random.Generator) -> list[int]:
    """A draw of actions in which each kind has its share."""
    order = rng.permutation(len(actions))
    seen: dict[ActionKind, int] = {}
    rank = []
    for i in order:
        seen[actions[i].kind] = seen.get(actions[i].kind, 0) + 1
        rank.append((seen[actions[i].kind], int(i)))
    return [i for _, i in sorted(rank)[:NEGATIVES]]
