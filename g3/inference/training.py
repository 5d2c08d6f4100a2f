"""Training for inference: a corpus's examples together with those of the search's own space.

OBJECTs and PLACEs learn from the corpus's labelled examples and from the candidates of the first
pass. EVENTs and PATHs learn from the actions of the second pass alone. So each factor is trained on
what it chooses among at inference.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

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
from g3.actions.grounding_candidates import (
    beneath,
    footprint_of,
    ground,
    grounded,
    object_groups,
    spots_about,
    spots_of_robot,
    square,
)
from g3.actions.logged_actions import NOTHING, Handling, end_of, handling, moved, recorded
from g3.actions.robot_state import State, start_state
from g3.annotation import Annotation
from g3.features.feature_registry import FeatureSet, select
from g3.geometry.footprints import centre
from g3.geometry.plane import point_gap
from g3.geometry.relations import OTHER_PLACE_M
from g3.groundings import Grounding, Path, PhysicalObject, Place
from g3.inference.problem.clause_roles import goal_paths
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.frames import asked
from g3.inference.problem.grounding_problem import Arguments, Candidate
from g3.inference.problem.packed_scene import Group, Scene, scene_of
from g3.inference.problem.phrases import factor_type, is_pronoun
from g3.inference.search.arguments import combine
from g3.inference.search.stage import Trial, event_batch, path_batch
from g3.learning.examples import examples
from g3.learning.factor_matrix import (
    FactorMatrix,
    Labelled,
    joined,
    matrix_of_examples,
    matrix_of_labelled,
)
from g3.negatives.hard_negatives import (
    AWAY_M,
    Clause,
    far_places,
    other_actions,
    tells_apart,
)
from g3.short_repr import short_repr

ALIKE, OTHERS, GROUPS, PLACES = 5, 2, 5, 10
"""Negatives of a clause: single things with the right one's labels, other things, groups and
places."""


@dataclass(frozen=True, slots=True)
class _Clause:
    """A clause with its right grounding, wrong ones, and what its landmark is grounded in."""

    annotation: Annotation
    tree: Tree
    node: int
    right: Group
    wrong: Sequence[Group]
    landmark: Group


def thing_examples(
    annotations: Sequence[Annotation], state: State, scene: Scene, rng: np.random.Generator
) -> Iterator[Labelled]:
    """Labelled factors of the OBJECTs and PLACEs of positive annotations of one context.

    Parameters
    ----------
    annotations
        Positive annotations.
    state, scene
        The state that their context starts in, and its things with the groups of them.
    rng
        Draws negatives.
    """
    clauses = [c for a in annotations for c in _clauses(a, state, scene, rng)]
    for kind in ("OBJECT", "PLACE"):
        own = [c for c in clauses if factor_type(c.tree.nodes[c.node]) == kind]
        if own:
            yield _labelled_things(own, scene)


def _clauses(
    annotation: Annotation, state: State, scene: Scene, rng: np.random.Generator
) -> Iterator[_Clause]:
    tree = Tree(annotation.sdcs)
    for node, sdc in enumerate(tree.nodes):
        right = annotation.groundings[node]
        if not right or annotation.correct[node] is not True or is_pronoun(sdc):
            continue
        kind = factor_type(sdc)
        if kind == "OBJECT":
            wrong = _wrong_objects(tree, node, annotation, scene, rng)
        elif kind == "PLACE":
            wrong = _wrong_places(tree, node, annotation, state, rng)
        else:
            continue
        mark = _landmark(tree, node, annotation)
        yield _Clause(annotation, tree, node, _same(scene, right), wrong, _same(scene, mark))


def _labelled_things(clauses: Sequence[_Clause], scene: Scene) -> Labelled:
    figures = [g for c in clauses for g in (c.right, *c.wrong)]
    marks = [c.landmark for c in clauses if c.landmark]
    bodies, index = scene.indices([*figures, *marks])
    mark_of = iter(index[len(figures) :])
    landmark = np.array([next(mark_of) if c.landmark else -1 for c in clauses], dtype=np.intp)
    factor = np.repeat(np.arange(len(clauses)), [1 + len(c.wrong) for c in clauses])
    batch = scene.batch(
        factor_type(clauses[0].tree.nodes[clauses[0].node]),
        [c.tree.words[c.node] for c in clauses],
        factor,
        bodies,
        figure=index[: len(figures)],
        landmark=landmark[factor],
    )
    return Labelled(clauses[0].annotation, batch, np.diff(factor, prepend=-1) > 0)


def _same(scene: Scene, group: Group) -> Group:
    """Return the same things at rest, as the scene has them."""
    at_rest = {o.id: o for o in scene.context.objects}
    return tuple(at_rest[g.id] if isinstance(g, PhysicalObject) else g for g in group)


def _landmark(tree: Tree, node: int, annotation: Annotation) -> Group:
    children = tree.below(node, ("l", "l2"), "OBJECT", "PLACE")
    if not children:
        below = tree.below(node, ("l", "l2"), "PATH")
        children = [c for b in below for c in tree.below(b, ("l", "l2"), "OBJECT", "PLACE")]
    things = [g for c in children for g in annotation.groundings[c] if not isinstance(g, Path)]
    return tuple(things)


def _wrong_objects(
    tree: Tree, node: int, annotation: Annotation, scene: Scene, rng: np.random.Generator
) -> list[Group]:
    right = annotation.groundings[node]
    ids = _ids(right)
    labels = {g.labels for g in right if isinstance(g, PhysicalObject)}
    singles = [g for g in scene.groups if len(g) == 1 and isinstance(g[0], PhysicalObject)]
    alike = [g for g in singles if g[0].labels in labels and not ids & _ids(g)]  # type: ignore[union-attr]
    other = [g for g in singles if g[0].labels not in labels]  # type: ignore[union-attr]
    members = [g for g in singles if len(right) > 1 and ids & _ids(g)]
    groups = [g for g in scene.groups if len(g) > 1 and _ids(g) != ids]
    places = [g for g in scene.groups if isinstance(g[0], Place) and g[0].name]
    if not tells_apart(Clause.of(annotation, node)):
        alike = []
        if len(right) > 1:
            groups = [g for g in groups if not {o.labels for o in g} <= labels]  # type: ignore[union-attr]
    wrong = [*_draw(alike, ALIKE, rng), *_draw(other, OTHERS, rng), *_draw(members, OTHERS, rng)]
    wrong += _draw(groups, GROUPS, rng)
    if isinstance(right[0], PhysicalObject):
        wrong += _draw(places, 1, rng)
    else:
        wrong += _draw([g for g in places if g[0] not in right], OTHERS, rng)
    return wrong


def _wrong_places(
    tree: Tree, node: int, annotation: Annotation, state: State, rng: np.random.Generator
) -> list[Group]:
    mark = _landmark(tree, node, annotation)
    spots = [grounded(p, state) for p in state.context.places]
    spots += [*spots_about(mark, state), *spots_of_robot(state)]
    far = far_places(spots, annotation.groundings[node], OTHER_PLACE_M)
    return _draw([(p,) for p in far], PLACES, rng)


def _ids(group: Group) -> set[str]:
    return {g.id for g in group if isinstance(g, PhysicalObject)}


def _draw(groups: Sequence[Group], count: int, rng: np.random.Generator) -> list[Group]:
    return [groups[i] for i in rng.permutation(len(groups))[:count]]


NEGATIVES = 14
"""Wrong actions that are taken for each right one."""
OTHER_LANDMARKS = 3


@short_repr
@dataclass(frozen=True, slots=True)
class Log:
    """Effects of a context's log.

    Parameters
    ----------
    handling
        Its effect on its load.
    load
        Id of what it moves; empty if nothing.
    place
        The final place of the load.
    end
        The final place of the robot.
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
    """Return the subject of a clause, and a few other things to drive to."""
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
    """Divide the log among clauses; None for an unknown part."""
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
    """Return the annotated groundings as the only candidates."""

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
    """Return the right action; for driving those of the search's that end as the log does."""
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
    """Draw a few other things to drive to."""
    meant = {g.id for group in goals for g in group if isinstance(g, PhysicalObject)}
    things: list[Grounding] = [
        o
        for o in state.context.objects
        if o.id not in meant and o.id not in (state.context.agent_id, state.held)
    ]
    return [(things[i],) for i in rng.permutation(len(things))[:OTHER_LANDMARKS]]


def _spread(actions: Sequence[Action], rng: np.random.Generator) -> list[int]:
    """Draw actions so that each kind has its share."""
    order = rng.permutation(len(actions))
    seen: dict[ActionKind, int] = {}
    rank = []
    for i in order:
        seen[actions[i].kind] = seen.get(actions[i].kind, 0) + 1
        rank.append((seen[actions[i].kind], int(i)))
    return [i for _, i in sorted(rank)[:NEGATIVES]]


TOLERANCE = 0.1
"""Tolerance of a `GroundingModel` that learns from `training_data`; ranking needs no more."""

WHERE = ("avs-intrinsic", "bearing")
"""Sets that places of one scene are chosen by. Of places of all scenes they learn the map."""

OnProgress = Callable[[str, int, int], object]


@dataclass(frozen=True, slots=True)
class _Task:
    """Annotations whose examples are made together, and which context they share, if they do."""

    annotations: Sequence[Annotation]
    number: int | None = None


class Each(Protocol):
    """Applies a function to each task, as :class:`map` does, maybe in several processes."""

    def __call__(
        self, function: Callable[[_Task], FactorMatrix], tasks: Sequence[_Task], /
    ) -> Iterable[FactorMatrix]:
        """Return the function's result for each task, in their order."""


def search_sets(without: Iterable[str] = ()) -> tuple[FeatureSet, ...]:
    """Return the feature sets of models that search, without some."""
    return select(without=without, plus=WHERE)


def training_data(
    annotations: Sequence[Annotation],
    sets: Sequence[FeatureSet],
    *,
    seed: int = 0,
    each: Each = map,
    on_progress: OnProgress | None = None,
) -> FactorMatrix:
    """Collect what a model for inference learns from.

    Parameters
    ----------
    annotations
        Those of a corpus, of all sources.
    sets
        Feature sets.
    seed
        Seed of the negatives; each context draws its own.
    each
        Function that applies another to each of several tasks, and returns the results in order.
    """
    of_context: dict[int, list[Annotation]] = {}
    for annotation in (a for a in annotations if a.source == "positive"):
        of_context.setdefault(id(annotation.context), []).append(annotation)
    tasks = [_Task(annotations), *(_Task(own, i) for i, own in enumerate(of_context.values()))]
    parts: list[FactorMatrix] = []
    for part in each(functools.partial(_part, sets=sets, seed=seed), tasks):
        parts.append(part)
        if on_progress:
            on_progress("trying actions", len(parts), len(tasks))
    return joined(parts, sets)


def _part(task: _Task, *, sets: Sequence[FeatureSet], seed: int) -> FactorMatrix:
    """Return the corpus's examples of OBJECTs and PLACEs, or a context's of the search's own space.

    The matrix says true and false instead of numbers: less to hand over to another process.
    """
    data = _examples(task, sets, seed)
    return replace(data, matrix=data.matrix.astype(np.bool_))


def _examples(task: _Task, sets: Sequence[FeatureSet], seed: int) -> FactorMatrix:
    if task.number is not None:
        rng = np.random.default_rng([seed, task.number])
        labelled = _own(task.annotations, rng)
        return joined([matrix_of_labelled(one, sets) for one in labelled], sets)
    items = [e for e in examples(task.annotations) if e.sdc.type in ("OBJECT", "PLACE")]
    return joined([matrix_of_examples(items, sets)] if items else [], sets)


def _own(positives: Sequence[Annotation], rng: np.random.Generator) -> Iterator[Labelled]:
    """Examples of the search's own space, of annotations of one context."""
    state = start_state(positives[0].context)
    scene = scene_of(state.context, object_groups(state.context))
    yield from thing_examples(positives, state, scene, rng)
    for annotation in positives:
        yield from action_examples(annotation, rng)
