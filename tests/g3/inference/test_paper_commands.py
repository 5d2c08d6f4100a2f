"""The paper's Figure 1, and what it says goes wrong, in worlds where the right plan is plain.

The model has learned from a quarter of the bundled corpus, and hasn't seen these worlds.
"""

import numpy as np
import pytest

from corpus_tools.corpus.annotated_trees import annotated_commands
from eval.judging.judge import judge
from g3.actions.forklift_actions import WAIT
from g3.groundings import object_ids
from g3.language.parsing.parser import parse
from tests.g3.inference.following_commands import BOXES, TIRES, did, end_of, followed, under, world

UNSURE = 0.75
PROBABLE = 0.82
"""A plan that isn't what was meant must be less probable."""


@pytest.fixture(scope="module")
def grounder(widely_trained):
    return widely_trained


def meant(result, text):
    """What a clause is grounded in."""
    return next(object_ids(g.group) for g in followed(result).groundings if g.text == text)


def asked(result):
    """What may be meant by the question."""
    assert result.question is not None
    return {name for name, _ in result.question.options}


# The four commands of Figure 1


def test_the_first_crate_on_the_left(grounder):
    # The left-most of a row, and the nearest of those on the left.
    spots = ((8, 4), (8, 0), (8, -4), (14, 4))
    there = world(**{f"crate_{n}": ("crate", at) for n, at in enumerate(spots, start=1)})
    found = grounder.follow("Go to the first crate on the left and pick it up.", there)
    assert did(found)[-1] == ("pick up", "crate-1")
    assert object_ids(followed(found).actions[0].target) == ("crate-1",)


def test_the_boxes_in_the_middle_go_on_the_trailer_to_the_left(grounder):
    there = world(
        boxes_1=(BOXES, (10, 4)),
        boxes_2=(BOXES, (10, 0)),
        boxes_3=(BOXES, (10, -4)),
        trailer_1=("trailer", (4, 10)),
        trailer_2=("trailer", (4, -10)),
    )
    text = "Pick up the pallet of boxes in the middle and place them on the trailer to the left."
    found = grounder.follow(text, there)
    assert {name for _, name in did(found)} == {"boxes-2"}
    assert under(found, "boxes-2") == "trailer-1"


def test_pallets_are_dropped_to_the_right_of_the_first_tires(grounder):
    there = world("boxes-1", boxes_1=(BOXES,), tires_1=(TIRES, (10, 0)), tires_2=(TIRES, (16, 0)))
    text = "Go forward and drop the pallets to the right of the first set of tires."
    found = grounder.follow(text, there)
    assert did(found) == [("go straight", ""), ("put down", "boxes-1")]
    x, y = end_of(found, "boxes-1")
    assert -4 < y < -1
    assert abs(x - 10) < 2
    assert under(found, "boxes-1") is None


def test_the_tires_off_the_truck_are_set_down(grounder, loaded_truck):
    text = "Pick up the tire pallet off the truck and set it down"
    found = grounder.follow(text, world(**loaded_truck))
    assert {name for _, name in did(found)} == {"tires-1"}
    assert under(found, "tires-1") is None


def test_which_of_two_on_the_truck_is_asked(grounder, loaded_truck):
    there = world(**loaded_truck, tires_2=(TIRES, (10.2, 0), 0, "truck-1"))
    text = "Pick up the tire pallet off the truck and set it down"
    found = grounder.follow(text, there)
    on_truck = {"tires-1", "tires-2"}
    assert asked(found) >= on_truck
    (other,) = on_truck - {name for _, name in did(found)}
    told = grounder.follow(found.sdcs, there, answers={found.question.node: other})
    assert told.question is None
    assert {name for _, name in did(told)} == {other}
    assert under(told, other) is None


# What the paper says works


@pytest.fixture
def yard():
    return world(
        tires_1=(TIRES, (9, -3)),
        boxes_1=(BOXES, (5, -6)),
        truck_1=("truck", (8, 7)),
    )


def test_what_the_paper_follows(grounder, yard):
    on_truck = grounder.follow("Put the tire pallet on the truck", yard)
    assert under(on_truck, "tires-1") == "truck-1"
    lifted = grounder.follow("Pick up the tire pallet", yard)
    assert followed(lifted).state.held == "tires-1"
    lowered = grounder.follow("put down the tire pallet", followed(lifted).state)
    assert under(lowered, "tires-1") is None
    at_truck = grounder.follow("go to the truck", yard)
    assert object_ids(followed(at_truck).actions[0].target) == ("truck-1",)
    for text, load in [("Lift pallet box", "boxes-1"), ("Pick up the pallets of tires", "tires-1")]:
        assert did(grounder.follow(text, yard)) == [("pick up", load)]


# What the paper says goes wrong


def test_left_is_not_taken_for_right(grounder):
    pair = world(tires_1=(TIRES, (9, 3)), tires_2=(TIRES, (9, -3)))
    for text, wanted in [
        ("Pick up the left tire pallet", "tires-1"),
        ("Pick up the right skid of tires", "tires-2"),
        ("Pick up the one on the right", "tires-2"),
    ]:
        assert did(grounder.follow(text, pair)) == [("pick up", wanted)]


@pytest.mark.parametrize("text", ["Pick up the pallet", "Take the goods"])
def test_what_may_be_one_of_several_is_asked(text, grounder):
    pair = world(tires_1=(TIRES, (9, 3)), boxes_1=(BOXES, (9, -3)))
    found = grounder.follow(text, pair)
    assert asked(found) == {"tires-1", "boxes-1"}
    (other,) = asked(found) - {name for _, name in did(found)}
    told = grounder.follow(found.sdcs, pair, answers={found.question.node: other})
    assert did(told) == [("pick up", other)]


def test_misspelt_and_british_words_are_understood(grounder):
    there = world(
        tires_1=(TIRES, (9, 3)), boxes_1=(BOXES, (9, -3)), trailer_1=("trailer", (-4, -8))
    )
    got = grounder.follow("Get the pallet containing tyres", there)
    assert followed(got).state.held == "tires-1"
    gone = grounder.follow("Go to the tailor", there)
    assert meant(gone, "the tailor") == ("trailer-1",)


def test_verbs_that_were_never_seen_are_no_reason_to_refuse(grounder, yard):
    assert did(grounder.follow("Remove the goods", yard))
    (swung,) = followed(grounder.follow("Then swing to the right", yard)).actions
    assert swung.kind.name == "turn"
    assert swung.amount == pytest.approx(-np.pi / 2)
    found = grounder.follow("fly", yard)
    assert found.plan is None
    assert "'fly'" in found.note


def test_ways_without_a_landmark_are_gone(grounder, yard):
    for text, kind, amount in [
        ("swing right", "turn", -np.pi / 2),
        ("turn left", "turn", np.pi / 2),
        ("turn around", "turn", np.pi),
        ("Go forward", "go straight", 4.0),
        ("Back up", "back up", -4.0),
    ]:
        (action,) = followed(grounder.follow(text, yard, least=0.0)).actions
        assert (action.kind.name, action.amount) == (kind, pytest.approx(amount))


def test_who_would_be_loaded_on_a_trailer_handles_nothing(grounder):
    # A forklift can't load itself. Whoever said so had seen it drive up to the trailer.
    there = world(trailer_1=("trailer", (9, -6)), tires_1=(TIRES, (9, 2)))
    found = grounder.follow("Load the forklift onto the trailer", there)
    if found.plan is not None:
        assert object_ids(found.plan.actions[0].target) == ("trailer-1",)
        assert {name for _, name in did(found)} == {""}


@pytest.mark.xfail(reason="a tree has 'closer to the trailer' as a clause of its own", strict=True)
def test_closer_to_the_trailer_is_not_on_it(grounder):
    there = world(
        tires_1=(TIRES, (12, 3)), tires_2=(TIRES, (12, -3)), trailer_1=("trailer", (4, -10))
    )
    text = "Pick up the right skid of tires and place it parallel and a bit closer to the trailer."
    found = grounder.follow(text, there)
    assert {name for _, name in did(found)} == {"tires-2"}
    assert under(found, "tires-2") is None
    trailer = np.array([4, -10])
    before = np.linalg.norm(np.array([12, -3]) - trailer)
    assert np.linalg.norm(end_of(found, "tires-2") - trailer) < before


def test_right_of_the_furthest(grounder):
    there = world("boxes-1", boxes_1=(BOXES,), tires_1=(TIRES, (7, 4)), tires_2=(TIRES, (15, 4)))
    text = "Place the skid of boxes just to the right of the furthest skid of tires."
    x, y = end_of(grounder.follow(text, there), "boxes-1")
    assert abs(x - 15) < 2
    assert 0 < y < 3


def test_between_pallets_and_the_other_trailer(grounder):
    there = world(
        trailer_1=("trailer", (9, 6)),
        tires_1=(TIRES, (8, 6), 0, "trailer-1"),
        boxes_1=(BOXES, (8, -1)),
        boxes_2=(BOXES, (10, -1)),
        trailer_2=("trailer", (9, -9)),
    )
    text = (
        "Take the pallet of tires on the left side of the trailer and place it between "
        "the pallets on the ground and the other trailer."
    )
    found = grounder.follow(text, there)
    assert under(found, "tires-1") is None
    x, y = end_of(found, "tires-1")
    assert -8 < y < -1.5
    assert 6 < x < 12


def test_the_original_spot_is_where_the_robot_was(grounder, yard):
    found = grounder.follow("Go to the tires and move back to your original spot", yard)
    assert np.linalg.norm(found.plan.state.pose[:2]) < 1


@pytest.mark.parametrize("parses", [1, 3])
def test_a_word_that_is_not_understood_is_named_and_makes_less_probable(parses, grounder, yard):
    known = grounder.follow("Drive to the tires", yard, parses=parses)
    found = grounder.follow("Drive parallel to the tires", yard, parses=parses)
    assert not known.note
    assert "'parallel'" in found.note
    assert found.plan.probability < 0.8 * known.plan.probability


# What the paper leaves to later work


def test_negated_commands_do_nothing(grounder, yard):
    found = grounder.follow("Don't pick up the pallet", yard)
    assert [action.kind for action in found.plan.actions] == [WAIT]


def test_it_is_what_was_picked_up(grounder):
    there = world(boxes_1=(BOXES, (9, -3)), truck_1=("truck", (12, 6)))
    found = grounder.follow("Pick up the pallet and put it on the truck", there)
    assert meant(found, "it") == ("boxes-1",)
    assert under(found, "boxes-1") == "truck-1"


@pytest.fixture
def row():
    return world(
        boxes_1=(BOXES, (9, -3)),
        boxes_2=(BOXES, (9, -1)),
        tires_1=(TIRES, (9, 1)),
        truck_1=("truck", (-9, 6)),
    )


def test_a_row_is_several_things(grounder, row):
    (action,) = followed(grounder.follow("Go to the row of pallets", row)).actions
    assert len(action.target) > 1
    assert set(object_ids(action.target)) <= {"boxes-1", "boxes-2", "tires-1"}


def test_one_of_all_is_asked_for_as_the_forks_hold_one(grounder, row):
    found = grounder.follow("Pick up all the pallets", row)
    assert len(asked(found)) > 1


def test_what_is_conditional_is_done_where_it_holds(grounder):
    there = world(boxes_1=(BOXES, (9, -3)), truck_1=("truck", (-9, 6)))
    found = grounder.follow("If there is a pallet, pick it up", there)
    assert followed(found).state.held == "boxes-1"


# The same commands where they were given


@pytest.fixture(scope="module")
def given(published):
    """The published commands by id, annotated, with their worlds."""
    return annotated_commands(published[0].annotations)


def in_its_world(grounder, annotation, **options):
    return grounder.follow(annotation.command.text, annotation.context, least=0.0, **options)


@pytest.mark.parametrize(
    "command",
    [
        # Figure 1: the boxes in the middle; to the right of the first set of tires.
        "put_box_pallet_on_trailer-02",
        "put_down_box_pallet-05",
        # "just to the right of the furthest skid of tires", "the tailor hitch"
        "move_box_pallet_to_storage_e-09",
        # "parallel and a bit closer to the trailer"
        pytest.param(
            "move_tire_pallet-06",
            marks=pytest.mark.xfail(reason="by all words it goes onto it", strict=True),
        ),
    ],
)
def test_what_is_right_where_it_was_given(command, grounder, given):
    there = given[command]
    verdict = judge(there.context, followed(in_its_world(grounder, there)).state)
    assert verdict.correct, verdict.reason


def test_which_tires_on_the_truck_is_not_sure_where_it_was_given(grounder, given):
    # Figure 1: "pick up the tire pallet off the truck". Two are on it; where to isn't told.
    there = given["put_tire_pallet_in_storage1-14"]
    assert followed(in_its_world(grounder, there)).probability < UNSURE
    found = grounder.follow(parse(there.command.text).trees[0].sdcs, there.context, least=0.0)
    assert found.question is not None or followed(found).probability < UNSURE
    (node,) = (g.node for g in followed(found).groundings if g.text == "the tire pallet")
    (name,) = object_ids(there.groundings[node])
    told = grounder.follow(found.sdcs, there.context, answers={node: name})
    assert {acted for _, acted in did(told)} == {name}
    assert under(told, name) is None


def test_which_tyres_is_asked_where_it_was_given(grounder, given):
    # "Get the pallet containing tyres", before four of them.
    there = given["pickup_tire_pallet1-01"]
    found = in_its_world(grounder, there)
    node = found.question.node
    (name,) = object_ids(there.groundings[node])
    assert name in asked(found)
    told = grounder.follow(found.sdcs, there.context, answers={node: name})
    assert judge(there.context, followed(told).state).correct


@pytest.mark.parametrize(
    "command",
    [
        # Figure 1: a tire pallet is called "the first crate on the left".
        pytest.param(
            "pickup_tire_pallet1-03",
            marks=pytest.mark.xfail(reason=".85 is stated: all words agree", strict=True),
        ),
        # "one pallet width forward"; "Remove the goods."
        pytest.param(
            "put_down_box_pallet-09",
            marks=pytest.mark.xfail(reason=".85 is stated: all words agree", strict=True),
        ),
        "put_down_box_pallet-08",
    ],
)
def test_what_is_not_understood_where_it_was_given_is_not_probable(command, grounder, given):
    found = in_its_world(grounder, given[command])
    assert found.plan is None or found.plan.probability < PROBABLE
