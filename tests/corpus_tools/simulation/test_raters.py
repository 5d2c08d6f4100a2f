"""Simulated ratings."""

from __future__ import annotations

import pytest

from corpus_tools.importers.authored.bundled import open_corpus
from corpus_tools.simulation.simulated_raters import RaterModel, rate
from g3.errors import FormatError
from tests.tiny_corpus import SCENARIOS, tiny_corpus


@pytest.fixture(scope="module")
def warehouse():
    return open_corpus("warehouse")


def agree(judgments):
    return sum(j.rating in ("A", "SA") for j in judgments) / len(judgments)


def test_own_videos_are_agreed_with_and_others_are_not(warehouse):
    given = rate(warehouse, raters=45, judgments=5, seed=1)
    assert len(given) == 2 * 5 * len(warehouse.commands)
    own = [j for j in given if j.command_video == j.shown_video]
    other = [j for j in given if j.command_video != j.shown_video]
    assert len(own) == len(other)
    assert agree(own) > 0.8
    assert agree(other) < 0.15
    assert {j.study for j in given} == {"simulated"}
    assert all(j.subject.startswith("simulated-") for j in given)
    assert len({j.id for j in given}) == len(given)


def test_nobody_rates_a_pair_twice(warehouse):
    given = rate(warehouse, raters=6, judgments=5, seed=2)
    assert len({(j.command, j.command_video, j.shown_video, j.subject) for j in given}) > 0
    assert len({j.id for j in given}) == len(given)


def test_all_careless_raters_agree_by_chance(warehouse):
    given = rate(warehouse, raters=45, judgments=5, seed=1, model=RaterModel(careless=1.0))
    assert agree(given) == pytest.approx(0.4, abs=0.05)


def test_seeds(warehouse):
    assert rate(warehouse, raters=9, judgments=3, seed=1) == rate(
        warehouse, raters=9, judgments=3, seed=1
    )
    assert rate(warehouse, raters=9, judgments=3, seed=1) != rate(
        warehouse, raters=9, judgments=3, seed=2
    )


def test_too_few(warehouse):
    with pytest.raises(FormatError, match="raters"):
        rate(warehouse, raters=4, judgments=5, seed=1)
    with pytest.raises(FormatError, match="scenario"):
        rate(tiny_corpus(SCENARIOS[:1]), raters=5, judgments=5, seed=1)
