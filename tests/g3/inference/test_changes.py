"""What it costs to put a load where it stood, or on something where words say otherwise."""

import numpy as np
import pytest

from g3.actions.action_kinds import Action
from g3.actions.forklift_actions import DRIVE_TO, PICK_UP, PUT_DOWN, WAIT
from g3.actions.grounding_candidates import square
from g3.groundings import Context
from g3.inference.potentials.cases import PathCase
from g3.inference.problem.grounding_problem import Candidate
from tests.g3.inference.ruled import WEIGHT, adds, of_actions, problem_in, tree_of
from tests.worlds import robot, thing

UNMOVED = WEIGHT["moved"]

TRUCK = thing("truck", "trailer", 20, 0, (4, 6), (0, 1))
OTHER = thing("other", "trailer", -20, 0, (4, 6), (0, 1))
ON_TRUCK = thing("boxes", "pallet", 20, 0, z=(1, 2))
ON_GROUND = thing("tires", "pallet", 8, 0)
PROBLEM = problem_in(Context("scene", (TRUCK, OTHER, ON_TRUCK, ON_GROUND, robot()), (), "robot"))


def put(load, x, y, bottom):
    place = square(np.array([x, y], dtype=float), 0.0, bottom)
    return Action(PUT_DOWN, load, place=place, goal=0)


@pytest.mark.parametrize(
    ("action", "cost"),
    [
        # Elsewhere on the truck that it is on already, and on the other one.
        (put("boxes", 20, 2, 1), UNMOVED),
        (put("boxes", -20, 0, 1), 0),
        (put("boxes", 20, 4, 0), 0),
        (put("tires", 8.5, 0, 0), UNMOVED),
        (put("tires", 12, 0, 0), 0),
        (Action(DRIVE_TO, target=(TRUCK,)), 0),
    ],
)
def test_nobody_asks_to_put_a_load_where_it_stood(action, cost):
    found = of_actions("moved", "EVENT(r = Put)", [action], problem=PROBLEM)
    assert found.tolist() == [cost]


def test_what_is_taken_off_a_truck_is_on_it_if_anything_is():
    tree = tree_of("PATH(r = off, l = OBJ(f = the truck)); PATH(r = to, l = OBJ(f = the truck))")
    actions = [Action(PICK_UP, "boxes"), Action(PICK_UP, "tires"), Action(WAIT)]
    marks = [Candidate((TRUCK,), 0.0, {}), Candidate((OTHER,), 0.0, {}), None]
    off, to = (PathCase(tree, path, PROBLEM.state, actions, marks, PROBLEM) for path in (0, 1))
    # Nothing stands on the other truck, so "off" may mean that the tires are near it.
    elsewhere = WEIGHT["taken-from"]
    assert adds("taken-from", off).tolist() == [[0, 0, 0], [elsewhere, 0, 0], [0, 0, 0]]
    assert not adds("taken-from", to).any()
    ground = tree_of("PATH(r = from, l = OBJ(f = the ground))")
    off_ground = adds("taken-from", PathCase(ground, 0, PROBLEM.state, actions, marks, PROBLEM))
    assert set(off_ground.ravel()) == {0, elsewhere}
    assert [row.any() for row in off_ground] == [a.object_id in PROBLEM.carriers for a in actions]
