"""Models of the toolkit in scikit-learn's tools, on lists of examples and of commands."""

from __future__ import annotations

import numpy as np
import pytest
from sklearn.base import clone
from sklearn.exceptions import SkipTestWarning
from sklearn.model_selection import GridSearchCV, GroupKFold, cross_val_score
from sklearn.pipeline import Pipeline
from sklearn.utils import estimator_checks, get_tags
from sklearn.utils.validation import check_is_fitted

import ct
from g3.errors import ModelError
from g3.language.parsing.sdc_parser import SDCParser
from g3.learning.examples import examples, labels
from g3.learning.grounding_model import GroundingModel
from tests.tiny_corpus import tiny_corpus

MODELS = {"GroundingModel": GroundingModel(), "SDCParser": SDCParser()}
ANY_INPUT = (
    estimator_checks.check_estimator_cloneable,
    estimator_checks.check_estimator_tags_renamed,
    estimator_checks.check_valid_tag_types,
    estimator_checks.check_estimator_repr,
    estimator_checks.check_no_attributes_set_in_init,
    estimator_checks.check_do_not_raise_errors_in_init_or_set_params,
    estimator_checks.check_mixin_order,
    estimator_checks.check_parameters_default_constructible,
    estimator_checks.check_get_params_invariance,
    estimator_checks.check_set_params,
)
"""Checks that give the model no data. The others give arrays of numbers, which it can't take."""


@pytest.mark.parametrize("name", MODELS)
def test_check_estimator_passes(name):
    # It leaves out the checks that fit models to arrays.
    with pytest.warns(SkipTestWarning, match="requires input"):
        estimator_checks.check_estimator(MODELS[name])


@pytest.mark.parametrize("check", ANY_INPUT, ids=lambda check: check.__name__)
@pytest.mark.parametrize("name", MODELS)
@pytest.mark.filterwarnings("ignore:Estimator .* does not inherit:UserWarning")
def test_checks_without_data_pass(name, check):
    check(name, MODELS[name])


@pytest.fixture(scope="module")
def items():
    return examples(tiny_corpus().annotations)


@pytest.fixture(scope="module")
def scenarios(items):
    return [item.annotation.command.scenario for item in items]


def test_tags(items):
    assert get_tags(GroundingModel()).estimator_type == "classifier"
    assert get_tags(SDCParser()).estimator_type is None
    assert not get_tags(SDCParser()).input_tags.two_d_array


# What the checks that fit models to arrays look at, on examples


def test_fitting_changes_no_hyperparameter_and_forgets_what_was_learned(items):
    model = GroundingModel(l2=0.5)
    before = model.get_params()
    assert model.fit(items) is model
    check_is_fitted(model)
    assert model.get_params() == before
    first = model.weights_.copy()
    assert np.array_equal(model.fit(items).weights_, first)
    unfitted = clone(model)
    assert unfitted.get_params() == before
    assert not hasattr(unfitted, "weights_")


def test_the_order_and_the_number_of_examples_change_no_prediction(items):
    model = GroundingModel().fit(items)
    whole = model.predict_proba(items)
    assert np.allclose(model.predict_proba(items[::-1]), whole[::-1])
    assert np.allclose(np.vstack([model.predict_proba([one]) for one in items]), whole)


def test_hyperparameters_are_set_by_name():
    assert GroundingModel().set_params(l2=3.0).l2 == 3.0
    with pytest.raises(ModelError, match="give one of l2"):
        GroundingModel().set_params(l3=3.0)


# Tools


def test_cross_validation_holds_scenarios_out(items, scenarios):
    scores = cross_val_score(GroundingModel(), items, groups=scenarios, cv=GroupKFold(2))
    assert scores.shape == (2,)
    assert ((scores >= 0) & (scores <= 1)).all()
    f = cross_val_score(GroundingModel(), items, labels(items), cv=2, scoring="f1")
    assert np.isfinite(f).all()


def test_a_grid_is_searched_in_a_pipeline(items):
    pipeline = Pipeline([("model", GroundingModel())])
    search = GridSearchCV(pipeline, {"model__l2": [0.1, 1.0]}, cv=2)
    search.fit(items, labels(items))
    assert search.best_params_["model__l2"] in (0.1, 1.0)
    assert search.predict(items).dtype == bool
    assert search.score(items, labels(items)) >= 0.5


@pytest.mark.usefixtures("short_training")
def test_a_parser_is_compared_on_lists_of_commands():
    corpus = ct.load("warehouse").filter(lambda entry: entry.context.id.startswith("dock_go"))
    texts = [entry.text for entry in corpus]
    trees = [entry.sdcs for entry in corpus]
    parser = SDCParser(layers=0)
    search = GridSearchCV(parser, {"l2": [0.01, 0.1]}, cv=2).fit(texts, trees)
    assert search.best_score_ == pytest.approx(max(search.cv_results_["mean_test_score"]))
    best = search.best_estimator_
    assert best.score(texts, trees) == np.mean(
        [best.predict([t]) == [y] for t, y in zip(texts, trees, strict=True)]
    )
    with pytest.raises(ModelError, match="2 commands and 1 trees"):
        parser.score(texts[:2], trees[:1])
