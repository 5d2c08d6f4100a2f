"""What later clauses say of what was named, reached or handled before them."""

import numpy as np
import pytest

from g3.geometry.footprints import centre
from tests.g3.inference.following_commands import BOXES, TIRES, followed, stands_on, world

CRATE = "crate"
YARD = {"tires": (TIRES, (9, 4)), "boxes": (BOXES, (7, -1)), "truck": ("truck", (2, -13))}
CROSSROADS = {"left": (CRATE, (-10, 6)), "ahead": (CRATE, (8, 9)), "behind": (CRATE, (-3, -12))}


def ends(grounder, text, things, mirrored):
    """The state in the end, and the loads that were handled.

    Parameters
    ----------
    mirrored
        Whether things are on the other side of the robot's x axis than told. Of several wordings
        some are tried on one side and some on the other.
    """
    side = -1 if mirrored else 1
    there = world(**{name: (kind, (x, side * y)) for name, (kind, (x, y)) in things.items()})
    plan = followed(grounder.follow(text, there, least=0.0))
    return plan.state, {a.object_id for a in plan.actions} - {""}


@pytest.mark.parametrize(
    ("text", "mirrored"),
    [
        # What was come to, pointed at; what was handled, by its label and by its number.
        ("Go to the tires, pick up this pallet and put it on the truck", False),
        ("Pick up the tires. Put this pallet on the truck", True),
        ("Pick up the tires, drive past the boxes and put them on the truck", False),
        ("Lift the tires, turn around and set the load on the truck", True),
        ("Take the tires to the truck and put them on the top", False),
    ],
)
def test_what_was_spoken_of_is_put_on_the_truck(text, mirrored, grounder):
    state, handled = ends(grounder, text, YARD, mirrored)
    assert handled == {"tires"}
    assert (state.held, stands_on(state, "tires")) == (None, "truck")


def test_them_and_it_are_told_apart_by_number(grounder):
    text = "Drive to the truck. Pick up the tires and bring them back to it"
    state, handled = ends(grounder, text, YARD, mirrored=False)
    assert handled == {"tires"}
    ends_at = centre((state.thing("tires")).prism)
    assert np.linalg.norm(ends_at - centre(state.thing("truck").prism)) < 6


RIGHT_NEXT = "Pick up the boxes, drive to the tires and put it down right next to them"
BESIDE = "Pick up the boxes, go over to the tires and set them down beside them"


@pytest.mark.parametrize(
    ("text", "mirrored"),
    [
        (RIGHT_NEXT, False),
        (RIGHT_NEXT, True),
        (BESIDE, False),
    ],
)
def test_nothing_is_put_next_to_itself(text, mirrored, grounder):
    state, handled = ends(grounder, text, YARD, mirrored)
    assert handled == {"boxes"}
    ends_at = centre(state.thing("boxes").prism)
    assert np.linalg.norm(ends_at - centre(state.thing("tires").prism)) < 4


TWO = {"tires": (TIRES, (8, 2)), "near": ("truck", (13, 8)), "far": ("truck", (22, -9))}


@pytest.mark.parametrize(
    ("where", "mirrored"), [("on the truck", False), ("on its bed", True), ("on it", False)]
)
def test_the_truck_that_was_driven_to_is_the_truck(where, mirrored, grounder):
    side = "left" if mirrored else "right"
    text = f"Lift the tires. Drive to the truck on the {side}. Put them {where}"
    state, _ = ends(grounder, text, TWO, mirrored)
    assert stands_on(state, "tires") == "far"


@pytest.mark.parametrize(
    ("where", "mirrored"), [("on the ground", False), ("down on the ground there", True)]
)
def test_on_the_ground_is_where_it_was_brought(where, mirrored, grounder):
    text = f"Pick up the tires and take them over to the truck. Set them {where}"
    state, _ = ends(grounder, text, YARD, mirrored)
    ends_at = centre(state.thing("tires").prism)
    assert stands_on(state, "tires") is None
    assert np.linalg.norm(ends_at - centre(state.thing("truck").prism)) < 7


@pytest.mark.parametrize("mirrored", [False, True])
def test_the_one_behind_them_is_another_one(mirrored, grounder):
    yard = {"boxes": (BOXES, (7, 1)), "tires": (TIRES, (12, 1.5)), "crate": (CRATE, (6, -9))}
    text = "Drive around the boxes and pick up the pallet behind them"
    state, _ = ends(grounder, text, yard, mirrored)
    assert state.held == "tires"


@pytest.mark.parametrize(("text", "mirrored"), [("load them up", True), ("load them", False)])
def test_what_was_brought_to_the_truck_is_loaded_onto_it(text, mirrored, grounder):
    text = f"Take the tires over to the truck and {text}"
    state, handled = ends(grounder, text, YARD, mirrored)
    assert handled == {"tires"}
    assert (state.held, stands_on(state, "tires")) == (None, "truck")


def _unresolved(*values: str):
    """A command whose trees leave out the statement that names what "it" is."""
    reason = "plain trees leave out statements, and with them what a pronoun stands for"
    return pytest.param(*values, marks=pytest.mark.xfail(reason=reason, strict=True))


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize(
    ("text", "lifted"),
    [
        ("Turn {side} and pick up the crate on your {side} then", "left"),
        ("Turn {side}, then lift the crate that is now on your {side}", "left"),
        ("Turn {side}. Pick up the crate that will be on your {side}", "left"),
        _unresolved("Turn {side} and you will see a crate on your {side}, lift it", "left"),
        ("turn {side}. there's a crate on your {side}. pick it up", "left"),
        ("Turn {side} and pick up the crate on your {side}", "left"),
        pytest.param(
            "Turn {side} and pick up the crate on your {other} then",
            "ahead",
            marks=pytest.mark.xfail(reason="by all words it is the one there before"),
        ),
        # What was there before it turned, or is told without a turn.
        pytest.param(
            "Turn {side} and take the crate in the back",
            "behind",
            marks=pytest.mark.xfail(reason="'the back' is taken for a thing"),
        ),
        ("Pick up the crate on your {side} then turn {side}", "ahead"),
        ("Raise the forks, then pick up the crate on the {side} now", "ahead"),
    ],
)
def test_a_side_after_a_turn_is_the_one_that_was_turned_to(text, lifted, mirrored, grounder):
    side, other = ("right", "left") if mirrored else ("left", "right")
    text = text.format(side=side, other=other)
    assert ends(grounder, text, CROSSROADS, mirrored)[0].held == lifted


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize(
    ("text", "spots"),
    [
        ("Pick up the crate in the centre", {"a": (9, 4), "meant": (9, 0.5), "b": (9, -4)}),
        ("Pick up the first crate you come to", {"meant": (7, 0), "a": (14, 2), "b": (-12, 4)}),
    ],
)
def test_one_of_several_is_told_by_where_it_is(text, spots, mirrored, grounder):
    things = {name: (CRATE, spot) for name, spot in spots.items()}
    assert ends(grounder, text, things, mirrored)[0].held == "meant"


@pytest.mark.parametrize(
    ("someone", "them", "mirrored"),
    [("person", "him", False), ("fella", "him", True), ("guy", "her", False)],
)
def test_who_is_spoken_of_is_a_person(someone, them, mirrored, grounder):
    things = {"boxes": (BOXES, (9, 1)), "person": ("person", (6, 9)), "truck": ("truck", (17, -5))}
    text = f"Pick up the boxes and take them to the {someone}. Set them down next to {them}."
    state, handled = ends(grounder, text, things, mirrored)
    away = centre(state.thing("boxes").prism) - centre(state.thing("person").prism)
    assert handled == {"boxes"}
    assert np.linalg.norm(away) < 4


@pytest.mark.parametrize(
    ("text", "mirrored"),
    [
        ("Put the far crate on the truck, then go to the near one and lift it", False),
        ("Put the far crate on the truck, go to the near one and pick it up", True),
    ],
)
def test_one_is_of_the_kind_of_what_was_told_apart_so(text, mirrored, grounder):
    yard = {"near": (CRATE, (6, 2)), "far": (CRATE, (14, 6)), "truck": ("truck", (19, -6))}
    state, handled = ends(grounder, text, yard, mirrored)
    assert (handled, state.held) == ({"near", "far"}, "near")
    assert stands_on(state, "far") == "truck"
