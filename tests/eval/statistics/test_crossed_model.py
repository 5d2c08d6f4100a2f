"""A mixed model with crossed effects, beside what balanced data say by hand and by simulation."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import special, stats

from eval.statistics.intervals import crossed


def test_balanced_data_by_hand():
    """With every rater once a video the estimate is the mean, and its error that of an ANOVA."""
    rng = np.random.default_rng(1)
    likely = special.expit(1 + rng.normal(size=(12, 1)) + rng.normal(size=(1, 10)))
    agrees = rng.random((12, 10)) < likely
    video, rater = np.indices(agrees.shape)
    found = crossed(agrees.ravel(), video.ravel(), rater.ravel())
    share = agrees.mean()
    rows, columns = agrees.mean(axis=1), agrees.mean(axis=0)
    between_rows, between_columns = 10 * rows.var(ddof=1), 12 * columns.var(ddof=1)
    rest = agrees - rows[:, None] - columns + share
    within = (rest**2).sum() / (11 * 9)
    assert between_rows > within < between_columns  # so that no deviation is at zero
    error = np.sqrt((between_rows + between_columns - within) / 120)
    half = stats.t.ppf(0.975, 9) * error / (share * (1 - share))
    assert found.value == pytest.approx(share, abs=1e-6)
    bounds = special.expit(special.logit(share) + half * np.array([-1, 1]))
    assert (found.low, found.high) == pytest.approx(tuple(bounds), abs=1e-3)


def test_nothing_to_estimate():
    video, rater = np.array([0, 0, 1, 1]), np.array([0, 1, 0, 1])
    for agrees, clusters in (
        (np.ones(4, dtype=bool), (video, rater)),
        (np.array([True, False, True, False]), (video, np.zeros(4, dtype=np.int64))),
    ):
        found = crossed(agrees, *clusters)
        assert found.value == agrees.mean()
        assert np.isnan([found.low, found.high]).all()


@pytest.mark.slow
def test_it_holds_the_true_share():
    """Twelve videos and ten raters who differ: near to 95 of 100 intervals hold the true share."""
    rng = np.random.default_rng(0)
    truth = special.expit(1 + rng.normal(size=200_000) * np.sqrt(0.5 + 0.6)).mean()
    video, rater = (index.ravel() for index in np.indices((12, 10)))
    hits = 0
    for _ in range(40):
        of_video, of_rater = rng.normal(size=12) * 0.5**0.5, rng.normal(size=10) * 0.6**0.5
        agrees = rng.random(120) < special.expit(1 + of_video[video] + of_rater[rater])
        found = crossed(agrees, video, rater)
        hits += found.low <= truth <= found.high
    assert hits >= 35
