"""Which of several things alike is meant where words say no more than what kind it is."""

import pytest

from g3.inference.potentials.salience import is_alone
from g3.inference.problem.phrases import is_bare
from g3.sdc.sdc_notation import parse_brackets
from tests.g3.inference.ruled import WEIGHT, of_things
from tests.worlds import thing

# The robot stands at the origin and looks along +x; +y is to its left.
AHEAD = thing("ahead", "pallet", 10, 1)
ASIDE = thing("aside", "pallet", 3, 3)
BEHIND = thing("behind", "pallet", -4, 0)
CRATE = thing("crate", "crate", 3, 0)
THINGS = (AHEAD, ASIDE, BEHIND, CRATE)


PALLET = "OBJ(f = the pallet)"


def test_a_landmark_is_near_to_what_goes_there_and_not_that_itself():
    farther = WEIGHT["near-load"]
    near_ahead = of_things("near-load", THINGS, PALLET, load="ahead")
    assert near_ahead[1:3].tolist() == [0, farther]
    near_behind = of_things("near-load", THINGS, PALLET, load="behind")
    assert near_behind[:2].tolist() == [farther, 0]
    # Words that say more than a kind single it out themselves.
    assert not of_things("near-load", THINGS, "OBJ(f = the left pallet)", load="ahead").any()


@pytest.mark.parametrize(
    ("notation", "bare"),
    [
        ("OBJ(f = the pallet)", True),
        ("OBJ(f = OBJ(f = the pallet), r = of, l = OBJ(f = tires))", True),
        ("OBJ(f = the left pallet)", False),
        ("OBJ(f = the second pallet)", False),
        ("OBJ(f = the other pallet)", False),
        ("OBJ(f = the pallets)", False),
        ("OBJ(f = OBJ(f = the pallet), r = near, l = OBJ(f = the truck))", False),
        ("PLACE(f = there)", False),
    ],
)
def test_a_bare_noun_says_nothing_but_a_kind(notation, bare):
    (sdc,) = parse_brackets(notation)
    assert is_bare(sdc) is bare


def test_the_lonely_one_is_furthest_from_its_like():
    things = [thing(name, "pallet", x, 0) for name, x in (("a", 3), ("b", 5), ("c", 9))]
    lonely, dear = "OBJ(f = the lonely pallet)", WEIGHT["alone"]
    assert of_things("alone", things, lonely).tolist() == [dear, dear, 0]
    assert not of_things("alone", things, PALLET).any()
    # Without the last, which will stand elsewhere, the others are as far from each other.
    assert of_things("alone", things, lonely, load="c").tolist() == [0, 0, 0]


@pytest.mark.parametrize(
    ("notation", "alone"),
    [
        ("OBJ(f = the lonely crate)", True),
        ("OBJ(f = OBJ(f = the pallet), r = sitting by, l = OBJ(f = itself))", True),
        ("OBJ(f = OBJ(f = the pallet), r = near, l = OBJ(f = the lonely crate))", False),
    ],
)
def test_words_say_that_a_thing_is_alone(notation, alone):
    (sdc,) = parse_brackets(notation)
    assert is_alone(sdc) is alone


def test_who_swings_left_comes_to_what_is_on_the_left():
    # Nearly ahead and behind is on neither side.
    pallets = THINGS[:3]
    assert of_things("told-side", pallets, PALLET, told_side="left").tolist() == [0, 0, 0]
    told_right = of_things("told-side", pallets, PALLET, told_side="right")
    assert told_right.tolist() == [0, WEIGHT["told-side"], 0]
    named = of_things("told-side", pallets, "OBJ(f = the left pallet)", told_side="right")
    assert not named.any()
