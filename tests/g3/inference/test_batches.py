"""What is done for many candidates at once gives what it gives for each alone."""

from dataclasses import fields, replace

import numpy as np
import pytest

from g3.actions.action_kinds import Action, Focus, move, possible_actions, result
from g3.actions.forklift_actions import PICK_UP
from g3.actions.grounding_candidates import object_groups, spots_about, spots_of_robot
from g3.actions.motions import Motions
from g3.actions.robot_state import start_state
from g3.features.bodies import Bodies, pack
from g3.inference.problem.costs import Scorer
from g3.inference.problem.grounding_problem import GroundingProblem
from g3.inference.problem.packed_scene import pack_like, scene_of
from g3.inference.search.action_search import leaf_scores
from g3.inference.search.thing_search import ground_thing
from tests.g3.inference.ruled import tree_of

THEMES = ("tires-2", "boxes-1")


@pytest.fixture
def state(dock):
    return start_state(dock)


@pytest.mark.parametrize("loaded", [False, True])
def test_actions_go_together_as_they_go_alone(state, loaded):
    if loaded:
        pick = Action(PICK_UP, THEMES[0])
        state = result(state, pick, move(state, [pick]), 0)
    pair = tuple(state.thing(i) for i in THEMES)
    trailer = (state.thing("trailer-1"),)
    place = (spots_of_robot(state)[0],)
    actions = possible_actions(state, Focus(THEMES, (trailer, place, pair), has_theme=True))
    assert len({a.kind for a in actions}) == (8 if loaded else 10)
    together = move(state, actions)
    for row, action in list(enumerate(actions))[::3]:
        alone = move(state, [action])
        for part in fields(Motions):
            expected = getattr(alone, part.name)[0]
            assert getattr(together, part.name)[row] == pytest.approx(expected, abs=1e-9)


def test_nouns_score_together_as_they_score_alone(model, dock, state):
    cost = Scorer(model)
    tree = tree_of(
        "EVENT(r = Put, l = OBJ(f = the tire pallet), l2 = PLACE(r = on, l = OBJ(f = the trailer)))"
    )
    problem = GroundingProblem(state, scene_of(state.context, object_groups(state.context)), cost)
    leaves = leaf_scores(tree, problem.scene, cost)
    assert [" ".join(w.text for w in tree.nodes[n].words) for n in leaves] == [
        "the tire pallet",
        "the trailer",
    ]
    for node in leaves:
        alone = ground_thing(tree, node, problem)
        together = ground_thing(tree, node, replace(problem, leaves=leaves))
        assert [c.group for c in together] == [c.group for c in alone]
        assert [c.score for c in together] == pytest.approx([c.score for c in alone])


PLAIN = [f.name for f in fields(Bodies) if "label" not in f.name]


def test_places_are_packed_as_other_groundings_are(state):
    like = scene_of(state.context).bodies
    spots = [(s,) for s in spots_about((state.thing("trailer-1"),), state)]
    packed, expected = pack_like(spots, like), pack(spots)
    assert packed.label_names == like.label_names
    assert not packed.labels.any()
    assert not packed.shared_labels.any()
    for name in PLAIN:
        np.testing.assert_array_equal(getattr(packed, name), getattr(expected, name), name)


def test_a_scenes_things_are_the_scene_without_groups(state):
    groups = object_groups(state.context)
    given, expected = scene_of(state.context, groups).things(), scene_of(state.context)
    assert groups
    assert given.groups == expected.groups
    assert np.array_equal(given.bodies.labels, expected.bodies.labels)
    for name in PLAIN:
        values, wanted = getattr(given.bodies, name), getattr(expected.bodies, name)
        if name == "corners":
            values = values[:, : wanted.shape[1]]
        np.testing.assert_array_equal(values, wanted, name)
