"""The two passes: the beam against exhaustive search, states between actions, and pronouns."""

from dataclasses import replace

import numpy as np
import pytest

from g3.actions.action_kinds import Action, Focus, move, possible_actions, result
from g3.actions.forklift_actions import BACK_UP, CARRY, PICK_UP, PUT_DOWN
from g3.actions.grounding_candidates import object_groups, square
from g3.actions.robot_state import centres, start_state
from g3.geometry.footprints import centre
from g3.groundings import Prism
from g3.inference.problem.costs import RandomCost, Scorer
from g3.inference.problem.grounding_problem import Candidate, GroundingProblem
from g3.inference.problem.packed_scene import scene_of
from g3.inference.search.thing_search import ground_thing, likely
from tests.g3.inference.constant_cost import ConstantCost
from tests.g3.inference.exact import best_groundings
from tests.g3.inference.ruled import tree_of


def surroundings(context, cost, **options):
    state = start_state(context)
    return GroundingProblem(state, scene_of(state.context), cost, **options)


@pytest.mark.parametrize("learned", [True, False])
@pytest.mark.parametrize(
    "notation",
    [
        "OBJ(f = the tire pallet)",
        "OBJ(f = the leftmost pallet)",
        "OBJ(f = OBJ(f = the pallet), r = of, l = OBJ(f = tires))",
        "OBJ(f = OBJ(f = the pallet), r = on the right of, l = OBJ(f = the boxes))",
    ],
)
def test_the_wide_beam_finds_what_exhaustive_search_finds(notation, learned, model, dock):
    cost = Scorer(model) if learned else ConstantCost()
    few = (*dock.objects[:4], dock.agent)
    tree = tree_of(notation)
    problem = surroundings(replace(dock, objects=few), cost, width=100, landmarks=100)
    score, groundings = best_groundings(tree, 0, problem)
    found = ground_thing(tree, 0, problem)[0]
    assert found.score == pytest.approx(score)
    assert {n: group for n, (group, _) in found.nodes.items()} == groundings


def test_candidates_with_equal_scores_keep_the_order_of_the_context(dock):
    problem = surroundings(dock, ConstantCost())
    tree = tree_of("OBJ(f = the pallet)")
    singles = [c.group[0].id for c in ground_thing(tree, 0, problem) if len(c.group) == 1]
    assert singles == [o.id for o in dock.objects][: len(singles)]


def test_random_costs_are_the_same_when_asked_again(dock):
    tree = tree_of("OBJ(f = the pallet)")
    first, second = (ground_thing(tree, 0, surroundings(dock, RandomCost(1))) for _ in range(2))
    assert [c.score for c in first] == [c.score for c in second]


def test_a_loaded_fork_picks_nothing_up(dock):
    state = start_state(dock)
    focus = Focus(themes=("tires-2", "boxes-1"), has_theme=True)
    pick = Action(PICK_UP, "tires-2")
    assert pick in possible_actions(state, focus)
    after = result(state, pick, move(state, [pick]), 0)
    assert after.held == "tires-2"
    kinds = {a.kind for a in possible_actions(after, focus)}
    assert PUT_DOWN in kinds
    assert not kinds & {PICK_UP, CARRY}


def test_a_load_goes_with_the_robot_and_stays_where_it_is_put_down(dock):
    state = start_state(dock)
    pick = Action(PICK_UP, "tires-2")
    held = result(state, pick, move(state, [pick]), 0)
    back = Action(BACK_UP, amount=-4.0)
    backed = result(held, back, move(held, [back]), 0)
    way = backed.pose[:2] - held.pose[:2]
    moved = backed.thing("tires-2").prism.xy - held.thing("tires-2").prism.xy
    assert np.linalg.norm(way) == pytest.approx(4.0)
    assert np.allclose(moved, way)
    spot = square(held.pose[:2] + np.array([0.0, 8.0]), 0.0, 0.0)
    put = Action(PUT_DOWN, "tires-2", place=spot)
    down = result(held, put, move(held, [put]), 0)
    assert down.held is None
    assert np.allclose(
        down.thing("tires-2").prism.xy.mean(axis=0), spot.prism.xy.mean(axis=0), atol=1e-6
    )
    assert down.thing("tires-2").prism.z_min == pytest.approx(0.0, abs=1e-9)


def test_the_robot_starts_every_candidate_where_it_is(dock):
    state = start_state(dock)
    focus = Focus(("tires-1",), ((state.thing("trailer-1"),),), has_theme=True)
    actions = possible_actions(state, focus)
    motion = move(state, actions)
    assert np.allclose(motion.xyz[:, 0, :2], state.pose[:2])
    assert (np.diff(motion.t, axis=1) >= -1e-9).all()


def test_groups_are_of_things_alike(dock):
    groups = object_groups(dock)
    for group in groups:
        labels = [set(getattr(g, "labels", ())) for g in group]
        assert len(group) == 1 or set.intersection(*labels)


def test_middles_of_footprints_together_are_those_one_by_one(dock):
    box = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]])
    prisms = [Prism(box, 0.0, 1.0), Prism(box[:3], 0.0, 1.0), *(o.prism for o in dock.objects)]
    assert centres(prisms) == pytest.approx(np.array([centre(p) for p in prisms]))
    assert centres([]).shape == (0, 2)


def test_what_is_far_behind_the_best_is_not_tried():
    beam = [Candidate((), score, {}) for score in (-1.0, -2.0, -7.5, -8.0)]
    assert likely(beam, 4) == beam[:2]
    assert likely(beam, 1) == beam[:1]
    assert likely([], 4) == []
