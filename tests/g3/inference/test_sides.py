"""What words single out among things alike."""

import numpy as np
import pytest

from g3.actions.facing import facing
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
