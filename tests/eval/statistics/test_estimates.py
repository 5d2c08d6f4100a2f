from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from sklearn import metrics

from eval.statistics.estimates import cluster_bootstrap, confusion, figures, percentiles

tables = arrays(np.int64, (3, 4), elements=st.integers(0, 50))
per_cluster = arrays(
    np.int64,
    st.tuples(st.integers(0, 8), st.just(2), st.just(4)),
    elements=st.integers(0, 5),
)


def bootstrap(counts, seed=0, **options):
    """The lows and highs of all figures."""
    return bounds(cluster_bootstrap(counts, figures, rng=np.random.default_rng(seed), **options))


def bounds(estimates):
    return tuple(
        np.array([getattr(one, name) for one in estimates.ravel()]).reshape(estimates.shape)
        for name in ("low", "high")
    )


def test_figures_worked_by_hand():
    # tp 6, fp 2, fn 3, tn 9: 6/8, 6/9, 12/17, 15/20.
    np.testing.assert_allclose(figures([6, 2, 3, 9]), [0.75, 2 / 3, 12 / 17, 0.75])


@pytest.mark.parametrize(
    ("counts", "expected"),
    [
        ([0, 0, 0, 0], [np.nan, np.nan, np.nan, np.nan]),
        ([0, 0, 0, 5], [np.nan, np.nan, np.nan, 1]),  # nothing true, nothing said to be
        ([0, 0, 5, 0], [np.nan, 0, 0, 0]),  # nothing said to be true
        ([0, 5, 0, 0], [0, np.nan, 0, 0]),  # nothing true
        ([5, 0, 0, 0], [1, 1, 1, 1]),
    ],
)
def test_undefined_figures_are_nan(counts, expected):
    np.testing.assert_array_equal(figures(counts), expected)


@given(tables)
def test_f_is_the_harmonic_mean_where_both_are_positive(counts):
    precision, recall, f, _ = figures(counts).T
    ok = (precision > 0) & (recall > 0)
    harmonic = 2 * precision[ok] * recall[ok] / (precision[ok] + recall[ok])
    np.testing.assert_allclose(f[ok], harmonic)


@given(tables)
def test_figures_agree_with_scikit_learn(counts):
    for row in counts[counts.sum(axis=1) > 0]:
        label = np.repeat([1, 0, 1, 0], row)
        predicted = np.repeat([1, 1, 0, 0], row)
        expected = [
            metrics.precision_score(label, predicted, zero_division=np.nan),
            metrics.recall_score(label, predicted, zero_division=np.nan),
            metrics.f1_score(label, predicted, zero_division=np.nan),
            metrics.accuracy_score(label, predicted),
        ]
        np.testing.assert_allclose(figures(row), expected)


def test_confusion_counts_cells_by_cluster_and_group():
    counts = confusion(
        np.array([True, False, True, False, True]),
        np.array([True, True, False, False, True]),
        cluster=np.array([0, 0, 1, 1, 1]),
        group=np.array([0, 1, 1, 1, 1]),
        shape=(2, 2),
    )
    expected = [[[1, 0, 0, 0], [0, 1, 0, 0]], [[0, 0, 0, 0], [1, 0, 1, 1]]]
    np.testing.assert_array_equal(counts, expected)


def test_confusion_of_nothing_is_all_zero():
    nothing = np.zeros(0, dtype=np.int64)
    counts = confusion(
        nothing.astype(bool), nothing.astype(bool), cluster=nothing, group=nothing, shape=(0, 3)
    )
    assert counts.shape == (0, 3, 4)


@given(per_cluster, st.integers(0, 5))
def test_intervals_are_ordered_proportions_or_missing(counts, seed):
    low, high = bootstrap(counts, seed, draws=50)
    assert low.shape == high.shape == (2, 4)
    known = ~np.isnan(low)
    np.testing.assert_array_equal(known, ~np.isnan(high))
    assert (low[known] >= 0).all()
    assert (low[known] < high[known]).all()
    assert (high[known] <= 1).all()


@pytest.mark.parametrize("alike", [[6, 2, 3, 9], [5, 0, 0, 0], [0, 0, 3, 1]])
@pytest.mark.parametrize("clusters", [2, 40])
def test_clusters_that_say_the_same_give_no_interval(alike, clusters):
    low, high = bootstrap(np.tile([alike], (clusters, 1)))
    assert np.isnan(low).all()
    assert np.isnan(high).all()


def test_a_figure_that_is_always_the_same_has_no_interval_and_the_others_have():
    counts = np.array([[3, 1, 0, 4], [2, 2, 0, 6], [5, 0, 0, 1]] * 4)
    low, high = bootstrap(counts)
    assert np.isnan([low[1], high[1]]).all()  # nothing true is missed in any
    assert (low[[0, 2, 3]] < high[[0, 2, 3]]).all()


def test_ten_clusters_worked_by_hand():
    # One cluster in two is all right, one all wrong: of ten drawn, the number of right ones is
    # binomial. P(at most 1) = .011 and P(at most 2) = .055, so that the 95% interval is .2 to .8.
    counts = np.array([[4, 0, 0, 0], [0, 0, 4, 0]] * 5)
    low, high = bootstrap(counts)
    assert (low[3], high[3]) == (0.2, 0.8)


@pytest.mark.parametrize("clusters", [0, 1, 9])
def test_fewer_than_ten_clusters_give_no_interval(clusters):
    low, high = bootstrap(np.array([[3, 1, 0, 4], [1, 2, 3, 4], [0, 1, 5, 0]] * 3)[:clusters])
    assert np.isnan(low).all()
    assert np.isnan(high).all()


def test_a_figure_that_few_clusters_inform_has_no_interval():
    counts = np.array([[3, 1, 0, 0], [0, 0, 2, 2], [0, 0, 1, 5]] * 5)
    low, _ = bootstrap(counts)
    # Only five clusters have anything predicted true.
    assert np.isnan(low[0])
    assert not np.isnan(low[1:]).any()


def test_resamples_without_a_figure_are_left_out_and_counted():
    rng = np.random.default_rng(0)
    drawn = np.where(rng.random(1000) < 0.02, np.nan, rng.normal(0.5, 0.1, 1000))
    found = percentiles(0.5, drawn, 40)
    assert found.left_out == np.isnan(drawn).sum() > 0
    assert found.low < 0.5 < found.high
    many = percentiles(0.5, np.where(rng.random(1000) < 0.35, np.nan, 0.4), 40)
    assert (many.value, many.reason) == (0.5, "poor resamples")
    assert many.left_out > 300
    beside = percentiles(0.9, drawn, 40)
    assert (beside.value, beside.reason) == (0.9, "poor resamples")
    assert percentiles(np.nan, drawn, 40).reason == "empty class"


def test_the_seed_decides():
    counts = np.random.default_rng(3).integers(0, 6, (40, 4))
    np.testing.assert_array_equal(bootstrap(counts, 1), bootstrap(counts, 1))
    assert not np.array_equal(bootstrap(counts, 1), bootstrap(counts, 2))


def test_senseless_options_are_refused():
    with pytest.raises(ValueError, match="expected at least 1"):
        bootstrap(np.ones((2, 4), dtype=np.int64), draws=0)


def simulated_accuracies(rng, clusters, per_cluster):
    """Counts (clusters, 4) of correlated examples whose expected accuracy is 0.8."""
    right = rng.binomial(per_cluster, rng.beta(1.6, 0.4, clusters))
    return np.stack([right, 0 * right, per_cluster - right, 0 * right], axis=-1)


def as_if_independent(counts):
    """The same examples, each a cluster of its own."""
    return np.repeat(np.eye(4, dtype=np.int64), counts.sum(axis=0), axis=0)


def test_coverage_is_near_nominal_and_better_than_ignoring_clusters():
    rng = np.random.default_rng(20110807)
    simulations, clustered, naive = 300, 0, 0
    for number in range(simulations):
        counts = simulated_accuracies(rng, clusters=60, per_cluster=rng.integers(2, 12, 60))
        low, high = bounds(cluster_bootstrap(counts, figures, rng=rng, draws=400))
        clustered += low[3] <= 0.8 <= high[3]
        if number % 5 == 0:
            naive_counts = as_if_independent(counts)
            low, high = bounds(cluster_bootstrap(naive_counts, figures, rng=rng, draws=400))
            naive += low[3] <= 0.8 <= high[3]
    # 3 standard errors of 300 simulations are 0.038; small-sample bias takes a little more.
    assert 0.90 <= clustered / simulations <= 0.985
    assert naive / (simulations / 5) < 0.85


def test_clusters_widen_intervals_of_correlated_examples():
    rng = np.random.default_rng(7)
    counts = simulated_accuracies(rng, clusters=80, per_cluster=np.full(80, 8))
    low, high = bootstrap(counts)
    naive_low, naive_high = bootstrap(as_if_independent(counts))
    assert high[3] - low[3] > 1.3 * (naive_high[3] - naive_low[3])


def test_clusters_of_independent_examples_do_not_widen_intervals():
    rng = np.random.default_rng(8)
    right = rng.binomial(8, 0.8, 300)
    counts = np.stack([right, 0 * right, 8 - right, 0 * right], axis=-1)
    low, high = bootstrap(counts)
    naive_low, naive_high = bootstrap(as_if_independent(counts))
    assert high[3] - low[3] == pytest.approx(naive_high[3] - naive_low[3], rel=0.2)
