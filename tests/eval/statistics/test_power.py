from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from corpus_tools.corpus.estimate import Estimate, undefined
from eval.statistics.power import (
    design_effect,
    judgments_for_difference,
    plan_interval,
    simulated_half_width,
)
from eval.table_2.power_plans import CORRELATION, SHARE, assumptions, plans
from g3.annotation import Judgment


def test_what_r_documents():
    """``power.prop.test``: n = 76.7 for a power of 0.90, and a power of 0.740 with n = 50."""
    assert judgments_for_difference(0.50, 0.75, power=0.740) == pytest.approx(50, abs=0.1)
    assert judgments_for_difference(0.50, 0.75, power=0.90) == pytest.approx(76.7, abs=0.05)
    with pytest.raises(ValueError, match="same"):
        judgments_for_difference(0.5, 0.5)


def test_a_survey_by_hand():
    # The textbook's 385 people for ±5 % at worst, 1.96² · 0.25 / 0.05² = 384.1.
    alone = plan_interval(0.05, share=0.5, judges=1, correlation=0.0)
    assert (alone.pairs, alone.judgments, alone.design_effect) == (385, 385, 1.0)
    # Five judgments with a correlation of 0.5 are worth 5 / 3.
    five = plan_interval(0.05, share=0.5, judges=5, correlation=0.5)
    assert five.design_effect == design_effect(5, 0.5) == 3.0
    assert (five.pairs, five.judgments) == (231, 1155)
    assert five.half_width <= 0.05


@pytest.mark.parametrize("correlation", [0.0, 0.1, 0.5, 1.0])
def test_simulated_studies_are_as_planned(correlation):
    plan = plan_interval(0.04, share=0.8, judges=5, correlation=correlation)
    rng = np.random.default_rng(0)
    found = simulated_half_width(plan, share=0.8, correlation=correlation, rng=rng, studies=8000)
    assert found.value == pytest.approx(0.04, rel=0.05)


def test_plans_grow_with_judges():
    rows = plans(0.03, Estimate(0.9), Estimate(0.4), seed=0)
    pairs = [row["pairs"] for row in rows]
    judgments = [row["judgments"] for row in rows]
    assert pairs == sorted(pairs, reverse=True)
    assert judgments == sorted(judgments)


def test_what_is_assumed():
    assert assumptions(None) == (Estimate(SHARE), Estimate(CORRELATION))
    assert [one.reason for one in assumptions(())] == ["no data", "no data"]
    # Pairs of two judgments each that agree, disagree, and differ.
    ratings = (("a", "SA"), ("a", "A"), ("b", "D"), ("b", "N"), ("c", "A"), ("c", "SD"))
    judgments = [
        Judgment(f"{i}", command, "v", "v", rating, f"{i}", "s")  # type: ignore[arg-type]
        for i, (command, rating) in enumerate(ratings)
    ]
    share, correlation = assumptions(judgments)
    assert (share.value, correlation.value) == pytest.approx((0.5, 0.5))
    # They differ in each pair, as those of independent people hardly would: 0 is the least.
    opposed = [j for j in judgments if j.command == "c"]
    opposed += [replace(j, command="d") for j in opposed]
    share, correlation = assumptions(opposed)
    assert correlation.value < 0
    assert {row["design_effect"] for row in plans(0.03, share, correlation, seed=0)} == {1.0}
    # Each once: nothing shows how alike they are, but one judge of a pair can be planned.
    share, correlation = assumptions(judgments[::2])
    assert (share.value, correlation.reason) == (pytest.approx(2 / 3), "no overlap")
    one, *others = plans(0.03, share, correlation, seed=0)
    assert (one["judges"], one["reason"]) == (1, "")
    assert {row["reason"] for row in others} == {"no overlap"}
    assert np.isnan(float(others[0]["pairs"]))


def test_nothing_is_planned_of_a_share_that_does_not_vary():
    for share in (0.0, 1.0):
        rows = plans(0.03, Estimate(share), undefined("all alike"), seed=0)
        assert {row["reason"] for row in rows} == {"all alike"}
