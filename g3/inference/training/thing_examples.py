"""Examples of OBJECTs and PLACEs in the search's own space of candidates.

The corpus's negatives are single things. At inference there are also groups, and places around
each thing; and what tells the left pallet from the right one is learned from clauses whose
words name more than a kind of thing.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from g3.actions.grounding_candidates import grounded, spots_about, spots_of_robot
from g3.actions.robot_state import State
from g3.annotation import Annotation
from g3.groundings import Path, PhysicalObject, Place
from g3.inference.problem.command_tree import Tree
from g3.inference.problem.packed_scene import Group, Scene
from g3.inference.problem.phrases import factor_type, is_pronoun
from g3.learning.factor_matrix import Labelled
from g3.negatives.negative_things import far_places, tells_apart
from g3.negatives.wrongness import SAME_PLACE_M, Clause

ALIKE, OTHERS, GROUPS, PLACES = 5, 2, 5, 10
"""How many single things with the right one's labels, other things, groups and places are taken as
negatives of a clause."""


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
            yield _labelled(own, scene)


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


def _labelled(clauses: Sequence[_Clause], scene: Scene) -> Labelled:
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
    """The same things at rest, as the scene has them."""
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
    far = far_places(spots, annotation.groundings[node], SAME_PLACE_M)
    return _draw([(p,) for p in far], PLACES, rng)


def _ids(group: Group) -> set[str]:
    return {g.id for g in group if isinstance(g, PhysicalObject)}


def _draw(groups: Sequence[Group], count: int, rng: np.random.Generator) -> list[Group]:
    return [groups[i] for i in rng.permutation(len(groups))[:count]]
