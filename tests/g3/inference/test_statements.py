"""Sentences that ask for nothing are not carried out."""

import numpy as np
import pytest

from tests.g3.inference.following_commands import did, under, world


@pytest.mark.parametrize(
    "text",
    [
        "There are two crates. Pick up the left one.",
        "Forklift, pick up the left crate.",
        "Operator, pick up the left crate.",
        "There are two crates on the cone. Pick up the left one.",
        "See the cone over there? Never mind. Pick up the left crate, thank you.",
        "Pick up the left crate pls, the boss has no time.",
    ],
)
def test_nothing_is_done_about_a_statement(text, widely_trained):
    yard = world(crate_1=("crate", (9, 4)), crate_2=("crate", (9, -4)), cone_1=("cone", (15, 0)))
    assert did(widely_trained.follow(text, yard, least=0.0)) == [("pick up", "crate-1")]


def test_a_thing_that_is_named_first_is_spoken_of(widely_trained):
    yard = world(crate_1=("crate", (9, 6)), truck_1=("truck", (15, -6)))
    found = widely_trained.follow("Truck, drive to it", yard, least=0.0)
    assert np.linalg.norm(found.plan.state.pose[:2] - (15, -6)) < np.hypot(15, 6) / 2


@pytest.mark.parametrize(
    "text",
    [
        "Set the crate you're holding on the trailer",
        "put the crate that you have down on the trailer",
    ],
)
def test_the_load_that_the_robot_is_holding(text, widely_trained):
    yard = world(
        "crate-1",
        crate_1=("crate",),
        crate_2=("crate", (9, 5)),
        trailer_1=("trailer", (13, -6)),
    )
    assert under(widely_trained.follow(text, yard, least=0.0), "crate-1") == "trailer-1"
