"""Which of several things alike is meant where words say no more than what kind it is."""

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


def test_the_lonely_one_is_furthest_from_its_like():
    things = [thing(name, "pallet", x, 0) for name, x in (("a", 3), ("b", 5), ("c", 9))]
    lonely, dear = "OBJ(f = the lonely pallet)", WEIGHT["alone"]
    assert of_things("alone", things, lonely).tolist() == [dear, dear, 0]
    assert not of_things("alone", things, PALLET).any()
    # Without the last, which will stand elsewhere, the others are as far from each other.
    assert of_things("alone", things, lonely, load="c").tolist() == [0, 0, 0]


def test_who_swings_left_comes_to_what_is_on_the_left():
    # Nearly ahead and behind is on neither side.
    pallets = THINGS[:3]
    assert of_things("told-side", pallets, PALLET, told_side="left").tolist() == [0, 0, 0]
    told_right = of_things("told-side", pallets, PALLET, told_side="right")
    assert told_right.tolist() == [0, WEIGHT["told-side"], 0]
    named = of_things("told-side", pallets, "OBJ(f = the left pallet)", told_side="right")
    assert not named.any()
