from __future__ import annotations

import numpy as np

from corpus_tools.corpus.rater_agreement import dawid_skene
from eval.statistics.ratings import majorities

# Dawid and Skene (1979), table 1: what five anaesthetists, the first of them three times, said
# of the fitness of 45 patients.
PATIENTS = (
    "1111111", "3334334", "1122122", "2223121", "2223222", "2223322", "1222111", "3333433",
    "2222223", "2322223", "4444444", "2223343", "1111111", "2223212", "1211111", "1112111",
    "1111111", "1111111", "2222221", "2221322", "2222222", "2222221", "2223222", "2212222",
    "1111111", "1111111", "2322222", "1111111", "1111111", "1121121", "1111111", "3333233",
    "1111111", "2222222", "2223232", "4334343", "2212232", "2323233", "3333432", "1111111",
    "1111111", "1212111", "2322222", "1211111", "2222222",
)  # fmt: skip
OBSERVERS = (0, 0, 0, 1, 2, 3, 4)


def test_the_anaesthetists():
    """Their tables 2 and 3, for all observers and the first one."""
    item = np.repeat(np.arange(45), 7)
    given = np.array([int(answer) - 1 for patient in PATIENTS for answer in patient])
    found = dawid_skene(item, np.tile(OBSERVERS, 45), given)
    np.testing.assert_allclose(found.prevalence, [0.40, 0.42, 0.11, 0.07], atol=5e-3)
    first = [[0.89, 0.11, 0, 0], [0.07, 0.88, 0.05, 0], [0, 0.34, 0.66, 0], [0, 0, 0.56, 0.44]]
    np.testing.assert_allclose(found.answers[0], first, atol=5e-3)
    # The third patient, of whom three say 1 and four say 2.
    assert found.posterior[2].argmax() == 1


def test_the_likelihood_grows_and_shares_add_up():
    rng = np.random.default_rng(0)
    item, rater = np.divmod(np.arange(400), 8)
    found = dawid_skene(item, rater, rng.integers(0, 3, 400))
    assert (np.diff(found.log_likelihood) > -1e-9).all()
    np.testing.assert_allclose(found.posterior.sum(axis=1), 1)
    np.testing.assert_allclose(found.answers.sum(axis=2), 1)


def test_a_few_good_raters_win_against_many_careless_ones():
    rng = np.random.default_rng(1)
    truth = rng.integers(0, 2, 300)
    item, rater = np.divmod(np.arange(300 * 9), 9)
    is_right = rng.random(len(item)) < np.where(rater < 3, 0.95, 0.55)
    given = np.where(is_right, truth[item], 1 - truth[item])
    weighed = dawid_skene(item, rater, given).posterior.argmax(axis=1)
    counted = majorities(given.astype(bool), item)
    assert (weighed == truth).mean() > 0.97
    assert (weighed == truth).mean() > (counted == truth).mean() + 0.05


def test_a_class_that_nobody_gives_is_not_there():
    found = dawid_skene(np.array([0, 0, 1, 1]), np.array([0, 1, 0, 1]), np.array([0, 0, 1, 1]), 3)
    np.testing.assert_allclose(found.prevalence, [0.5, 0.5, 0], atol=1e-9)
    np.testing.assert_allclose(found.posterior, [[1, 0, 0], [0, 1, 0]], atol=1e-9)


def test_majorities_by_hand():
    agrees = np.array([1, 1, 0, 1, 0, 0], dtype=bool)
    # Two of three; one of two is no majority; none of one.
    np.testing.assert_array_equal(
        majorities(agrees, np.array([5, 5, 5, 2, 2, 9])), [False, True, False]
    )
