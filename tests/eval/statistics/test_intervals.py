from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from eval.statistics.estimates import cluster_bootstrap
from eval.statistics.intervals import (
    bootstrap,
    clopper_pearson,
    gee,
    intraclass_correlation,
    two_way,
    wilson,
)


# R. G. Newcombe, Statistics in Medicine 17 (1998), table I.
@pytest.mark.parametrize(
    ("agreeing", "n", "score", "exact"),
    [
        (81, 263, (0.2553, 0.3662), (0.2527, 0.3676)),
        (15, 148, (0.0624, 0.1605), (0.0578, 0.1617)),
        (0, 20, (0.0000, 0.1611), (0.0000, 0.1684)),
        (1, 29, (0.0061, 0.1718), (0.0009, 0.1776)),
    ],
)
def test_published_intervals(agreeing, n, score, exact):
    assert wilson(agreeing, n)[:3] == pytest.approx((agreeing / n, *score), abs=5e-5)
    assert clopper_pearson(agreeing, n)[:3] == pytest.approx((agreeing / n, *exact), abs=5e-5)


@given(st.integers(1, 200).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
def test_independent_intervals_hold_the_share(counts):
    for interval in (wilson(*counts), clopper_pearson(*counts)):
        assert 0 <= interval.low <= interval.value <= interval.high <= 1


def study(rng, videos=22, commands=11, judges=5, raters=45):
    """Judgments of commands whose videos, commands and raters differ (standard deviations on
    the logit scale 0.5, 1.5 and 0.6)."""
    command = np.repeat(np.arange(videos * commands), judges)
    video = command // commands
    rater = np.concatenate(
        [rng.choice(raters, judges, replace=False) for _ in range(videos * commands)]
    )
    logit = 2.6 + rng.normal(0, 0.5, videos)[video] + rng.normal(0, 1.5, command.max() + 1)[command]
    logit += rng.normal(0, 0.6, raters)[rater]
    return rng.random(len(logit)) < 1 / (1 + np.exp(-logit)), video, rater


def test_whole_clusters_are_resampled():
    agrees, video, _ = study(np.random.default_rng(3))
    found = bootstrap(agrees, video, rng=np.random.default_rng(0), draws=500)
    counts = np.stack([np.bincount(video, agrees), np.bincount(video)], axis=1).astype(np.int64)
    (same,) = cluster_bootstrap(
        counts, lambda c: c[..., :1] / c[..., 1:], rng=np.random.default_rng(0), draws=500
    )
    assert found[:3] == pytest.approx(same[:3])


def test_two_ways_by_hand():
    """Sums of squares of deviations 1/4, 1/4, 1/4 and -3/4: twice 1/2 between the two clusters of
    each kind, and 4/3 times 3/4 between the four of both. Student's quantile with one degree of
    freedom is 12.706."""
    agrees = np.array([True, True, True, False])
    found = two_way(agrees, np.array([0, 0, 1, 1]), np.array([0, 1, 0, 1]))
    half = 12.7062047 * np.sqrt((1 + 1 - 1) / 16) / (0.75 * 0.25)
    bounds = [1 / (1 + np.exp(-(np.log(3) + sign * half))) for sign in (-1, 1)]
    assert found[:3] == pytest.approx((0.75, *bounds))


def test_two_ways_that_are_the_same_are_one_way():
    agrees, video, _ = study(np.random.default_rng(3))
    one = bootstrap(agrees, video, rng=np.random.default_rng(0))
    assert two_way(agrees, video, video)[:3] == pytest.approx(one[:3], abs=0.01)


def test_one_rater_says_nothing_of_others():
    agrees, video, _ = study(np.random.default_rng(3))
    found = two_way(agrees, video, np.zeros_like(video))
    assert (found.value, found.reason) == (agrees.mean(), "one cluster")
    assert not found.has_interval


def test_two_ways_without_variation():
    nobody = np.zeros(6, dtype=bool)
    three, two = np.array([0, 0, 1, 1, 2, 2]), np.array([0, 1, 0, 1, 0, 1])
    assert two_way(nobody, three, two) == wilson(0, 2)
    assert two_way(~nobody, three, three) == wilson(3, 3)
    assert np.isnan(two_way(np.array([True, False]), np.zeros(2, int), np.zeros(2, int)).low)
    assert np.isnan(two_way(nobody[:0], three[:0], two[:0]).value)


def test_clusters_make_intervals_wider():
    agrees, video, rater = study(np.random.default_rng(3))
    widths = [
        interval.high - interval.low
        for interval in (
            wilson(int(agrees.sum()), len(agrees)),
            bootstrap(agrees, video, rng=np.random.default_rng(0)),
            two_way(agrees, video, rater),
        )
    ]
    assert widths == sorted(widths)


def test_the_same_seed_gives_the_same_interval():
    agrees, video, _ = study(np.random.default_rng(3))
    one, other = (bootstrap(agrees, video, rng=np.random.default_rng(7)) for _ in range(2))
    assert one == other


@pytest.mark.slow
def test_coverage_with_clustered_raters():
    """How often the interval holds the share of all videos and raters that there could be."""
    normal = np.random.default_rng(9).normal(size=1_000_000)
    truth = np.mean(1 / (1 + np.exp(-(2.6 + normal * np.sqrt(0.5**2 + 1.5**2 + 0.6**2)))))
    rng = np.random.default_rng(1)
    covered = {"independent": 0, "two ways": 0}
    for _ in range(600):
        agrees, video, rater = study(rng)
        found = {
            "independent": wilson(int(agrees.sum()), len(agrees)),
            "two ways": two_way(agrees, video, rater),
        }
        for name, interval in found.items():
            covered[name] += interval.low <= truth <= interval.high
    assert 0.93 <= covered["two ways"] / 600 <= 0.97
    assert covered["independent"] / 600 < 0.8


def test_estimating_equations_by_hand():
    """With equal clusters the value is the mean, and Mancl and DeRouen's variance of it is
    Σ (m_k − m)² / (K − 1)², as each cluster's leverage is 1 / K."""
    agrees = np.array([1, 1, 1, 0, 1, 1, 0, 0, 1, 1, 1, 1, 1, 0, 0, 1], dtype=bool)
    cluster = np.repeat(np.arange(4), 4)
    means = np.array([0.75, 0.5, 1.0, 0.5])
    share = 11 / 16
    error = np.sqrt(((means - share) ** 2).sum()) / 3 / (share * (1 - share))
    logit, t = np.log(share / (1 - share)), 3.182446  # Student's, 3 degrees of freedom
    bounds = [1 / (1 + np.exp(-(logit + sign * t * error))) for sign in (-1, 1)]
    assert gee(agrees, cluster)[:3] == pytest.approx((share, *bounds), abs=1e-4)


def test_no_model_without_variation():
    assert np.isnan(gee(np.ones(6, dtype=bool), np.array([0, 0, 1, 1, 2, 2])).low)
    assert np.isnan(gee(np.array([True, False]), np.array([0, 0])).low)


def test_correlation_by_hand():
    # Sums 2, 0 and 1 of two each: mean squares 1/2 between and 1/6 within.
    agrees = np.array([1, 1, 0, 0, 1, 0], dtype=bool)
    cluster = np.array([4, 4, 7, 7, 9, 9])
    assert intraclass_correlation(agrees, cluster).value == pytest.approx(0.5)
    assert intraclass_correlation(agrees, np.arange(6)).reason == "no overlap"
    # All that is in a cluster is the same.
    assert intraclass_correlation(agrees[:4], np.array([1, 1, 2, 2])).value == 1.0
