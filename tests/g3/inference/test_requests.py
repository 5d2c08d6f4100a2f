"""Commands about several loads, what must not be touched, and going back."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from g3.geometry.footprints import centre
from g3.sdc.sdc_notation import parse_brackets
from tests.g3.inference.following_commands import BOXES, TIRES, did, followed, under, world

YARD = {
    "tires_1": (TIRES, (9, 5)),
    "tires_2": (TIRES, (9, 1)),
    "crate_1": ("crate", (8, -4)),
    "crate_2": ("crate", (8, -8)),
    "crate_3": ("crate", (12, -6)),
    "truck_1": ("truck", (19, -12)),
    "trailer_1": ("trailer", (18, 11)),
    "trailer_2": ("trailer", (18, 4)),
}
CRATES = {"crate-1", "crate-2", "crate-3"}


def where(result):
    """Return the thing that each handled load stands on in the end; None for the ground."""
    handled = {a.object_id for a in followed(result).actions} - {""}
    return {name: under(result, name) for name in handled}


@pytest.mark.parametrize(
    ("text", "ends"),
    [
        ("Put all the crates on the truck", dict.fromkeys(CRATES, "truck-1")),
        ("Put the three crates on the truck", dict.fromkeys(CRATES, "truck-1")),
        ("Pick up the crates and put them on the truck", dict.fromkeys(CRATES, "truck-1")),
        ("Put everything but the tires on the truck", dict.fromkeys(CRATES, "truck-1")),
        (
            "Put both tire pallets on the truck",
            {"tires-1": "truck-1", "tires-2": "truck-1"},
        ),
        ("Put the crates all on the truck", dict.fromkeys(CRATES, "truck-1")),
        ("The crates all go on the truck", dict.fromkeys(CRATES, "truck-1")),
        ("left tires truck", {"tires-1": "truck-1"}),
        ("right tires - truck", {"tires-2": "truck-1"}),
    ],
)
def test_each_load_is_carried_once(text, ends, grounder):
    result = grounder.follow(text, world(**YARD), least=0.0)
    assert where(result) == ends
    carried = [name for kind, name in did(result) if kind in ("carry", "put down")]
    assert sorted(carried) == sorted(ends)


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("Put one of the crates on the truck", 1),
        ("Put two of the crates on the truck", 2),
        ("Two of the three crates must go on the truck", 2),
        ("Put each of the crates on the truck", 3),
    ],
)
def test_so_many_as_are_counted_are_carried(text, count, grounder):
    found = where(grounder.follow(text, world(**YARD), least=0.0))
    assert set(found) <= CRATES
    assert list(found.values()) == ["truck-1"] * count


LADEN = {
    "boxes_1": (BOXES, (18, 7.6), 0, "trailer-1"),
    "boxes_2": (BOXES, (18, 10.2), 0, "trailer-1"),
    "boxes_3": (BOXES, (8, -4)),
    "trailer_1": ("trailer", (18, 9), 90),
    "truck_1": ("truck", (18, -8)),
}


@pytest.mark.parametrize("what", ["all the boxes", "both boxes", "each of the boxes", "everything"])
@pytest.mark.parametrize(
    ("then", "end"),
    [
        ("", None),
        (" and set them on the ground", None),
        (" and put them on the truck", "truck-1"),
    ],
)
def test_what_is_taken_off_is_put_somewhere_one_by_one(what, then, end, grounder):
    result = grounder.follow(f"Take {what} off the trailer{then}", world(**LADEN), least=0.0)
    assert where(result) == {"boxes-1": end, "boxes-2": end}


@pytest.mark.parametrize("text", ["Unload the trailer", "Empty the trailer"])
def test_what_is_unloaded_has_nothing_left_on_it(text, grounder):
    result = grounder.follow(text, world(**LADEN), least=0.0)
    assert where(result) == {"boxes-1": None, "boxes-2": None}


def test_all_go_to_the_same_place_in_the_same_way(grounder):
    result = grounder.follow("Take the crates to the left trailer", world(**YARD), least=0.0)
    assert len(set(where(result).values())) == 1


def test_what_was_moved_is_not_meant_by_the_next_description(grounder):
    text = "The nearest crate to the left trailer, the farthest one to the truck"
    carried = [name for kind, name in did(grounder.follow(text, world(**YARD), least=0.0))]
    assert len(set(carried)) == 2


@pytest.mark.parametrize("noun", ["person", "man", "guy", "worker", "gentleman"])
def test_a_person_is_meant_by_whatever_name(noun, grounder):
    yard = world(
        crate_1=("crate", (9, -4)), truck_1=("truck", (18, 8)), person_1=("person", (15, -3))
    )
    plan = followed(grounder.follow(f"Take the crate to the {noun}", yard, least=0.0))
    at = centre(plan.state.thing("crate-1").prism)
    assert np.linalg.norm(at - (15, -3)) < 6


def test_one_is_put_on_each(grounder):
    found = where(grounder.follow("Put one crate on each trailer", world(**YARD), least=0.0))
    assert set(found) < CRATES
    assert sorted(found.values()) == ["trailer-1", "trailer-2"]


@pytest.mark.parametrize("text", ["one crate on each vehicle", "One crate goes onto each vehicle"])
def test_each_of_what_a_general_noun_names_gets_one(text, grounder):
    found = where(grounder.follow(text, world(**YARD), least=0.0))
    assert sorted(found.values()) == ["trailer-1", "trailer-2", "truck-1"]


MIXED = {
    "boxes_1": (BOXES, (8, 5)),
    "crate_1": ("crate", (9, -5)),
    "tires_1": (TIRES, (18, -9), 0, "trailer-1"),
    "trailer_1": ("trailer", (18, -9)),
    "truck_1": ("truck", (18, 10)),
}


@pytest.mark.parametrize(
    "text",
    [
        "Put everything that is on the ground on the truck",
        "Everything on the ground goes on the truck, got it?",
    ],
)
def test_what_stands_there_is_meant_of_whatever_kind(text, grounder):
    found = where(grounder.follow(text, world(**MIXED), least=0.0))
    assert found == {"boxes-1": "truck-1", "crate-1": "truck-1"}


def test_the_rest_is_not_what_was_carried_before(grounder):
    text = "Put two crates on the truck and the other crate on the left trailer"
    found = where(grounder.follow(text, world(**YARD), least=0.0))
    assert set(found) == CRATES
    assert sorted(found.values()) == ["trailer-1", "truck-1", "truck-1"]


def test_elided_halves_are_carried_out(grounder):
    text = "crates on the truck, tires on the left trailer"
    found = where(grounder.follow(text, world(**YARD), least=0.0))
    assert {n: found.get(n) for n in CRATES} == dict.fromkeys(CRATES, "truck-1")
    assert "trailer-1" in found.values()


def test_what_stands_there_already_stays(grounder):
    things = {**YARD, "crate_1": ("crate", (19, -12), 0, "truck-1")}
    text = "Put all the crates on the truck"
    found = where(grounder.follow(text, world(**things), least=0.0))
    assert found == {"crate-2": "truck-1", "crate-3": "truck-1"}


def test_a_load_without_room_is_named(grounder):
    crates = {f"crate_{i}": ("crate", (6 + 3 * (i % 4), -6 + 3 * (i // 4))) for i in range(9)}
    yard = world(**crates, barrel_1=("barrel", (-15, 0)))
    result = grounder.follow("Put all the crates beside the barrel", yard, least=0.0)
    carried = where(result)
    undone = {name for name in (n.replace("_", "-") for n in crates) if name in result.note}
    assert set(carried.values()) == {None}
    assert carried.keys().isdisjoint(undone)
    assert len(carried) + len(undone) == len(crates)


FORBIDDEN = (
    *("don't touch the crates", "do not move the crates", "never lift the crates"),
    *("leave the crates alone", "the crates must not be moved", "don't pick up any crates"),
)
ORDERS = (
    *("put the tire pallet on the truck", "pick up the boxes", "drive to the trailer"),
    *("put everything on the truck", "take all the pallets to the trailer", "turn left"),
)
SPOTS = [(9, 6), (9, 1), (9, -4), (9, -9), (-8, 10), (-8, -10)]


@given(
    forbidden=st.sampled_from(FORBIDDEN),
    orders=st.lists(st.sampled_from(ORDERS), min_size=1, max_size=2, unique=True),
    place=st.integers(0, 2),
    joint=st.sampled_from([". ", ", ", "; ", " and "]),
    spots=st.permutations(SPOTS),
)
@settings(
    max_examples=20,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
def test_nothing_ruled_out_is_done(forbidden, orders, place, joint, spots, grounder):
    kinds = (TIRES, BOXES, "crate", "crate", "truck", "trailer")
    names = ("tires_1", "boxes_1", "crate_1", "crate_2", "truck_1", "trailer_1")
    yard = world(**{n: (k, spot) for n, k, spot in zip(names, kinds, spots, strict=True)})
    parts = list(orders)
    parts.insert(min(place, len(parts)), forbidden)
    plans = grounder.follow(joint.join(parts), yard, least=0.0).plans
    assert not CRATES.intersection(a.object_id for plan in plans for a in plan.actions)


@pytest.mark.parametrize(
    "text",
    [
        "Don't touch the nearest crate. Put one crate on each trailer",
        "Put the tires and a crate on the truck, but leave the nearest crate alone",
    ],
)
def test_what_is_ruled_out_is_not_one_of_those_that_are_carried(text, grounder):
    nearest = min(CRATES, key=lambda n: np.hypot(*YARD[n.replace("-", "_")][1]))
    plan = followed(grounder.follow(text, world(**YARD), least=0.0))
    handled = {action.object_id for action in plan.actions}
    assert handled & CRATES
    assert nearest not in handled


@pytest.mark.parametrize("verb", ["Move", "Take", "Carry"])
@pytest.mark.parametrize(
    ("ruling", "load"),
    [
        ("{} the bricks to the trailer, not the left ones", "bricks-2"),
        ("{} the bricks to the trailer but not the right ones", "bricks-1"),
        ("Don't touch the left bricks. {} the bricks to the trailer", "bricks-2"),
        ("{} the bricks to the trailer. Don't touch the right ones.", "bricks-1"),
    ],
)
def test_the_one_that_is_not_ruled_out_is_meant(ruling, load, verb, grounder):
    yard = world(
        bricks_1=("bricks-pallet", (8, 4)),
        bricks_2=("bricks-pallet", (8, -3)),
        container_1=("container", (18, 8)),
        trailer_1=("trailer", (20, -12)),
    )
    assert set(where(grounder.follow(ruling.format(verb), yard, least=0.0))) == {load}


@pytest.mark.parametrize("verb", ["", "r = Take, "])
def test_loads_named_side_by_side_are_all_carried(verb, grounder):
    text = "Take crates and tires to the truck"
    loads = "l = [OBJ(f = crates), OBJ(f = tires)]"
    tree = f"EVENT({verb}{loads}, l2 = PATH(r = to, l = OBJ(f = the truck)))"
    found = where(grounder.follow(parse_brackets(tree, command=text), world(**YARD), least=0.0))
    assert found.keys() > CRATES


@pytest.mark.parametrize(
    "text",
    [
        "Go to the truck and come back",
        "To the truck and back here",
        "Over to the truck, then back to your spot",
        "Drive to the left trailer and back to where you are",
        "Drive to the trailer on the left, then return to where you were",
        "Go around the truck and come back here",
        "Put the left tires on the truck, then go back to your starting position",
    ],
)
def test_the_robot_comes_back(text, grounder):
    state = followed(grounder.follow(text, world(**YARD), least=0.0)).state
    assert np.hypot(*state.pose[:2]) < 1.5


@pytest.mark.parametrize("text", ["Go back", "Drive back"])
def test_back_is_a_way_where_nothing_is_before_it(text, grounder):
    assert did(grounder.follow(text, world(**YARD), least=0.0)) == [("back up", "")]


@pytest.mark.parametrize(
    "text", ["Stay where you are", "Wait there", "Stay put", "Remain stationary until noon"]
)
def test_the_robot_stays(text, grounder):
    assert did(grounder.follow(text, world(**YARD), least=0.0)) == [("wait", "")]


def test_back_to_a_thing_is_on_the_way_there(grounder):
    text = "Drive to the truck, then back to the left trailer"
    plan = followed(grounder.follow(text, world(**YARD), least=0.0))
    visited = [thing.id for action in plan.actions for thing in action.target]
    assert visited == ["truck-1", "trailer-1"]


def test_a_thing_that_is_driven_to_on_the_way_is_not_left_out(grounder):
    result = grounder.follow("Drive to the truck and come back here", world(**YARD), least=0.0)
    assert "nothing is done about" not in result.note


def test_what_is_kept_on_the_forks_stays_there(grounder):
    yard = world("crate-1", **{**YARD, "crate_1": ("crate",)})
    result = grounder.follow("Keep hold of the crate", yard, least=0.0)
    assert did(result) == [("wait", "")]


@pytest.mark.parametrize("text", ["Go around the truck", "Do a lap around the truck"])
def test_the_robot_goes_around(text, grounder):
    result = grounder.follow(text, world(**YARD), least=0.0)
    assert did(result) == [("drive around", "")]


@pytest.mark.parametrize(
    "text", ["Swap the tires and the crate", "Switch the crate with the tires, please"]
)
def test_two_loads_change_places(text, grounder):
    spots = {"tires_1": (TIRES, (9, 5)), "crate_1": ("crate", (17, -8), 0, "truck-1")}
    yard = world(**spots, truck_1=("truck", (17, -8)))
    result = grounder.follow(text, yard, least=0.0)
    assert where(result) == {"tires-1": "truck-1", "crate-1": None}
    end = centre(followed(result).state.thing("crate-1").prism)
    assert np.linalg.norm(end - np.array([9, 5])) < 0.5


def test_a_deck_is_filled_from_its_ends_where_many_go_there(grounder):
    crates = {f"crate_{n}": ("crate", (9, 6 - 3 * n)) for n in range(4)}
    yard = world(**crates, trailer_1=("trailer", (20, 12)))
    result = grounder.follow("Put all the crates on the trailer", yard, least=0.0)
    assert where(result) == {f"crate-{n}": "trailer-1" for n in range(4)}


@pytest.mark.parametrize("text", ["Drop it here", "Put the crate down on the spot"])
def test_here_is_where_the_robot_is(text, grounder):
    yard = world("crate-9", crate_9=("crate",), truck_1=("truck", (15, 9)))
    result = grounder.follow(text, yard, least=0.0)
    assert where(result) == {"crate-9": None}
    assert np.linalg.norm(centre(followed(result).state.thing("crate-9").prism)) < 1.5


def test_get_over_to_handles_nothing(grounder):
    result = grounder.follow("Get over to the truck", world(**YARD), least=0.0)
    assert where(result) == {}
    assert np.linalg.norm(followed(result).state.pose[:2] - np.array([19, -12])) < 12
