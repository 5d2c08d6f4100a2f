from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from eval.statistics.comparison import clustered_mcnemar, cohens_h, compare_all, holm
from eval.tables.comparison_report import compare_commands, lines, records


def test_holms_published_example():
    """What R's documentation of ``p.adjust`` gets for these."""
    found = holm([0.01, 0.02, 0.03, 0.04, 0.005])
    np.testing.assert_allclose(found, [0.04, 0.06, 0.06, 0.06, 0.025])


@given(st.lists(st.floats(0, 1), min_size=1, max_size=12))
def test_holm_keeps_the_order(p):
    found = holm(p)
    assert (found >= np.array(p) - 1e-15).all()
    assert (found <= 1).all()
    assert (np.diff(found[np.argsort(p, kind="stable")]) >= 0).all()


def test_pairs_that_are_clusters_are_mcnemars_test():
    """Agresti, Categorical Data Analysis (2002), section 10.1.1: 150 and 86 of 1600 change
    their approval, z = −4.17."""
    differences = np.repeat([1.0, -1.0, 0.0], [150, 86, 1364])
    p = clustered_mcnemar(differences, np.arange(1600))
    assert p == pytest.approx(3.1e-5, rel=0.01)


def test_clusters_that_agree_say_less():
    differences = np.repeat([1.0, -1.0], [30, 10])
    alone = clustered_mcnemar(differences, np.arange(40))
    together = clustered_mcnemar(differences, np.repeat(np.arange(4), 10))
    # 20² / 40: chi-squared 10. Of the 16 signs of four clusters, 6 give no sum of 20 or more.
    assert alone == pytest.approx(0.001565, abs=1e-6)
    assert together == pytest.approx(10 / 16)
    assert clustered_mcnemar(np.zeros(3), np.arange(3)) == 1.0


def test_few_clusters_are_compared_exactly():
    """All of k clusters change in the same way: two of 2^k signs do. McNemar's distribution would
    say 0.046 of four."""
    for k in range(1, 10):
        assert clustered_mcnemar(np.ones(k), np.arange(k)) == pytest.approx(min(2 / 2**k, 1))
    # Clusters that don't differ say nothing.
    assert clustered_mcnemar(np.repeat([1.0, 0.0], [4, 30]), np.arange(34)) == pytest.approx(1 / 8)


def test_cohens_tables():
    """Cohen (1988), table 6.2.2: φ is 1.772 for 0.60, 1.571 for 0.50 and 2.214 for 0.80."""
    assert cohens_h(0.60, 0.50) == pytest.approx(1.772 - 1.571, abs=1e-3)
    assert cohens_h(0.80, 0.50) == pytest.approx(2.214 - 1.571, abs=1e-3)


def test_comparisons():
    rng = np.random.default_rng(0)
    shares = {
        "good": rng.binomial(5, 0.9, 60) / 5,
        "same": rng.binomial(5, 0.9, 60) / 5,
        "bad": rng.binomial(5, 0.2, 60) / 5,
    }
    found = {(c.one, c.other): c for c in compare_all(shares, np.repeat(np.arange(20), 3), rng=rng)}
    assert len(found) == 3
    worse = found["good", "bad"]
    assert worse.difference.low > 0.5
    assert worse.adjusted_p < 0.01
    assert worse.effect > 1
    equal = found["good", "same"]
    assert equal.difference.low < 0 < equal.difference.high
    assert equal.adjusted_p >= equal.p > 0.05


def test_only_commands_that_both_have_are_compared():
    nan = np.nan
    shares = {
        "one": np.array([1.0, 1.0, 0.0, 1.0, nan]),
        "other": np.array([0.0, nan, 0.0, 0.0, 1.0]),
        "none": np.full(5, nan),
    }
    (found,) = compare_all(shares, np.arange(5), rng=np.random.default_rng(0))
    assert (found.one, found.other, found.n) == ("one", "other", 3)
    assert found.difference.value == pytest.approx(2 / 3)
    # Two differ, both the same way, as two of four signs have it.
    assert found.p == found.adjusted_p == pytest.approx(0.5)


def test_commands_are_compared_by_name_within_their_scenarios():
    shares = {
        "one": {"a1": 1.0, "a2": 1.0, "b1": 0.0},
        "other": {"b1": 0.0, "a2": 0.0, "a1": 0.0},
    }
    scenarios = {"a1": "a", "a2": "a", "b1": "b"}
    (found,) = compare_commands(shares, scenarios, seed=0, draws=50)
    # One scenario says all, which happens either way.
    assert found.p == 1.0
    assert compare_commands(shares, scenarios, seed=0, draws=50) == [found]
    (row,) = records([found])
    assert row["difference"] == pytest.approx(2 / 3)
    assert any("one - other" in line for line in lines([found]))
