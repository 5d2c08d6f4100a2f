"""Scores from tables are those of the sparse matrix."""

import numpy as np

from g3.inference.problem.scoring import Scorer
from g3.learning.examples import examples, to_batch


def test_tables_give_what_the_matrix_gives(model, warehouse):
    unseen = [a for a in warehouse.annotations if a.command.scenario == "dock_pick_up_tires"]
    items = examples(unseen)[:120]
    scorer = Scorer(model)
    expected = np.log(model.predict_proba(items)[:, 1])
    assert np.allclose(scorer.log_probability(to_batch(items)), expected, atol=1e-9)


def test_both_values_of_phi_add_up_to_one(model, warehouse):
    items = examples(warehouse.annotations)[:40]
    scorer, batch = Scorer(model), to_batch(items)
    true, false = (scorer.log_probability(batch, true=value) for value in (True, False))
    assert np.allclose(np.exp(true) + np.exp(false), 1.0)


def test_reasons_add_up_to_the_log_odds_but_for_the_bias(model, warehouse):
    items = examples(warehouse.annotations)[:1]
    scorer, batch = Scorer(model), to_batch(items)
    given = sum(reason.weight for reason in scorer.reasons(batch))
    bias = scorer._bias(batch.words[0], items[0].sdc.type)
    assert np.isclose(given + bias, scorer.log_odds(batch)[0])
