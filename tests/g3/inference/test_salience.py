"""Which of several things alike is meant where words say no more than what kind it is."""

import pytest

from g3.examples import to_batch
from g3.inference.phrases import is_bare
from g3.inference.salience import FARTHER, alone_scores, is_alone, near_scores, side_told_scores
from g3.sdc_notation import parse_brackets
from tests.g3.features.scenes import row
from tests.worlds import robot, scene, thing

# The robot stands at the origin and looks along +x; +y is to its left.
AHEAD = thing("ahead", "pallet", 10, 1)
ASIDE = thing("aside", "pallet", 3, 3)
BEHIND = thing("behind", "pallet", -4, 0)
CRATE = thing("crate", "crate", 3, 0)
THINGS = (AHEAD, ASIDE, BEHIND, CRATE)


def rows():
    world = scene(*THINGS, agent=robot())
    return to_batch([row(world, "OBJECT", t, words="the pallet") for t in THINGS[:3]])


def test_a_landmark_is_near_to_what_goes_there_and_not_that_itself():
    batch = rows()
    body = {t.id: int(batch.figure[i]) for i, t in enumerate(THINGS[:3])}
    near_ahead = near_scores(batch, body["ahead"])
    assert near_ahead[1] == 0
    assert near_ahead[2] == FARTHER
    assert near_scores(batch, body["behind"])[:2].tolist() == [FARTHER, 0]


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
    alone = [thing(name, "pallet", x, 0) for name, x in (("a", 3), ("b", 5), ("c", 9))]
    world = scene(*alone, agent=robot())
    batch = to_batch([row(world, "OBJECT", t, words="the lonely pallet") for t in alone])
    assert alone_scores(batch, None).tolist() == [FARTHER, FARTHER, 0]
    # Without the last, which will stand elsewhere, the others are as far from each other.
    assert alone_scores(batch, int(batch.figure[2])).tolist() == [0, 0, 0]


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
    assert side_told_scores(rows(), "left").tolist() == [0, 0, 0]
    assert side_told_scores(rows(), "right").tolist() == [0, FARTHER, 0]
