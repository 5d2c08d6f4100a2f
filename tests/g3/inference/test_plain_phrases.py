"""Phrases in other words than a plain phrase are understood."""

import numpy as np
import pytest

from tests.g3.inference.following_commands import did, end_of, under, world


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("how", ["on the ground by the truck", "on the floor next to the truck"])
def test_on_the_ground_by_the_truck_is_by_the_truck(how, side, widely_trained):
    yard = world(
        tires_1=("tire-pallet", (9, -7 * side)),
        truck_1=("truck", (8, 9 * side)),
        cone_1=("cone", (12, -10 * side)),
    )
    found = widely_trained.follow(f"Pick up the tires and put them {how}", yard, least=0.0)
    assert did(found)[-1][1] == "tires-1"
    assert under(found, "tires-1") is None
    assert np.linalg.norm(end_of(found, "tires-1") - (8, 9 * side)) < 5


def test_nothing_stands_on_the_truck_that_has_nothing_on_it(widely_trained):
    yard = world(
        "tires-1",
        tires_1=("tire-pallet",),
        truck_1=("truck", (10, 9)),
        truck_2=("truck", (10, -9)),
        crate_1=("crate", (8.5, -9), 0, "truck-2"),
    )
    text = "Put the tires on the truck that doesn't have anything on it"
    assert under(widely_trained.follow(text, yard), "tires-1") == "truck-1"
