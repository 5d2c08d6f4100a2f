"""The conditional random field against sums over all sequences."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from scipy.optimize import check_grad

from g3.language.parsing.role_model import POSSIBLE, Chains, Scores, best_roles, likely_roles, score
from g3.language.parsing.spacy_pipeline import VECTOR
from g3.language.parsing.training import role_training
from g3.language.parsing.training.role_training import expectations, train_roles
from g3.language.parsing.word_features import Features
from g3.language.parsing.word_roles import ROLES

R = len(ROLES)


def one_hot(codes):
    """The features of words of which each has one, by its number."""
    return Features(
        np.array(codes, dtype=np.uint64)[:, None] << np.uint64(50),
        np.zeros((len(codes), 1), dtype=np.uint64),
        np.zeros((len(codes), VECTOR), dtype=np.float32),
    )


def random_scores(words, seed=0):
    rng = np.random.default_rng(seed)
    return Scores(rng.normal(size=(words, R)), rng.normal(size=(words, R + 1, R)) + POSSIBLE)


def all_paths(scores):
    """Every sequence of roles with its unnormalised log probability."""
    found = {}
    for path in product(range(R), repeat=len(scores.roles)):
        before = (R, *path[:-1])
        found[path] = sum(
            scores.roles[i, role] + scores.moves[i, prior, role]
            for i, (prior, role) in enumerate(zip(before, path, strict=True))
        )
    return found


def test_the_best_sequence_and_its_probability():
    scores = random_scores(3)
    paths = all_paths(scores)
    best = max(paths, key=paths.get)
    total = np.logaddexp.reduce(list(paths.values()))
    ((chance, roles),) = best_roles(scores, [3])
    assert roles == tuple(ROLES[i] for i in best)
    assert chance == pytest.approx(np.exp(paths[best] - total))


def test_the_best_sequences_in_order():
    scores = random_scores(3, seed=1)
    paths = all_paths(scores)
    total = np.logaddexp.reduce(list(paths.values()))
    order = sorted(paths, key=lambda path: -paths[path])[:40]
    found = likely_roles(scores, 40)
    assert [roles for _, roles in found] == [tuple(ROLES[i] for i in path) for path in order]
    assert [chance for chance, _ in found] == pytest.approx(
        [float(np.exp(paths[path] - total)) for path in order]
    )


def test_commands_of_different_lengths_do_not_disturb_each_other():
    lengths = [2, 0, 5, 1, 3]
    scores = random_scores(sum(lengths), seed=2)
    together = best_roles(scores, lengths)
    end = 0
    for length, (chance, roles) in zip(lengths, together, strict=True):
        own = Scores(scores.roles[end : end + length], scores.moves[end : end + length])
        end += length
        ((own_chance, own_roles),) = best_roles(own, [length])
        assert roles == own_roles
        assert chance == pytest.approx(own_chance)


def test_expectations_are_sums_over_all_sequences():
    scores = random_scores(3, seed=3)
    paths = all_paths(scores)
    log_total, chance, moves = expectations(Chains([3]), scores)
    total = np.logaddexp.reduce(list(paths.values()))
    assert log_total == pytest.approx(total)
    expected = np.zeros((3, R))
    expected_moves = np.zeros((3, R + 1, R))
    for path, value in paths.items():
        before = (R, *path[:-1])
        for i, (prior, role) in enumerate(zip(before, path, strict=True)):
            expected[i, role] += np.exp(value - total)
            expected_moves[i, prior, role] += np.exp(value - total)
    np.testing.assert_allclose(chance, expected, atol=1e-12)
    np.testing.assert_allclose(moves, expected_moves, atol=1e-12)


def test_the_gradient_is_that_of_the_objective(monkeypatch):
    rng = np.random.default_rng(4)
    ids = Features(
        rng.integers(0, 3, size=(5, 2)).astype(np.uint64) << np.uint64(50),
        rng.integers(0, 2, size=(5, 1)).astype(np.uint64) << np.uint64(50),
        rng.normal(size=(5, VECTOR)).astype(np.float32),
    )
    seen = {}

    def minimise(objective, start, **_):
        point = rng.normal(scale=0.3, size=len(start))
        seen["error"] = check_grad(lambda x: objective(x)[0], lambda x: objective(x)[1], point)
        seen["size"] = len(start)
        return point

    monkeypatch.setattr(role_training, "lbfgs", minimise)
    roles = [ROLES[:1] * 2, ("event", "noun", "noun-on")]
    train_roles(ids, roles, l2=0.5, scales=(2.0, 0.5), strange=np.array([1, 1, 0, 0, 0], bool))
    assert seen["size"] > 4 * R
    assert seen["error"] < 1e-4 * np.sqrt(seen["size"])


def test_training_learns_what_is_plain():
    ids = one_hot([1, 2, 3, 1, 2])
    taught = [("event", "noun", "noun-on"), ("event", "noun")]
    model = train_roles(ids, taught, l2=0.01)
    found = best_roles(score(model, ids), [3, 2])
    assert [roles for _, roles in found] == taught
    assert min(chance for chance, _ in found) > 0.9


def test_what_other_annotators_do_is_learned_where_it_agrees():
    ids = one_hot([1, 2, 1, 2, 1, 3])
    roles = [("event", "path"), ("event", "place"), ("event", "noun")]
    strange = np.array([0, 0, 1, 1, 1, 1], dtype=bool)
    model = train_roles(ids, roles, l2=0.05, strange=strange)
    found = best_roles(score(model, ids), [2, 2, 2])
    assert [roles for _, roles in found] == [roles[0], roles[0], roles[2]]
    assert len(model.roles.keys) == 3
