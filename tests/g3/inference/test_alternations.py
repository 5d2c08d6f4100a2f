"""Commands in other words than a plain clause are carried out."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.g3.inference.following_commands import did, followed, stands_on, world

SPOTS = [(11, 5), (11, -6), (-6, 12), (-7, -11)]


def yard(spots=SPOTS, carries=None, aboard=None):
    """A crate and bricks, a truck and a trailer, each somewhere.

    Parameters
    ----------
    aboard
        What one of the loads stands on.
    """
    crate, bricks, truck, trailer = spots
    if aboard:
        x, y = {"truck-1": truck, "trailer-1": trailer}[aboard]
        bricks = (x - 1, y), 0, aboard
    else:
        bricks = (bricks,)
    return world(
        carries,
        crate_1=("crate",) if carries else ("crate", crate),
        bricks_1=("bricks-pallet", *bricks),
        truck_1=("truck", truck),
        trailer_1=("trailer", trailer),
    )


def end(grounder, text, context):
    """What is done to what, and what that stands on in the end."""
    found = grounder.follow(text, context, least=0.0)
    done, state = did(found), followed(found).state
    moved = done[-1][1]
    return done, stands_on(state, moved) if moved and state.held != moved else None


QUICK = settings(
    max_examples=6, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
spots = st.permutations(SPOTS)


@pytest.mark.parametrize(
    "text",
    [
        "Stock the truck with the crate",
        "Pile the truck with the crate",
        "Crate onto the truck",
        "The crate onto the truck please",
        "Make sure the crate ends up on the truck",
        "Ensure that the crate is on the truck",
        "The truck requires the crate",
        "We want the crate on the truck",
        "Give the crate a ride to the truck",
        "Crates go onto the truck",
        "Crate -> truck",
    ],
)
@QUICK
@given(spots=spots)
def test_what_is_said_otherwise_is_carried(text, spots, grounder):
    assert end(grounder, text, yard(spots)) == ([("carry", "crate-1")], "truck-1")


@pytest.mark.parametrize(
    "text",
    [
        "Unload the trailer",
        "Empty the trailer",
        "Clear the trailer of bricks",
        "Perform a pickup of the bricks",
    ],
)
@QUICK
@given(spots=spots)
def test_what_stands_on_a_trailer_is_taken_off(text, spots, grounder):
    done, under = end(grounder, text, yard(spots, aboard="trailer-1"))
    assert {load for _, load in done} == {"bricks-1"}
    assert under is None  # in the air, or on the ground


@pytest.mark.parametrize(
    "text",
    [
        "Deliver it to the trailer",
        "Transfer the crate to the trailer",
        "Get it on the trailer",
    ],
)
@QUICK
@given(spots=spots)
def test_what_is_sent_is_there_in_the_end(text, spots, grounder):
    assert end(grounder, text, yard(spots, "crate-1")) == (
        [("put down", "crate-1")],
        "trailer-1",
    )


@pytest.mark.parametrize(
    ("text", "amount"),
    [
        ("Make a right turn", -np.pi / 2),
        ("Take a left", np.pi / 2),
        ("Do a quick turn to the left", np.pi / 2),
        ("Perform a U-turn", np.pi),
    ],
)
def test_a_noun_may_say_how_to_turn(text, amount, grounder):
    (action,) = grounder.follow(text, yard(), least=0.0).plan.actions
    assert action.kind.name == "turn"
    assert action.amount == pytest.approx(amount)
