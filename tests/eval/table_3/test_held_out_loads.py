"""What commands' words say of loads is learned without the scenario that is tested."""

import numpy as np

from corpus_tools.corpus.load_choices import load_choices
from eval.table_3.held_out import costs_without, data_of
from g3.features.feature_registry import select
from tests.eval.yard import yards
from tests.tiny_corpus import tiny_corpus


def test_a_scenarios_words_are_left_out(tmp_path):
    choices = load_choices(yards(tmp_path))
    (own,) = (c for c in choices if "washer" in c.words)
    costs = costs_without(data_of([tiny_corpus()], sets=select()), choices)
    elsewhere = next(c for c in choices if c.scenario != own.scenario)
    with_it = costs(elsewhere.scenario).model.load_chooser_
    without = costs(own.scenario).model.load_chooser_
    assert "washer" in with_it.lexicon.words
    assert "washer" not in without.lexicon.words
    assert np.isfinite(without.log_probability(own)).all()


def test_without_outcomes_there_is_nothing_of_it():
    costs = costs_without(data_of([tiny_corpus()], sets=select()))
    assert costs("").model.load_chooser_ is None
