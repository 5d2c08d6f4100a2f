"""Choice of arcs: probabilities, trees that are possible, and learning."""

from __future__ import annotations

from dataclasses import fields
from itertools import islice

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from g3.language.parsing.arc_decoding import likely_arcs
from g3.language.parsing.arc_model import ArcModel, log_probabilities
from g3.language.parsing.clause_arcs import INSIDE, OUTSIDE, ROOT, Arcs
from g3.language.parsing.encoder import HEADS, State
from g3.language.parsing.training import arc_training
from g3.language.parsing.training.arc_training import ArcExample, new_model, train
from g3.language.parsing.training.encoder_training import NORMS, forward

LABELS = (OUTSIDE, INSIDE, "root:EVENT", "l:OBJECT", "l2:PATH")
WIDTH = 2 * HEADS


@pytest.fixture
def small(monkeypatch):
    """A model with small vectors."""
    monkeypatch.setattr(arc_training, "ARC_WIDTH", 6)
    monkeypatch.setattr(arc_training, "LABEL_WIDTH", 5)
    monkeypatch.setattr(arc_training, "RATE", 0.03)
    monkeypatch.setattr(arc_training, "WARM_UP", 1)
    return new_model(LABELS, WIDTH, np.random.default_rng(0))


def vectors(n, seed=0):
    return np.random.default_rng(seed).standard_normal((n, WIDTH)).astype(np.float32)


def test_probabilities_of_possible_arcs_add_up_to_at_most_one(small):
    chances = np.exp(log_probabilities(small, vectors(5), 1.0))
    assert chances.shape == (5, 6, len(LABELS))
    assert np.all(chances.sum(axis=(1, 2)) <= 1 + 1e-5)
    assert np.all(chances[np.arange(5), np.arange(5) + 1] == 0)  # no word hangs from itself
    assert np.all(chances[:, 0, [1, 3, 4]] == 0)
    assert np.all(chances[:, 1:, [0, 2]] == 0)


@settings(deadline=None, max_examples=60)
@given(st.integers(1, 7), st.integers(0, 10_000), st.floats(0.5, 4))
def test_likely_arcs_are_different_trees_the_most_probable_first(n, seed, sharp):
    rng = np.random.default_rng(seed)
    raw = (sharp * rng.standard_normal((n, n + 1, len(LABELS)))).astype(np.float32)
    raw[:, 0, [1, 3, 4]] = raw[:, 1:, [0, 2]] = -np.inf
    raw[np.arange(n), np.arange(n) + 1] = -np.inf
    scores = raw - np.log(np.exp(raw).sum(axis=(1, 2), keepdims=True))
    found = list(islice(likely_arcs(scores, LABELS), 20))
    assert found
    assert len({arcs for _, arcs in found}) == len(found)
    assert sum(probability for probability, _ in found) <= 1 + 1e-5
    later = [probability for probability, _ in found[1:]]
    assert later == sorted(later, reverse=True)
    for probability, arcs in found:
        assert 0 < probability <= 1
        for word, (head, label) in enumerate(zip(*arcs, strict=True)):
            if label in (OUTSIDE, "root:EVENT"):
                assert head == ROOT
                continue
            assert arcs.labels[head] not in (OUTSIDE, INSIDE)
            path = [word]
            while path[-1] != ROOT:
                path.append(arcs.heads[path[-1]])
                assert len(path) <= n + 1


def state(vectors):
    """A command in which each word is one piece."""
    return State(vectors, np.arange(len(vectors)))


def test_arcs_that_would_cross_are_put_right():
    raw = np.full((4, 5, len(LABELS)), -9.0, dtype=np.float32)
    raw[0, 0, 2] = raw[1, 0, 2] = raw[2, 1, 3] = -0.1  # two EVENTs, and a thing of the first
    raw[3, 2, 1] = -0.2
    raw[2, 2, 3] = -1.0
    raw[3, 1, 1] = -3.0
    [(_, first), *_] = likely_arcs(raw, LABELS)
    assert first.heads == (ROOT, ROOT, 1, 1)


def test_it_learns_what_it_is_taught_and_forgets_strange_ways(small):
    one = ArcExample(state(vectors(3)), Arcs((-1, 0, 1), ("root:EVENT", "l:OBJECT", "on")))
    other = ArcExample(
        state(vectors(3)), Arcs((-1, -1, 1), ("out", "root:EVENT", "l:NEW")), strange=True
    )
    model, _ = train(
        [one] * 20 + [other] * 20, small, l2=0.0, epochs=60, rng=np.random.default_rng(0)
    )
    assert model.labels == (*LABELS, "l:NEW")
    chances = log_probabilities(model, one.state.vectors, 1.0)
    _, arcs = next(likely_arcs(chances, model.labels))
    assert arcs == one.arcs


def test_a_strong_pull_keeps_what_was_known(small):
    example = ArcExample(state(vectors(3)), Arcs((-1, 0, 1), ("root:EVENT", "l:OBJECT", "on")))
    far, near = (
        train([example] * 8, small, l2=l2, epochs=40, rng=np.random.default_rng(0))[0]
        for l2 in (0.0, 10.0)
    )
    assert distance(near, small) < 0.2 * distance(far, small)


def distance(one: ArcModel, other: ArcModel) -> float:
    return float(
        sum(
            np.square(getattr(one, f.name) - getattr(other, f.name)).sum()
            for f in fields(one)
            if f.name != "labels"
        )
    )


def random_layers(count, rng):
    """Weights of layers, by the names that they have in training."""
    shapes = dict.fromkeys(("query", "key", "value", "output"), (WIDTH, WIDTH))
    shapes |= {"inner": (2 * WIDTH, WIDTH), "outer": (WIDTH, 2 * WIDTH)}
    weights = {}
    for i in range(count):
        for name, shape in shapes.items():
            weights[f"{i} {name}"] = 0.5 * rng.standard_normal(shape)
            weights[f"{i} {name} bias"] = 0.3 * rng.standard_normal(shape[0])
        weights |= {f"{i} {name}": 1 + rng.standard_normal(WIDTH) for name in NORMS}
    return weights


@pytest.mark.parametrize("layers", [0, 2])
def test_the_gradient_is_that_of_the_loss(small, monkeypatch, layers):
    monkeypatch.setattr(arc_training, "DROPOUT", 0.0)
    monkeypatch.setattr(arc_training, "LAYER_DROPOUT", 0.0)
    rng = np.random.default_rng(1)
    numbers = {label: i for i, label in enumerate(LABELS)}
    arcs = Arcs((-1, 0, 0, 2), ("root:EVENT", "on", "l:OBJECT", "on"))
    owners = np.array([-1, 0, 0, 1, 2, 3, -1])
    batch = [
        arc_training._taught(
            ArcExample(State(rng.standard_normal((7, WIDTH)), owners), arcs, strange), numbers
        )
        for strange in (False, True)
    ]
    weights = {
        f.name: getattr(small, f.name).astype(float) for f in fields(small) if f.name != "labels"
    }
    parts = {name: weights[name] for name in weights}
    weights["strange"] = rng.standard_normal(WIDTH)
    if layers:
        weights["strange pieces"] = rng.standard_normal(WIDTH)
        weights |= random_layers(layers, rng)

    def loss():
        total = 0.0
        for one in batch:
            strange = float(one.example.strange)
            x = one.example.state.vectors
            if layers:
                x = x + strange * weights["strange pieces"]
            for i in range(layers):
                x, _ = forward(arc_training._layer(weights, i), x, [len(x)], rng, 0.0)
            words = one.pool @ x + strange * weights["strange"]
            chosen = log_probabilities(ArcModel(LABELS, **parts), words, 1.0)
            total -= chosen[np.arange(4), one.heads, one.labels].sum()
        return total / 8

    gradient = arc_training._gradient(weights, layers, batch, rng)
    assert set(gradient) == set(weights)
    for name, value in weights.items():
        for place in [tuple(rng.integers(size) for size in value.shape) for _ in range(5)]:
            value[place] += 1e-5
            above = loss()
            value[place] -= 2e-5
            slope = (above - loss()) / 2e-5
            value[place] += 1e-5
            assert slope == pytest.approx(gradient[name][place], abs=1e-5), name
