from __future__ import annotations

import numpy as np
import pytest

from g3.errors import ModelError
from g3.examples import examples, labels, to_batch
from g3.features.registry import CATALOGUE_VERSION, select
from g3.model import predict, train_model
from tests.tiny_corpus import tiny_corpus


@pytest.fixture(scope="module")
def items():
    return examples(tiny_corpus().annotations)


@pytest.fixture(scope="module")
def model(items):
    return train_model(items, select(), l2=0.1, corpus_hash="sha256:1")


def test_a_model_learns_what_it_is_shown(items, model):
    assert np.array_equal(predict(model, items) > 0.5, labels(items))


def test_a_model_says_what_it_is(model):
    assert (model.l2, model.corpus_hash) == (0.1, "sha256:1")
    assert model.catalogue_version == CATALOGUE_VERSION
    assert {s.name for s in model.sets} == {s.name for s in select()}
    assert len(model.weights) == len(model.space)
    assert model.space.name(0)


def test_training_is_deterministic(items, model):
    again = train_model(items, select(), l2=0.1)
    assert again.weights.tobytes() == model.weights.tobytes()
    assert again.space.bases == model.space.bases


def test_a_batch_packed_before_gives_the_same(items, model):
    batch = to_batch(items)
    again = train_model(items, select(), l2=0.1, batch=batch)
    assert again.weights == pytest.approx(model.weights)
    assert predict(model, items, batch=batch) == pytest.approx(predict(model, items))


def test_a_prediction_does_not_depend_on_the_other_examples(items, model):
    together = predict(model, items)
    alone = [predict(model, [item])[0] for item in items]
    assert together == pytest.approx(alone)
    assert predict(model, items[::-1]) == pytest.approx(together[::-1])


def test_no_examples_have_no_predictions(model):
    assert predict(model, []).shape == (0,)


def test_an_ablated_model_lacks_the_features(items, model):
    left = train_model(items, select(without=["labels"]))
    assert "labels" not in left.space.sets
    assert not any(base.split("/")[1] == "labels" for base in left.space.bases)
    assert any(base.split("/")[1] == "labels" for base in model.space.bases)


def test_an_unknown_feature_set_is_refused():
    with pytest.raises(ModelError, match=r"there is no feature set 'lables'"):
        select(without=["lables"])
