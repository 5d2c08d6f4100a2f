"""Places, nouns and loads of earlier words that later ones take up."""

import pytest

from tests.g3.inference.following_commands import BOXES, YARD, did, followed, told, under, world


def where(result):
    """Return the thing that each handled load stands on in the end; None for the ground."""
    handled = {a.object_id for a in followed(result).actions} - {""}
    return {name: under(result, name) for name in handled}


@pytest.mark.parametrize("there", ["there", "on there"])
def test_there_has_room_for_more_than_one_load(there, grounder):
    text = f"Put the near tires on the left truck, then put the near crate {there}"
    result = grounder.follow(text, world(**YARD), least=0.0)
    assert where(result) == {"tires-1": "truck-1", "crate-1": "truck-1"}


def test_there_is_beside_what_was_put_on_the_ground(grounder):
    text = "Put the near tires by the cone, then put the near crate there"
    result = grounder.follow(text, world(**YARD), least=0.0)
    assert where(result) == {"tires-1": None, "crate-1": None}


def test_what_must_not_be_put_somewhere_may_be_put_elsewhere(grounder):
    text = "Don't put the near crate on a truck, put it by the cone"
    assert where(grounder.follow(text, world(**YARD), least=0.0)) == {"crate-1": None}


@pytest.mark.parametrize(
    "text",
    [
        "Don't lift the near crate, and put it by the cone",
        "Don't touch the near crate, take it easy",
        "Don't touch the near crate, it goes on the left truck",
    ],
)
def test_what_must_not_be_handled_is_not_handled_by_a_pronoun(text, grounder):
    result = grounder.follow(text, world(**YARD), least=0.0, insist=True)
    assert "crate-1" not in {load for _, load in did(result)}


def test_what_is_taken_back_is_still_spoken_of(grounder):
    text = "Far crate on the left truck, no, put it by the cone"
    assert where(grounder.follow(text, world(**YARD), least=0.0)) == {"crate-2": None}


def test_ones_are_of_the_kind_that_was_taken_back(grounder):
    text = "The far crates on the left truck, no, the near ones"
    tree = "EVENT(l = OBJ(f = the near ones), l2 = PLACE(r = on, l = OBJ(f = the left truck)))"
    result = grounder.follow(told(text, tree), world(**YARD), least=0.0)
    assert where(result) == {"crate-1": "truck-1"}


@pytest.mark.parametrize(
    ("text", "ends"),
    [
        ("Crates x2 on the left truck", {"crate-1": "truck-1", "crate-2": "truck-1"}),
        ("Put 2 of the crates on the left truck", {"crate-1": "truck-1", "crate-2": "truck-1"}),
        ("Put both crate lots on the left truck", {"crate-1": "truck-1", "crate-2": "truck-1"}),
        (
            "Put the near tires on the left truck and both the crates as well",
            dict.fromkeys(("crate-1", "crate-2", "tires-1"), "truck-1"),
        ),
    ],
)
def test_counts_are_words_and_figures(text, ends, grounder):
    assert where(grounder.follow(text, world(**YARD), least=0.0)) == ends


def test_words_for_another_load_tell_nothing_of_the_first(widely_trained):
    yard = world(fridge_1=("refrigerator-pallet", (9, -4)), **YARD)
    text = "Put the fridge by the cone and the near crate on the left truck"
    assert where(widely_trained.follow(text, yard, least=0.0)) == {
        "fridge-1": None,
        "crate-1": "truck-1",
    }


@pytest.mark.parametrize("to", ["to the cone", "over to the cone"])
@pytest.mark.parametrize("verb", ["Take", "Carry", "Bring", "Deliver"])
def test_the_load_on_the_forks_is_put_down_where_it_is_taken(verb, to, grounder):
    yard = world("boxes-1", boxes_1=(BOXES,), **YARD)
    result = grounder.follow(f"{verb} the boxes {to}", yard, least=0.0)
    assert did(result) == [("put down", "boxes-1")]


@pytest.mark.parametrize("then", ["", " and stay there a minute", " and wait ten seconds"])
@pytest.mark.parametrize(("side", "turn"), [("left", 1), ("right", -1)])
def test_waiting_changes_no_turn(side, turn, then, grounder):
    state = followed(grounder.follow(f"Turn {side}{then}", world(**YARD), least=0.0)).state
    assert state.pose[2] * turn > 1


@pytest.mark.parametrize(
    "text",
    [
        "Hold position",
        "You may stay exactly where you are",
        "Do not go anywhere until the driver arrives",
        "Just wait there a moment",
    ],
)
def test_the_robot_waits_where_it_is(text, grounder):
    assert did(grounder.follow(text, world(**YARD), least=0.0)) == [("wait", "")]
