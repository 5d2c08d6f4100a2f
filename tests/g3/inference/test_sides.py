"""What words single out among things alike."""

import numpy as np
import pytest

from g3.actions.arrangements import facing
from tests.g3.inference.following_commands import did, under, world
from tests.g3.inference.ruled import WEIGHT, of_sides
from tests.worlds import robot, thing

# The robot stands at the origin and looks along +x; +y is to its left.
AHEAD = [thing("a", "pallet", 8, 6), thing("b", "pallet", 8, 0), thing("c", "pallet", 8, -6)]
BEHIND = [thing("a", "pallet", -8, 6), thing("b", "pallet", -8, 0), thing("c", "pallet", -8, -6)]
DEEP = [thing("a", "pallet", 6, 1), thing("b", "pallet", 11, 0), thing("c", "pallet", 16, 1)]
WIDE = [thing("a", "trailer", 9, -4), thing("b", "trailer", -9, 4)]
AROUND = [thing("a", "trailer", 9, 1), thing("b", "trailer", -9, 1)]


def singled_out(things, words, relation="", landmark=None):
    """The ids of the things that cost nothing; a relation is one to the robot if to nothing."""
    agent = robot()
    cost = of_sides(things, agent, words, relation, landmark or ((agent,) if relation else ()))
    assert set(cost) <= {0.0, WEIGHT["side"], 2 * WEIGHT["side"]}
    return "".join(t.id for t, c in zip(things, cost, strict=True) if c == 0)


@pytest.mark.parametrize(
    ("things", "words", "meant"),
    [
        (AHEAD, "the leftmost pallet", "a"),
        (AHEAD, "the pallet on the far right", "c"),
        (AHEAD, "the second pallet from the right", "b"),
        (AHEAD, "the third pallet from the left", "c"),
        # The left of a row behind the robot is that of who has turned to it.
        (BEHIND, "the leftmost pallet", "c"),
        (BEHIND, "the first pallet from the left", "c"),
        (AHEAD, "the middle pallet", "b"),
        (DEEP, "the pallet in the back", "c"),
        (DEEP, "the rear pallet", "c"),
        (AHEAD, "the pallet", "abc"),
        # Of things all around people speak as they stand.
        (AROUND, "the trailer behind", "b"),
        (AROUND, "the trailer ahead", "a"),
        # Right and left of what is ahead and behind nearly in line is anybody's guess.
        (AROUND, "the trailer on the left", "ab"),
        (WIDE, "the trailer on the left", "b"),
    ],
)
def test_words_single_out_one_of_things_alike(things, words, meant):
    assert singled_out(things, words) == meant


def test_a_relation_to_the_robot_singles_out():
    assert singled_out(AROUND, "the trailer", "behind") == "b"
    assert singled_out(AROUND, "the trailer", "in front of") == "a"


def test_the_left_of_a_row_is_one_of_the_row():
    assert singled_out(AHEAD, "the pallet", "on the left side of", AHEAD) == "a"
    assert singled_out(AHEAD, "the pallet", "on the left side of", AROUND[:1]) == "abc"


@pytest.mark.parametrize(
    ("own", "others", "ahead", "all_around"),
    [
        # A row aside is faced straight on, two things behind by their middle.
        ((0.0, 5.0), [(-2.0, 5.0), (2.0, 5.0)], (0.0, 1.0), False),
        ((-4.0, 4.0), [(-4.0, -4.0)], (-1.0, 0.0), False),
        ((9.0, 1.0), [(-9.0, 1.0)], (1.0, 0.0), True),
    ],
)
def test_rows_are_faced_straight_on_and_what_is_all_around_is_not(own, others, ahead, all_around):
    every = np.ones((1, len(others)), dtype=bool)
    faced, around = facing(np.array([own]), np.array([others]), every)
    assert faced == pytest.approx(np.array([ahead]))
    assert around.tolist() == [all_around]


TRUCKS = {"truck_1": ("truck", (12, 6), 90), "truck_2": ("truck", (12, -6), 90)}
ABOARD = {
    f"{kind}_{number}": (f"{kind}-pallet", (12, y), 90, f"truck-{number}")
    for number, kind, y in (
        (1, "tire", 7.2),
        (1, "box", 4.8),
        (2, "bricks", -4.8),
        (2, "generator", -7.2),
    )
}


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize(
    ("text", "lifted"),
    [
        ("Pick up the near crate on the left", "a"),
        ("Lift the farthest crate on the left", "c"),
        ("Lift the closest crate on your right", "d"),
        ("Pick up the far crate on the right", "e"),
    ],
)
def test_near_and_far_are_told_among_what_is_on_a_side(text, lifted, mirrored, grounder):
    places = {"a": (6, 3), "b": (9, 7), "c": (17, 6), "d": (8, -4), "e": (19, -5)}
    side = -1 if mirrored else 1
    yard = world(**{name: ("crate", (x, side * y)) for name, (x, y) in places.items()})
    if mirrored:
        text = text.replace("left", "LEFT").replace("right", "left").replace("LEFT", "right")
    assert did(grounder.follow(text, yard, least=0.0)) == [("pick up", lifted)]


@pytest.mark.parametrize(
    ("text", "action"),
    [
        ("Pick up the right pallet on the left truck", ("pick up", "box-1")),
        ("Take the left pallet off the right truck", ("pick up", "bricks-2")),
    ],
)
def test_sides_are_told_among_what_stands_there(text, action, grounder):
    aside = {"tires": ("tire-pallet", (9, -12)), "boxes": ("box-pallet", (9, 13))}
    yard = world(**TRUCKS, **ABOARD, **aside)
    assert did(grounder.follow(text, yard, least=0.0)) == [action]


@pytest.mark.parametrize(("end", "lifted"), [("right", "generator-2"), ("left", "bricks-2")])
def test_an_end_of_a_truck_is_told_among_what_stands_on_it(end, lifted, grounder):
    there = {name: own for name, own in (TRUCKS | ABOARD).items() if name.endswith("2")}
    yard = world(**there, tires=("tire-pallet", (9, -12)))
    text = f"Lift the item on the {end} end of the truck"
    assert did(grounder.follow(text, yard, least=0.0)) == [("pick up", lifted)]


def test_what_is_to_be_lifted_is_told_among_loads(grounder):
    rows = {f"tires_{n}": ("tire-pallet", (12, 10 - 4 * n)) for n in range(1, 5)}
    yard = world(**rows, flatbed=("flatbed-truck", (6, 14)), trailer=("trailer", (20, 0), 90))
    for number, ordinal in enumerate(("first", "2nd", "third"), start=1):
        lifted = did(grounder.follow(f"pick up the {ordinal} one from the left", yard, least=0.0))
        assert lifted == [("pick up", f"tires-{number}")]


@pytest.mark.parametrize("y", [-3, 0, 3])
@pytest.mark.parametrize("row", ["line", "row"])
def test_the_last_one_in_a_row_is_the_farthest(row, y, grounder):
    boxes = {f"boxes_{n}": ("box-pallet", (1 + 5 * n, y)) for n in range(1, 4)}
    yard = world(**boxes, truck=("truck", (16, -9)), crate=("crate", (7, -8)))
    text = f"Take the last pallet of boxes in the {row} and load it onto the truck."
    result = grounder.follow(text, yard, least=0.0)
    assert under(result, "boxes-3") == "truck"
