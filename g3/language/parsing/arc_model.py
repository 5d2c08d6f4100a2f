"""Choice of the arcs between the words of a command (Dozat and Manning, 2017).

Each word has two vectors, as a dependent and as a head, and a biaffine form of them says how much
speaks for each arc; another one says how much speaks for each label of an arc.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from g3.language.parsing.clause_arcs import is_root
from g3.language.parsing.one_thread import one_thread
from g3.short_repr import short_repr

Float32Array: TypeAlias = npt.NDArray[np.float32]
FARTHEST = 20
"""Distances of arcs are told apart up to this many words."""
SLOPE = 0.1
"""Slope of the activation below zero."""


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class ArcModel:
    """Weights; d is the width of the words' vectors, and a and b those of arcs and labels.

    Parameters
    ----------
    labels
        The labels that arcs can have.
    root
        Vector of the root, shape (d,).
    dependents, heads
        For arcs, shape (d + 1, a); the last row is the bias.
    arcs
        Biaffine form of arcs, shape (a + 1, a).
    distances
        Scores of distances from the word to its head, shape (2 FARTHEST + 1,).
    label_dependents, label_heads
        For labels, shape (d + 1, b).
    label_forms
        Biaffine forms of the labels, shape (b + 1, labels, b + 1).
    """

    labels: tuple[str, ...]
    root: Float32Array
    dependents: Float32Array
    heads: Float32Array
    arcs: Float32Array
    distances: Float32Array
    label_dependents: Float32Array
    label_heads: Float32Array
    label_forms: Float32Array


def activated(x: Float32Array, weights: Float32Array) -> Float32Array:
    """Return the leaky rectified linear projection of vectors."""
    y: Float32Array = x @ weights[:-1] + weights[-1]
    return np.where(y > 0, y, np.float32(SLOPE) * y)


def with_one(x: Float32Array) -> Float32Array:
    """Return vectors with a 1 as their last number."""
    return np.concatenate([x, np.ones((*x.shape[:-1], 1), dtype=x.dtype)], axis=-1)


def distance_rows(n: int) -> npt.NDArray[np.intp]:
    """Return the row of each arc's distance, from words to heads without the root (n, n)."""
    places = np.arange(n)
    rows: npt.NDArray[np.intp] = np.clip(places[None] - places[:, None], -FARTHEST, FARTHEST)
    return rows + FARTHEST


def log_probabilities(model: ArcModel, vectors: Float32Array, temperature: float) -> Float32Array:
    """Return log probabilities of each word's head and label, shape (n, n + 1, labels).

    The root is the first head. What the form of trees forbids has minus infinity.

    Parameters
    ----------
    model
        The weights.
    vectors
        The words' vectors, shape (n, d).
    temperature
        Divisor of the scores: above 1 the model is less sure.
    """
    n = len(vectors)
    with one_thread():
        scores, labels = _scores(model, vectors)
    chosen = _log_softmax(scores / np.float32(temperature))
    named = _log_softmax(labels.transpose(0, 2, 1) / np.float32(temperature))
    total: Float32Array = chosen[:, :, None] + named
    roots = np.array([is_root(label) for label in model.labels])
    total[:, 0, ~roots] = -np.inf
    total[:, 1:, roots] = -np.inf
    total[np.arange(n), np.arange(n) + 1] = -np.inf
    return total


def _scores(model: ArcModel, vectors: Float32Array) -> tuple[Float32Array, Float32Array]:
    """Scores of each word's head (n, n + 1), and of the arc's labels (n, labels, n + 1)."""
    n = len(vectors)
    with_root = np.concatenate([model.root[None], vectors])
    arcs = with_one(activated(vectors, model.dependents)) @ model.arcs
    scores = arcs @ activated(with_root, model.heads).T
    scores[:, 1:] += model.distances[distance_rows(n)]
    dependents = with_one(activated(vectors, model.label_dependents))
    heads = with_one(activated(with_root, model.label_heads))
    b = dependents.shape[1]
    left = dependents @ model.label_forms.reshape(b, -1)
    return scores, left.reshape(n, -1, b) @ heads.T


def _log_softmax(x: Float32Array) -> Float32Array:
    x = x - x.max(axis=-1, keepdims=True)
    result: Float32Array = x - np.log(np.exp(x).sum(axis=-1, keepdims=True))
    return result
