"""Balanced samples, and the chances that items have in them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from eval.plan_study.rating_sample import balanced_sample

SIZES = (5, 1, 2)
CELL = np.repeat(np.arange(3), SIZES)


@pytest.mark.parametrize(
    ("size", "chance"),
    [
        # One of each cell, and one more of the two cells that have more.
        (4, (1.5 / 5, 1.0, 1.5 / 2)),
        # Two of each cell that has them.
        (5, (2 / 5, 1.0, 1.0)),
        # Two cells of three.
        (2, (2 / 3 / 5, 2 / 3, 2 / 3 / 2)),
        (7, (4 / 5, 1.0, 1.0)),
        (8, (1.0, 1.0, 1.0)),
        (100, (1.0, 1.0, 1.0)),
        (0, (0.0, 0.0, 0.0)),
    ],
)
def test_chances_by_hand(size, chance):
    drawn, found = balanced_sample(CELL, size, np.random.default_rng(0))
    assert len(drawn) == len(set(drawn)) == min(size, len(CELL))
    np.testing.assert_allclose(found, np.repeat(chance, SIZES))


def test_items_are_drawn_as_often_as_their_chance_says():
    draws, often = 4000, np.zeros(len(CELL))
    for seed in range(draws):
        drawn, chance = balanced_sample(CELL, 4, np.random.default_rng(seed))
        often[drawn] += 1
    # Five standard errors of a share.
    np.testing.assert_allclose(often / draws, chance, atol=5 * 0.5 / np.sqrt(draws))


@settings(max_examples=50)
@given(st.lists(st.integers(1, 9), min_size=1, max_size=12), st.integers(0, 60), st.integers(0, 9))
def test_cells_give_alike_and_weights_add_up_in_the_mean(sizes, size, seed):
    cell = np.repeat(np.arange(len(sizes)), sizes)
    drawn, chance = balanced_sample(cell, size, np.random.default_rng(seed))
    taken = np.bincount(cell[drawn], minlength=len(sizes))
    assert chance.sum() == pytest.approx(min(size, len(cell))) == len(drawn)
    for number, count in enumerate(sizes):
        # No cell gives two more than another that has more to give.
        assert taken[number] == count or taken[number] >= taken.max() - 1
    again, _ = balanced_sample(cell, size, np.random.default_rng(seed))
    assert (again == drawn).all()
