"""Which load is meant in worlds where the right plan is plain."""

import pytest

from tests.g3.inference.following_commands import BOXES, did, under, world


@pytest.fixture(scope="module")
def grounder(widely_trained):
    return widely_trained


@pytest.mark.parametrize("noun", ["your load", "the load", "the cargo", "it"])
def test_the_load_on_the_forks_is_put_down(grounder, noun):
    others = {f"boxes_{n}": (BOXES, (10, 3 * n)) for n in range(6)}
    there = world("crate-1", crate_1=("crate",), truck_1=("truck", (8, -8)), **others)
    found = grounder.follow(f"Put {noun} onto the truck", there)
    assert did(found) == [("put down", "crate-1")]
    assert under(found, "crate-1") == "truck-1"


def test_not_on_the_truck_is_elsewhere(grounder, loaded_truck):
    found = grounder.follow("Pick up the tires that are not on the truck", world(**loaded_truck))
    assert did(found) == [("pick up", "tires-3")]


def test_the_farthest_crate_is_the_farthest_of_the_crates(grounder):
    there = world(crate_1=("crate", (6, 6)), crate_2=("crate", (12, 0)), boxes_1=(BOXES, (20, -5)))
    assert did(grounder.follow("Pick up the farthest crate", there)) == [("pick up", "crate-2")]
