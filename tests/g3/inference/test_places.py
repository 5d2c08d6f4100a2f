"""What words say about places."""

from dataclasses import replace

import numpy as np
import pytest

from g3.actions.grounding_candidates import carrier, square
from g3.actions.robot_state import start_state
from g3.groundings import Context, Place
from g3.inference.potentials.cases import SpotCase
from g3.inference.potentials.meant import UNLIKELY
from g3.inference.potentials.place_rules import on_ground
from g3.inference.potentials.potential_registry import allowed
from g3.inference.problem.command_tree import Tree
from g3.inference.search.arguments import arguments
from g3.inference.search.thing_search import ground_place, ground_places
from g3.sdc.sdc_notation import parse_brackets
from tests.g3.inference.following_commands import under, world
from tests.g3.inference.ruled import WEIGHT, of_examples, of_groups, problem_in, tree_of
from tests.worlds import robot, scene, thing

MISPLACED, OFF_LINE = WEIGHT["place-side"], WEIGHT["row-line"]

# The robot stands at the origin and looks along +x; a row of pallets is to its right.
ROW = [thing(name, "pallet", 3, -y) for name, y in (("a", 4), ("b", 7), ("c", 10))]
TRUCK = thing("truck", "trailer", 20, 0, (4, 6), (0, 1))
OTHER = thing("other", "trailer", -20, 0, (4, 6), (0, 1))
BOXES = thing("boxes", "box pallet", 20, 0, z=(1, 2))
STATE = start_state(Context("yard", (TRUCK, OTHER, BOXES, *ROW, robot()), (), "robot"))


def spot(x, y, bottom=0.0):
    return square(np.array([x, y], dtype=float), 0.0, bottom)


def of_places(name, places, world, **roles):
    return of_examples(name, world, "PLACE", places, "PLACE(f = there)", **roles)


PLACES = {"right": spot(3, -12.2), "left": spot(3, -1.8), "near": spot(2, -1), "far": spot(4, -13)}


@pytest.mark.parametrize(
    ("relation", "landmark", "meant"),
    [
        # The right of a pallet goes on along its row, for who faces that.
        ("to the right of", ROW[1:2], "right far"),
        ("to the left of", ROW[1:2], "left near"),
        # Its front is the side of who speaks.
        ("in front of", ROW[1:2], "left near"),
        ("behind", ROW[1:2], "right far"),
        # The right of several things is beyond all of them.
        ("to the right of", ROW, "right far"),
        ("to the right of", [*ROW, thing("d", "pallet", 3, -15)], ""),
        ("next to", ROW[1:2], "right left near far"),
    ],
)
def test_sides_of_things_are_those_of_who_looks_at_them(relation, landmark, meant):
    world = scene(*ROW, agent=robot())
    cost = of_places("place-side", PLACES.values(), world, relation=relation, landmark=landmark)
    assert set(cost) <= {0.0, MISPLACED}
    assert {name for name, c in zip(PLACES, cost, strict=True) if c == 0} == set(meant.split())


def test_a_row_is_faced_straight_on_from_wherever_the_robot_stands():
    world, places = scene(*ROW, agent=robot()), (spot(3, -6.2), spot(1, -4.5))
    cost = of_places("place-side", places, world, relation="right of", landmark=ROW[:1])
    assert cost.tolist() == [0, MISPLACED]


def test_the_robot_has_its_own_sides():
    agent = robot()
    world = scene(*ROW, agent=agent)
    places = [spot(4, 0), spot(-4, 0), spot(0, -4)]
    for relation, meant in (("in front of", 0), ("behind", 1), ("to the right of", 2)):
        cost = of_places("place-side", places, world, relation=relation, landmark=(agent,))
        assert np.flatnonzero(cost == 0).tolist() == [meant]


@pytest.mark.parametrize(
    ("place", "beside", "on_top"),
    [
        ("PLACE(r = closer to, l = OBJ(f = the truck))", True, False),
        ("PLACE(r = on, l = OBJ(f = the ground))", True, False),
        ("PLACE(r = on, l = OBJ(f = the truck))", False, True),
        ("PLACE(r = on the left side of, l = OBJ(f = the truck))", False, False),
    ],
)
def test_beside_a_truck_is_not_on_it(place, beside, on_top):
    (sdc,) = parse_brackets(place)
    assert on_ground(sdc, sdc) is beside
    world = scene(TRUCK, agent=robot())
    places = (spot(20, 0, 1), spot(15, 0))
    costs = [MISPLACED if beside else 0, MISPLACED if on_top else 0]
    names = ("floor", "on-top")
    found = sum(of_examples(n, world, "PLACE", places, place, landmark=(TRUCK,)) for n in names)
    assert found.tolist() == costs


def free(places, load):
    found = allowed(SpotCase(around(load=load), places))
    return [place for place, is_free in zip(places, found, strict=True) if is_free]


def test_a_load_goes_where_there_is_room_and_it_has_not_stood():
    places = [spot(20, 1.5, 1), spot(-20, 0, 1), spot(3, -4), spot(3, 0)]
    assert carrier(STATE, "boxes").id == "truck"
    assert carrier(STATE, "a") is None
    assert free(places, "boxes") == [places[1], places[3]]
    # The boxes take up the middle of the truck.
    assert free([spot(20, 0, 1), *places], "a") == [places[1], places[3]]


def around(**options):
    return problem_in(STATE.context, **options)


def test_places_that_name_one_place_together_are_one():
    tree = tree_of(
        "EVENT(r = Put, l = OBJ(f = it), l2 = [PLACE(r = on, l = OBJ(f = the ground)), "
        "PLACE(r = behind, l = OBJ(f = the truck))])"
    )
    places = tree.below(0, ("l2",), "PLACE")
    best = ground_places(tree, places, around())[0]
    assert set(places) <= set(best.nodes)
    assert {best.nodes[n][0] for n in places} == {best.group}
    assert best.group[0].prism.z_min == 0


def test_there_is_what_an_earlier_clause_led_to_and_on_it_rather_than_beside_it():
    tree = tree_of("EVENT(r = Put, l = OBJ(f = it), l2 = PLACE(f = there))")
    found = arguments(tree, 0, around(goals=((OTHER,), (TRUCK,)))).goals
    best = found[0].group[0].prism
    assert best.z_min == 1
    assert best.xy.mean(axis=0)[0] == pytest.approx(20, abs=4)


def test_what_is_carried_is_no_landmark_and_the_other_truck_is_not_the_one_it_is_on():
    put = "EVENT(r = Put, l = OBJ(f = the boxes), l2 = PLACE(r = on, l = OBJ(f = the other truck)))"
    tree = tree_of(put)
    (mark,) = (n for n, sdc in enumerate(tree.nodes) if "other" in [w.text for w in sdc.words])
    best = ground_places(tree, tree.below(0, ("l2",), "PLACE"), around(load="boxes"))[0]
    assert best.nodes[mark][0] not in ((BOXES,), (TRUCK,))
    spoken = around(load="a", spoken=frozenset({"truck"}))
    best = ground_places(tree, tree.below(0, ("l2",), "PLACE"), spoken)[0]
    assert best.nodes[mark][0] not in ((ROW[0],), (TRUCK,))


@pytest.mark.parametrize(
    ("relation", "landmark", "costs"),
    [
        # In line with the row, before it, between two of it.
        ("next to", ROW[1:2], (0, OFF_LINE, 0)),
        ("near", ROW[1:2], (0, 0, 0)),
        ("at the end of", ROW, (0, OFF_LINE, 0)),
        ("to the right of", ROW, (0, OFF_LINE, 0)),
    ],
)
def test_places_by_a_row_are_in_line_with_it(relation, landmark, costs):
    world = scene(*ROW, agent=robot())
    places = (spot(3, -12.2), spot(1, -7), spot(3, -8.5))
    roles = {"relation": relation, "landmark": landmark}
    found = sum(of_places(name, places, world, **roles) for name in ("next-in-row", "row-line"))
    assert found == pytest.approx(np.array(costs))


def test_between_things_is_on_the_way_from_one_to_the_other():
    pair = (thing("a", "pallet", 4, 6), thing("b", "pallet", 4, -4))
    world = scene(*pair, agent=robot())
    places = (spot(4, 1), spot(5.5, 0), spot(7.5, 1), spot(4, 9))
    astray = WEIGHT["place-between"]
    # The second one is six of ten metres from the first thing, so a fifth of half the way off.
    for landmark, costs in ((pair, [0, 0.2 * astray, astray, astray]), (pair[:1], [astray] * 4)):
        roles = {"relation": "between", "landmark": landmark}
        assert of_places("place-between", places, world, **roles) == pytest.approx(np.array(costs))
    assert not of_places("place-between", places, world, relation="near", landmark=pair).any()


def test_what_has_no_place_is_put_down_ahead_rather_than_aside():
    world = scene(*ROW, agent=robot())
    places = [spot(x, y) for x, y in ((3, 0), (0, 3), (-3, 0))]
    cost = sum(of_places(name, places, world) for name in ("near", "ahead"))
    assert cost == pytest.approx(-0.6 - np.arange(3))


def test_what_is_set_down_is_set_down_where_the_robot_was_sent():
    tree = tree_of("EVENT(r = Set down, l = OBJ(f = it))")
    goals = arguments(tree, 0, around(load="a", goals=((TRUCK,),))).goals
    assert {goal.group[0].prism.z_min for goal in goals} == {1.0}
    assert arguments(tree, 0, around(load="a")).goals == (None,)


def test_a_path_between_two_things_is_between_both():
    tree = tree_of(
        "EVENT(r = Drive, l = PATH(r = between, l = [OBJ(f = the pallet), OBJ(f = the truck)]))"
    )
    objects = [n for n, sdc in enumerate(tree.nodes) if sdc.type == "OBJECT" and sdc.words]
    answers = dict(zip(objects, (("a",), ("truck",)), strict=True))
    assert {t.id for t in arguments(tree, 0, around(answers=answers)).goals[0].group} == {
        "truck",
        "a",
    }


def test_a_pallet_is_no_place_but_the_floor_is():
    pallet, floor = "OBJ(f = the pallet)", "OBJ(f = the ground)"
    named = [(Place(spot(5, 5).prism),), (Place(spot(5, 5).prism, "dock"),)]
    assert of_groups("no-place", pallet, named, around()).tolist() == [UNLIKELY, UNLIKELY]
    assert not of_groups("no-place", floor, named[:1], around()).any()


def test_closer_to_something_is_on_the_way_there_from_where_the_load_is():
    tree = tree_of("PLACE(r = a bit closer to, l = OBJ(f = the truck))")
    beam = ground_place(tree, 0, around(load="a", answers={1: ("truck",)}))
    # From (3, -4) to (20, 0), three and six metres on.
    middles = [c.group[0].prism.xy.mean(axis=0) for c in beam]
    assert middles == [pytest.approx(m, abs=0.01) for m in ((5.92, -3.31), (8.84, -2.63))]


def test_nothing_is_put_where_the_robot_is_while_it_has_the_load():
    spots = [spot(0, 0), spot(4, 3)]
    assert free(spots, "boxes") == spots
    problem = replace(around(load="boxes"), state=replace(STATE, held="boxes"))
    assert allowed(SpotCase(problem, spots)).tolist() == [False, True]


def test_this_pallet_is_one_that_was_spoken_of():
    this, groups = "OBJ(f = this pallet)", [(thing,) for thing in ROW[:2]]
    problem = around(spoken=frozenset({"a"}))
    assert of_groups("spoken-of", this, groups, problem).tolist() == [0, UNLIKELY]
    assert not of_groups("spoken-of", this, groups, around()).any()


def test_the_one_names_the_same_thing_again():
    tree = tree_of(
        "EVENT(r = Lift, l = [OBJ(f = the pallet), "
        "OBJ(f = OBJ(f = the one), r = on, l = OBJ(f = the right))])"
    )
    found = arguments(tree, 0, around())
    assert found.goals == (None,)
    assert set(tree.below(0, ("l",), "OBJECT")) <= set(found.themes[0].nodes)


def test_the_pallet_is_the_one_on_the_forks():
    tree = tree_of("EVENT(r = Put down, l = OBJ(f = the pallet))")
    assert arguments(tree, 0, around(load="b", held="b")).themes[0].group == (ROW[1],)


def test_a_path_beside_something_leads_to_a_place():
    path = "PATH(r = beside, l = OBJ(f = the truck))"
    tree = tree_of(f"EVENT(r = Put, l = OBJ(f = it), l2 = {path})")
    found = arguments(tree, 0, around())
    assert found.goal_path == -1
    assert all(isinstance(goal.group[0], Place) for goal in found.goals)


def test_two_metres_to_the_right_is_counted_from_where_the_load_is():
    (sdc,) = parse_brackets("PLACE(r = two metres to the right)")
    tree = Tree((sdc,))
    # The boxes are 20 m ahead of the robot, on the truck.
    best = ground_place(tree, 0, around(load="boxes"))[0].group[0].prism.xy.mean(axis=0)
    assert best == pytest.approx((20, -6), abs=0.01)
    robot_itself = ground_place(tree, 0, around())[0].group[0].prism.xy.mean(axis=0)
    assert robot_itself == pytest.approx((0, -4), abs=0.01)


@pytest.mark.parametrize("text", ["take it to the berm, set it down there", "put it by the mound"])
def test_nothing_is_put_on_a_heap(text, grounder):
    yard = world(boxes=("box-pallet", (8, 2)), berm=("berm", (18, -6)))
    result = grounder.follow(f"Grab the boxes, {text}.", yard, least=0.0)
    assert under(result, "boxes") is None


@pytest.mark.parametrize(
    "text", ["Stack the crate on the boxes", "Lift the crate, stack it on the boxes"]
)
def test_who_stacks_puts_on_top(text, grounder):
    yard = world(boxes=("box-pallet", (6, 3)), crate=("crate", (7, -6)), truck=("truck", (16, -7)))
    result = grounder.follow(text, yard, least=0.0)
    assert under(result, "crate") == "boxes"
