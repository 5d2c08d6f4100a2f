"""How far a judge agrees with people on plans of which a sample was rated."""

from __future__ import annotations

import numpy as np
import pytest

from eval.plan_study.rating_sample import (
    ALL,
    Sample,
    agreements,
    distinct_plans,
    draw,
    kind_of,
    tells_of_all,
)
from eval.plan_study.rating_set import verdicts
from tests.eval.plan_study.made_plans import plans_of, record, waiting


def test_kappa_of_all_plans_by_hand():
    # Of eight wrong plans half were drawn, of four right ones all.
    plans = plans_of(["wrong"] * 8 + ["right"] * 4, scenarios=12)
    wrong = [p.run for p in plans if p.kind == "wrong"][:4]
    right = [p.run for p in plans if p.kind == "right"]
    sample = Sample(0, "log", dict.fromkeys(wrong, 0.5) | dict.fromkeys(right, 1.0))
    people = dict(zip((*wrong, *right), (1, 0, 0, 0, 1, 1, 1, 0), strict=True))
    every, gold = agreements(plans, sample, people, "log", seed=0, draws=200)
    assert (every.configuration, gold.configuration) == (ALL, "gold")
    assert every.counts == {
        "people_yes_judge_yes": 3,
        "people_yes_judge_no": 1,
        "people_no_judge_yes": 1,
        "people_no_judge_no": 3,
    }
    # Of all plans: 3 and 2 right to people, 1 and 6 wrong; as drawn, kappa would be one half.
    values = {name: estimate.value for name, estimate in every.figures.items()}
    assert values == pytest.approx(
        {
            "precision": 3 / 4,
            "recall": 3 / 5,
            "precision_of_wrong": 3 / 4,
            "same": 9 / 12,
            "people_right": 5 / 12,
            "kappa": (9 / 12 - 76 / 144) / (1 - 76 / 144),
        }
    )
    assert values["kappa"] == pytest.approx(8 / 17)
    kappa = every.figures["kappa"]
    assert kappa.low < kappa.value < kappa.high


def test_plans_of_one_kind_weigh_by_their_chance():
    # Of six wrong plans of gold two were drawn, of two of auto both; gold's are half right.
    records = [
        record(which, f"{which}{i}", f"s{i}", waiting(1.0), right=False)
        for which, count in (("gold", 6), ("auto", 2))
        for i in range(count)
    ]
    plans = distinct_plans(records)
    gold = [p.run for p in plans if p.configurations == ("gold",)][:2]
    auto = [p.run for p in plans if p.configurations == ("auto",)]
    sample = Sample(0, "log", dict.fromkeys(gold, 1 / 3) | dict.fromkeys(auto, 1.0))
    people = dict(zip((*gold, *auto), (True, False, False, False), strict=True))
    rows = {
        row.configuration: row for row in agreements(plans, sample, people, "log", seed=0, draws=20)
    }
    assert rows["all"].figures["people_right"].value == pytest.approx(3 / 8)
    assert rows["gold"].figures["precision_of_wrong"].value == pytest.approx(1 / 2)
    assert rows["auto"].figures["people_right"].value == 0
    assert (rows["gold"].plans, rows["gold"].rated) == (6, 2)
    assert "random" not in rows


def test_pairs_that_nobody_has_rated_yet_are_made_up_for():
    plans = plans_of(["wrong"] * 8 + ["right"] * 4)
    sample = draw(plans, ["wrong", "right"], 0, seed=0)
    rated = [p for p in plans if p.kind == "right"][:2] + [p for p in plans if p.kind == "wrong"][
        :6
    ]
    people = {p.run: p.kind == "right" for p in rated}
    every, _ = agreements(plans, sample, people, "log", seed=0, draws=20)
    assert every.figures["people_right"].value == pytest.approx(4 / 12)
    assert every.rated == 8


def test_without_right_plans_there_is_no_kappa():
    plans = plans_of(["wrong"] * 8 + ["right"] * 4)
    sample = draw(plans, ["wrong"], 0, seed=0)
    people = dict.fromkeys(sample.chance, False)
    every, _ = agreements(plans, sample, people, "log", seed=0, draws=20)
    assert every.figures["precision_of_wrong"].value == 1
    for name in ("kappa", "precision", "recall", "same", "people_right"):
        assert np.isnan(every.figures[name].value), name
    assert not tells_of_all(plans, sample)
    assert tells_of_all(plans, draw(plans, ["wrong", "right"], 4, seed=0))


def test_a_second_verdict_is_checked_by_the_same_ratings():
    records = [
        record("gold", f"c{i}", f"s{i % 3}", waiting(1.0), right=i < 6, words=i < 3)
        for i in range(12)
    ]
    plans = distinct_plans(records)
    assert {kind_of(p, "words") for p in plans} == {"wrong", "right"}
    both = draw(plans, ["wrong", "right"], 0, seed=0)
    assert verdicts(plans, both) == ["log", "words"]
    assert verdicts(plans, draw(plans, ["wrong"], 0, seed=0)) == ["log"]
    people = {p.run: p.record.verdicts["words"] for p in plans}
    log, words = (
        agreements(plans, both, people, name, seed=0, draws=20)[0].figures
        for name in ("log", "words")
    )
    assert words["kappa"].value == 1
    assert log["precision"].value == pytest.approx(1 / 2)
    assert log["recall"].value == 1
