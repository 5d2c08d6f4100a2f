"""The grounding model: what it learns, and that it has scikit-learn's shape."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from g3.errors import ModelError
from g3.estimator import NotFittedError
from g3.features.feature_registry import select
from g3.learning.examples import examples, labels
from g3.learning.factor_matrix import joined, matrix_of_examples
from g3.learning.grounding_model import GroundingModel
from tests.tiny_corpus import tiny_corpus


@pytest.fixture(scope="module")
def items():
    return examples(tiny_corpus().annotations)


@pytest.fixture(scope="module")
def model(items):
    return GroundingModel(l2=0.1).fit(items)


@pytest.fixture(scope="module")
def factors(items):
    return matrix_of_examples(items, select())


def test_a_model_learns_what_it_is_shown(items, model):
    assert np.array_equal(model.predict(items), labels(items))
    assert model.classes_.tolist() == [False, True]


def test_both_probabilities_add_up_to_one(items, model):
    chances = model.predict_proba(items)
    assert chances.shape == (len(items), 2)
    assert chances.sum(axis=1) == pytest.approx(1)


def test_a_model_says_what_it_is(model):
    assert repr(model).startswith("GroundingModel(l2=0.1")
    assert model.sets == select()
    assert len(model.weights_) == len(model.space_)
    assert model.space_.name(0)


def test_fitting_again_gives_the_same(items, model):
    again = GroundingModel(**model.get_params())
    with pytest.raises(NotFittedError):
        again.predict(items)
    assert again.fit(items) is again
    assert again.weights_.tobytes() == model.weights_.tobytes()
    assert again.space_.bases == model.space_.bases
    again.fit(items[:20])  # and what was learned before is forgotten
    fresh = GroundingModel(l2=0.1).fit(items[:20])
    assert again.weights_.tobytes() == fresh.weights_.tobytes()


def test_scikit_learn_can_clone_it(model):
    base = pytest.importorskip("sklearn.base")
    cloned = base.clone(model)
    assert cloned.get_params() == model.get_params()
    assert not hasattr(cloned, "weights_")


@pytest.mark.parametrize("use", ["predict", "predict_proba", "save"])
def test_before_it_is_fitted_it_says_what_to_do(items, use, tmp_path):
    about = tmp_path / "m" if use == "save" else items
    with pytest.raises(
        NotFittedError, match=r"this GroundingModel isn't fitted yet \(call its fit"
    ):
        getattr(GroundingModel(), use)(about)
    assert list(tmp_path.iterdir()) == []


def test_what_no_model_has_is_an_ordinary_error(model):
    with pytest.raises(AttributeError, match="GroundingModel has no attribute 'coef'"):
        _ = model.coef


def test_labels_can_be_given(items, factors):
    wrong = ~labels(items)
    model = GroundingModel(l2=0.1).fit(items, wrong)
    assert np.array_equal(model.predict(items), wrong)
    assert np.array_equal(GroundingModel(l2=0.1).fit(factors, wrong).weights_, model.weights_)


@settings(max_examples=20)
@given(st.data())
def test_features_that_are_computed_before_give_the_same(items, factors, data):
    """For any part to learn from and any part to test on, in any order."""
    rows = st.lists(st.integers(0, len(items) - 1), min_size=4, max_size=len(items), unique=True)
    train, test = (np.array(data.draw(rows)) for _ in range(2))
    slow = GroundingModel(l2=0.5).fit([items[i] for i in train])
    fast = GroundingModel(l2=0.5).fit(factors[train])
    expected = slow.predict_proba([items[i] for i in test])
    assert fast.predict_proba(factors[test]) == pytest.approx(expected, abs=1e-4)
    # A model can be asked with features that it didn't learn from, and the other way round.
    assert slow.predict_proba(factors[test]) == pytest.approx(expected, abs=1e-9)
    assert fast.predict_proba([items[i] for i in test]) == pytest.approx(expected, abs=1e-4)


def test_features_of_some_examples_at_a_time_are_the_same(items, factors, monkeypatch):
    monkeypatch.setattr("g3.learning.factor_matrix.BLOCK", 7)
    parts = matrix_of_examples(items, select())
    assert len(parts) == len(items)

    def names(known):
        rows = known.matrix.tolil().rows
        return [{known.space.name(column) for column in row} for row in rows]

    assert names(parts) == names(factors)
    assert parts.matrix.data.tolist() == factors.matrix.data.tolist()


def test_features_in_another_order_are_found(items, factors, model):
    order = [matrix_of_examples(part, select()) for part in (items[30:], items[:30])]
    other = joined(order, select())
    assert other.space.words != factors.space.words
    expected = np.roll(model.predict_proba(items), -30, axis=0)
    assert model.predict_proba(other) == pytest.approx(expected)


def test_a_model_reads_what_it_learned_with_whatever_is_the_default(items):
    factors = matrix_of_examples(items, select(plus=["word-tags"]))
    model = GroundingModel(l2=0.1).fit(factors)
    assert "word-tags" in {s.name for s in model.sets}
    assert model.predict_proba(items) == pytest.approx(model.predict_proba(factors))


def test_features_that_were_not_computed_are_missed(items, model):
    few = matrix_of_examples(items, select(without=["labels"]))
    with pytest.raises(ModelError, match="'labels' were not computed"):
        model.predict(few)


def test_a_prediction_does_not_depend_on_the_other_examples(items, model):
    together = model.predict_proba(items)
    alone = [model.predict_proba([item])[0] for item in items]
    assert together == pytest.approx(np.array(alone))
    assert model.predict_proba(items[::-1]) == pytest.approx(together[::-1])


def test_no_examples_have_no_predictions(model):
    assert model.predict_proba([]).shape == (0, 2)
    assert model.predict([]).shape == (0,)


def test_nothing_to_learn_from_is_refused():
    with pytest.raises(ModelError, match="nothing to learn from"):
        GroundingModel().fit([])


def test_a_label_for_each_example_is_needed(items):
    with pytest.raises(ModelError, match=f"there are {len(items)} examples"):
        GroundingModel().fit(items, [True])


@pytest.mark.parametrize("named", [True, False])
def test_an_ablated_model_lacks_the_features(items, model, named):
    sets = select(without=["labels"])
    left = GroundingModel(features=[s.name for s in sets] if named else sets).fit(items)
    assert left.sets == sets
    assert "labels" not in left.space_.sets
    assert not any(base.split("/")[1] == "labels" for base in left.space_.bases)
    assert any(base.split("/")[1] == "labels" for base in model.space_.bases)


def test_an_unknown_feature_set_is_refused(items):
    with pytest.raises(ModelError, match=r"there is no feature set 'lables'"):
        GroundingModel(features=["lables"]).fit(items)


def test_a_model_knows_for_which_types_it_has_learned_a_set(items, tmp_path):
    def types_of(model):
        return next(own.types for own in model.sets if own.name == "avs-speaker")

    usual, more = GroundingModel().fit(items), GroundingModel(features=select(plus=["avs-speaker"]))
    more.fit(items).save(tmp_path / "more")
    assert types_of(usual) == ("OBJECT",)
    assert types_of(more) == types_of(GroundingModel.load(tmp_path / "more")) == ("OBJECT", "PLACE")
    assert not any(base.startswith("PLACE/avs-speaker/") for base in usual.space_.bases)
    assert (usual.predict_proba(items) != more.predict_proba(items)).any()
