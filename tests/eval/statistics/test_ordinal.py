from __future__ import annotations

import numpy as np
import pytest

from eval.statistics.ordinal import cliffs_delta, cumulative_link

# Copenhagen housing conditions (Madsen 1976; Venables and Ripley, Modern Applied Statistics with
# S, 2002, section 7.3): how many are little, fairly and very satisfied, for low, medium and high
# influence, in towers, apartments, atrium and terraced houses, with little and much contact.
LITTLE_CONTACT = (
    (21, 21, 28, 34, 22, 36, 10, 11, 36),
    (61, 23, 17, 43, 35, 40, 26, 18, 54),
    (13, 9, 10, 8, 8, 12, 6, 7, 9),
    (18, 6, 7, 15, 13, 13, 7, 5, 11),
)
MUCH_CONTACT = (
    (14, 19, 37, 17, 23, 40, 3, 5, 23),
    (78, 46, 43, 48, 45, 86, 15, 25, 62),
    (20, 23, 20, 10, 22, 24, 7, 10, 21),
    (57, 23, 13, 31, 21, 13, 5, 6, 13),
)


def housing():
    rating, predictors = [], []
    for contact, houses in enumerate((LITTLE_CONTACT, MUCH_CONTACT)):
        for house, counts in enumerate(houses):
            for cell, count in enumerate(counts):
                influence, satisfaction = divmod(cell, 3)
                dummies = [influence == 1, influence == 2, house == 1, house == 2, house == 3]
                rating += [satisfaction] * count
                predictors += [[*dummies, contact == 1]] * count
    return np.array(rating), np.array(predictors, dtype=np.float64)


def test_the_published_model():
    """The coefficients that R's documentation of ``polr`` gets."""
    found = cumulative_link(*housing())
    values = [c.value for c in found.coefficients]
    expected = [0.5664, 1.2888, -0.5724, -0.3662, -1.0910, 0.3603]
    np.testing.assert_allclose(values, expected, atol=1e-4)
    np.testing.assert_allclose(found.thresholds, [-0.4961, 0.6907], atol=1e-4)
    np.testing.assert_allclose(
        found.errors, [0.1047, 0.1271, 0.1192, 0.1552, 0.1515, 0.0955], atol=2e-4
    )
    assert found.odds_ratio(5).value == pytest.approx(np.exp(0.3603), abs=1e-3)


def test_clusters_widen_the_bounds():
    """Rows that come four times say no more than once."""
    rng = np.random.default_rng(0)
    x = rng.normal(size=150)
    rating = np.digitize(x + rng.logistic(size=150), [-1, 0, 1])
    one = cumulative_link(rating, x[:, None], np.arange(150))
    four = cumulative_link(np.tile(rating, 4), np.tile(x, 4)[:, None], np.tile(np.arange(150), 4))
    naive = cumulative_link(np.tile(rating, 4), np.tile(x, 4)[:, None])
    assert four.errors[0] == pytest.approx(one.errors[0], rel=0.02)
    assert naive.errors[0] == pytest.approx(one.errors[0] / 2, rel=0.2)


def test_delta_by_hand():
    # Of 3 × 2 pairs four are above, one is below and one is equal.
    assert cliffs_delta(np.array([3, 4, 5]), np.array([2, 4])).value == pytest.approx(3 / 6)
    assert cliffs_delta(np.array([5, 5]), np.array([1])).value == 1.0
    assert cliffs_delta(np.array([2, 3]), np.array([3, 2])).value == 0.0
    assert cliffs_delta(np.array([3, 3]), np.array([3])).value == 0.0
    assert cliffs_delta(np.array([], dtype=int), np.array([3])).reason == "empty class"


@pytest.mark.parametrize(
    ("with_it", "without", "reason"),
    [
        ([4, 5, 5], [1, 1, 2], "separated"),  # none of the one are as low as some of the other
        ([3, 4, 5], [1, 2, 3], "separated"),  # both have threes, which nobody goes beyond
        ([5, 5, 5], [1, 3, 5], "separated"),  # the one always says five
        ([3, 3, 3], [1, 3, 5], ""),  # nobody of the one says anything else, but the others do both
        ([2, 4, 5], [1, 3, 4], ""),
        ([3, 3, 3], [3, 3, 3], "all alike"),
    ],
)
def test_separation_by_hand(with_it, without, reason):
    rating = np.array([*with_it, *without])
    predictor = np.repeat([1.0, 0.0], [len(with_it), len(without)])[:, None]
    found = cumulative_link(rating, predictor)
    assert found.coefficients[0].reason == reason
    assert found.odds_ratio().reason == reason
    assert found.odds_ratio().is_known == (not reason)


def test_separation_by_several_predictors():
    """Neither divides the ratings alone, but their sum does."""
    x = np.array([[0.0, 1.0], [1.0, 0.0], [2.0, 1.0], [1.0, 2.0], [0.0, 3.0], [3.0, 0.0]])
    rating = np.where(x.sum(axis=1) > 2, 4, 1)
    assert cumulative_link(rating, x).coefficients[1].reason == "separated"
    rating[2] = 1
    assert cumulative_link(rating, x[:, :1]).coefficients[0].reason == ""
    twice = np.column_stack([x[:, 0], 2 * x[:, 0]])
    assert cumulative_link(rating, twice).coefficients[0].reason == "singular"
