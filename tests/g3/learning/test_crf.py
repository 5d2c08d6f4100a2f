from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import optimize, sparse

from g3.learning import crf


@st.composite
def problems(draw, *, kinds=("scalar", "vector")):
    """A sparse matrix with equal columns among others, labels and penalties."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n, distinct = draw(st.integers(1, 30)), draw(st.integers(1, 12))
    dense = (rng.random((n, distinct)) < draw(st.floats(0.05, 0.9))).astype(float)
    if draw(st.booleans()):
        dense *= rng.normal(size=dense.shape)
    copies = rng.integers(0, distinct, draw(st.integers(1, 20)))
    dense = dense[:, copies]
    if draw(st.sampled_from(kinds)) == "scalar":
        l2 = draw(st.floats(0.1, 10))
    else:
        l2 = rng.choice([0.1, 1.0, 4.0], size=dense.shape[1])
    return sparse.csr_array(dense), rng.random(n) < 0.5, l2


def objective(matrix, correct, l2, weights):
    """Value and gradient of what is minimised."""
    local = crf.Likelihood(matrix, correct)(weights)
    return local.value + (l2 * weights) @ weights / 2, local.gradient + l2 * weights


def near(weights):
    return pytest.approx(weights, abs=1e-4)


@given(problems(), st.integers(0, 2**32 - 1))
def test_gradient_agrees_with_finite_differences(problem, seed):
    matrix, _, _ = problem
    point = np.random.default_rng(seed).normal(size=matrix.shape[1])
    value, gradient = objective(*problem, point)
    error = optimize.check_grad(
        lambda w: objective(*problem, w)[0], lambda w: objective(*problem, w)[1], point
    )
    assert error <= 1e-5 * (1 + abs(value) + np.linalg.norm(gradient))


def test_objective_worked_by_hand():
    matrix = sparse.csr_array(np.array([[1.0, 0.0], [1.0, 1.0]]))
    problem = matrix, np.array([True, False]), np.array([1.0, 3.0])
    value, gradient = objective(*problem, np.zeros(2))
    assert value == pytest.approx(2 * np.log(2))
    assert gradient == pytest.approx([0.0, 0.5])
    assert objective(*problem, np.array([0.0, 2.0]))[0] == pytest.approx(
        np.log(2) + np.log(1 + np.exp(2)) + 3 * 4 / 2
    )


@given(problems())
def test_training_finds_where_the_gradient_vanishes(problem):
    matrix, correct, l2 = problem
    weights = crf.train(matrix, correct, l2=l2, tolerance=1e-6)
    assert np.abs(objective(matrix, correct, l2, weights)[1]).max() <= 1e-5


@settings(max_examples=25)
@given(problems(kinds=("scalar",)))
def test_the_optimum_is_that_of_scikit_learn(problem):
    linear_model = pytest.importorskip("sklearn.linear_model")
    matrix, correct, l2 = problem
    if len(set(correct)) < 2:
        return  # scikit-learn refuses
    theirs = linear_model.LogisticRegression(
        C=1 / l2, fit_intercept=False, tol=1e-8, max_iter=10_000
    ).fit(matrix, correct)
    assert crf.train(matrix, correct, l2=l2, tolerance=1e-7) == near(theirs.coef_.ravel())


@given(problems())
def test_equal_columns_with_equal_penalties_have_equal_weights(problem):
    matrix, correct, l2 = problem
    weights = crf.train(matrix, correct, l2=l2)
    penalties = np.broadcast_to(l2, weights.shape)
    columns = matrix.toarray().T
    for i in range(len(weights)):
        for j in range(i):
            if penalties[i] == penalties[j] and np.array_equal(columns[i], columns[j]):
                assert weights[i] == weights[j]


@pytest.mark.parametrize("l2", [1e-3, 1.0])
def test_separable_data_stay_finite(l2):
    matrix = sparse.csr_array(np.eye(4))
    correct = np.array([True, True, False, False])
    weights = crf.train(matrix, correct, l2=l2)
    assert np.isfinite(weights).all()
    assert np.array_equal(crf.probabilities(matrix, weights) > 0.5, correct)


def test_a_column_of_zeros_has_no_weight():
    matrix = sparse.csr_array(np.array([[0.0, 1.0], [0.0, 1.0]]))
    assert crf.train(matrix, np.array([True, True]))[0] == 0


@pytest.mark.parametrize("shape", [(3, 0), (0, 3), (0, 0)])
def test_nothing_to_train_on(shape):
    weights = crf.train(sparse.csr_array(shape), np.zeros(shape[0], bool))
    assert weights == pytest.approx(np.zeros(shape[1]))


@given(problems())
def test_training_is_deterministic_and_leaves_its_input(problem):
    matrix, correct, l2 = problem
    before = matrix.copy()
    first = crf.train(matrix, correct, l2=l2)
    assert first.tobytes() == crf.train(matrix, correct, l2=l2).tobytes()
    assert matrix.indices.tobytes() == before.indices.tobytes()
    assert matrix.data.tobytes() == before.data.tobytes()


def test_probabilities_far_out_are_finite():
    matrix = sparse.csr_array(np.array([[1.0], [-1.0], [0.0]]))
    assert crf.probabilities(matrix, np.array([1e6])).tolist() == [1.0, 0.0, 0.5]
