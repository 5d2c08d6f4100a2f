"""The optimum, with the curvature of few rows."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse

from g3.learning import crf


def problem(n=400, k=12):
    rng = np.random.default_rng(5)
    matrix = sparse.csr_array((rng.random((n, k)) < 0.3).astype(float))
    return matrix, rng.random(n) < 0.5


def second_derivative(local):
    return (local.rows.T @ sparse.diags_array(local.strengths) @ local.rows).toarray()


def test_all_rows_have_the_curvature_worked_by_hand():
    matrix = sparse.csr_array(np.array([[1.0, 0.0], [1.0, 1.0]]))
    local = crf.Likelihood(matrix, np.array([1.0, 0.0]), times=np.array([4.0, 1.0]))(np.zeros(2), 0)
    assert second_derivative(local) == pytest.approx(np.array([[1.25, 0.25], [0.25, 0.25]]))
    assert local.curvature == pytest.approx(1.25)


def test_few_rows_have_the_curvature_of_all_on_average():
    matrix, correct = problem()
    weights = np.linspace(-2, 2, matrix.shape[1])
    exact = second_derivative(crf.Likelihood(matrix, correct)(weights, 0))
    some = [crf.Likelihood(matrix, correct, number=i)(weights, 0.5) for i in range(300)]
    assert max(local.rows.shape[0] for local in some) < matrix.shape[0] / 2
    assert all(local.curvature == some[0].curvature for local in some)
    mean = np.mean([second_derivative(local) for local in some], axis=0)
    assert np.abs(mean - exact).max() < 0.05 * np.abs(exact).max()


def test_the_optimum_does_not_depend_on_how_many_rows_are_kept(monkeypatch):
    matrix, correct = problem()
    expected = crf.train(matrix, correct, tolerance=1e-8)
    monkeypatch.setattr(crf, "KEPT", 60)
    assert crf.train(matrix, correct, tolerance=1e-8) == pytest.approx(expected, abs=1e-7)


def test_it_ends_where_rounding_hides_what_is_less():
    matrix, correct = problem()
    weights = crf.train(matrix, correct, tolerance=0.0)
    gradient = crf.Likelihood(matrix, correct)(weights).gradient + weights
    assert np.abs(gradient).max() < 1e-5


def test_lbfgs_finds_the_same_optimum():
    matrix, correct = problem()
    l2 = np.linspace(0.5, 3, matrix.shape[1])
    weights = [
        crf.train(matrix, correct, l2=l2, tolerance=1e-9, optimizer=optimizer)
        for optimizer in crf.METHODS
    ]
    assert weights[0] == pytest.approx(weights[1], abs=1e-7)
