"""Training of the choice of arcs (:mod:`g3.language.parsing.arc_model`).

The encoder's last layers can learn, too
(:mod:`g3.language.parsing.training.encoder_training`). Stochastic gradients with Adam (Kingma and
Ba, 2015), and dropout.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from g3.language.parsing.arc_model import (
    FARTHEST,
    SLOPE,
    ArcModel,
    Float32Array,
    activated,
    distance_rows,
    with_one,
)
from g3.language.parsing.clause_arcs import Arcs
from g3.language.parsing.encoder import State
from g3.language.parsing.training.encoder_training import Layer, backward, dropout_mask, forward

ARC_WIDTH, LABEL_WIDTH = 192, 96
BATCH = 24
"""Commands a step."""
DROPOUT = 0.25
RATE = 1e-3
"""Largest step of a weight."""
DECAY = (0.9, 0.99)
"""Decay of the means of gradients and of their squares."""
WARM_UP = 50
"""Steps in which the rate rises."""
ENCODER_RATE, LAYER_DROPOUT = 1e-4, 0.1
"""The encoder's largest step, and its dropout."""
DISTANCE_RATE = 20
"""Distances have so much larger steps: they are few, and say which of two like words is meant."""
MARKERS = ("strange", "strange pieces")
"""Vectors of commands by other conventions."""
_EPSILON = 1e-8

IntArray: TypeAlias = npt.NDArray[np.intp]
_Weights: TypeAlias = dict[str, Float32Array]
_ARC_WEIGHTS = tuple(f.name for f in fields(ArcModel) if f.name != "labels")
_PROJECTIONS = ("dependents", "heads", "label_dependents", "label_heads")


@dataclass(frozen=True, slots=True, eq=False)
class ArcExample:
    """A command to learn from.

    Parameters
    ----------
    state
        The command before the layers that learn.
    arcs
        The annotated arcs of its n words.
    strange
        True if it was annotated by other conventions than those that are to be learned.
    """

    state: State
    arcs: Arcs
    strange: bool = False


class _Taught(NamedTuple):
    """An example with its heads, the root being 0, and its labels as numbers.

    `pool` has the share of each piece in each word's vector (n, pieces).
    """

    example: ArcExample
    heads: IntArray
    labels: IntArray
    pool: Float32Array


def new_model(labels: Sequence[str], width: int, rng: np.random.Generator) -> ArcModel:
    """Return a model with random weights."""

    def random(*shape: int) -> Float32Array:
        scale = np.sqrt(1 / shape[-2])
        values: Float32Array = (scale * rng.standard_normal(shape)).astype(np.float32)
        return values

    b = LABEL_WIDTH + 1
    return ArcModel(
        tuple(labels),
        random(width, 1)[:, 0],
        random(width + 1, ARC_WIDTH),
        random(width + 1, ARC_WIDTH),
        random(ARC_WIDTH + 1, ARC_WIDTH) / np.float32(10),
        np.zeros(2 * FARTHEST + 1, dtype=np.float32),
        random(width + 1, LABEL_WIDTH),
        random(width + 1, LABEL_WIDTH),
        random(b, len(labels) * b).reshape(b, -1, b) / np.float32(10),
    )


def with_labels(model: ArcModel, labels: Sequence[str]) -> ArcModel:
    """Return the same model with further labels, which nothing speaks for yet."""
    further = tuple(sorted(set(labels) - set(model.labels)))
    b = len(model.label_forms)
    nothing = np.zeros((b, len(further), b), dtype=np.float32)
    forms = np.concatenate([model.label_forms, nothing], axis=1)
    return replace(model, labels=(*model.labels, *further), label_forms=forms)


def train(
    examples: Sequence[ArcExample],
    start: ArcModel,
    layers: Sequence[Layer] = (),
    *,
    l2: float,
    epochs: int,
    rng: np.random.Generator,
) -> tuple[ArcModel, list[Layer]]:
    """Learn from annotated commands, beginning with a model's weights.

    Commands that were annotated by other conventions have vectors that are added to those of their
    pieces and of their words. They are learned, too, and forgotten after training, so that the
    model learns what the conventions have in common (regularised multi-task learning, Evgeniou and
    Pontil, 2004).

    Parameters
    ----------
    examples
        Commands with their arcs.
    start
        The weights to begin with.
    layers
        Those of the encoder's last layers, which learn too.
    l2
        Strength of the pull towards these.
    epochs
        How often to go through the commands.
    rng
        Source of chance.
    """
    model = with_labels(start, [label for one in examples for label in one.arcs.labels])
    weights = {name: getattr(model, name).copy() for name in _ARC_WEIGHTS}
    for name in MARKERS:
        weights[name] = np.zeros(len(model.root), dtype=np.float32)
    for i, layer in enumerate(layers):
        weights |= {f"{i} {name}": value.copy() for name, value in layer.items()}
    origin = {name: value.copy() for name, value in weights.items()}
    numbers = {label: i for i, label in enumerate(model.labels)}
    taught = [_taught(example, numbers) for example in examples if example.arcs.heads]
    means = {name: np.zeros_like(value) for name, value in weights.items()}
    squares = {name: np.zeros_like(value) for name, value in weights.items()}
    total = epochs * -(-len(taught) // BATCH)
    step = 0
    for _ in range(epochs):
        order = rng.permutation(len(taught))
        for first in range(0, len(taught), BATCH):
            step += 1
            gradient = _gradient(
                weights, len(layers), [taught[i] for i in order[first : first + BATCH]], rng
            )
            share = min(1.0, step / min(WARM_UP, total / 5)) * max(0.02, 1 - step / total)
            for name, slope in gradient.items():
                rate = share * (ENCODER_RATE if name[0].isdigit() else RATE)
                mean, square, weight = means[name], squares[name], weights[name]
                mean *= DECAY[0]
                mean += (1 - DECAY[0]) * slope
                square *= DECAY[1]
                square += (1 - DECAY[1]) * np.square(slope)
                spread = np.sqrt(square * (1 / (1 - DECAY[1] ** step))) + _EPSILON
                faster = DISTANCE_RATE if name == "distances" else 1
                pull = rate * l2 * (weight - origin[name])
                weight -= pull + rate * faster / (1 - DECAY[0] ** step) * (mean / spread)
    arcs = replace(model, **{name: weights[name] for name in _ARC_WEIGHTS})
    return arcs, [_layer(weights, i) for i in range(len(layers))]


def _taught(example: ArcExample, numbers: Mapping[str, int]) -> _Taught:
    n = len(example.arcs.heads)
    pool = (example.state.owners == np.arange(n)[:, None]).astype(np.float32)
    pool /= np.maximum(pool.sum(axis=1, keepdims=True), 1)
    return _Taught(
        example,
        np.array(example.arcs.heads, dtype=np.intp) + 1,
        np.array([numbers[label] for label in example.arcs.labels], dtype=np.intp),
        pool,
    )


def _layer(weights: _Weights, number: int) -> dict[str, Float32Array]:
    start = f"{number} "
    return {k.removeprefix(start): v for k, v in weights.items() if k.startswith(start)}


def _gradient(
    weights: _Weights, layers: int, batch: Sequence[_Taught], rng: np.random.Generator
) -> _Weights:
    """Gradient of the mean loss of a word: minus the log probabilities of its head and label."""
    sizes = [len(one.example.state.vectors) for one in batch]
    ends = np.cumsum(sizes).tolist()
    x = np.concatenate([one.example.state.vectors for one in batch])
    strange = np.array([one.example.strange for one in batch])
    of_pieces = np.repeat(strange, sizes)
    if layers:
        x[of_pieces] += weights["strange pieces"]
    tapes = []
    for i in range(layers):
        x, tape = forward(_layer(weights, i), x, ends, rng, LAYER_DROPOUT)
        tapes.append(tape)
    places = list(zip([0, *ends], ends, batch, strict=False))
    of_words = np.repeat(strange, [len(one.heads) for one in batch])
    vectors = np.concatenate([one.pool @ x[start:end] for start, end, one in places])
    vectors += of_words[:, None] * weights["strange"]
    result, back = _arc_gradient(weights, vectors, batch, rng)
    result["strange"] = back[of_words].sum(axis=0)
    if layers:
        lengths = np.cumsum([len(one.heads) for one in batch])[:-1]
        parts = np.split(back, lengths)
        slope = np.concatenate([one.pool.T @ part for one, part in zip(batch, parts, strict=True)])
        for i in reversed(range(layers)):
            slope, own = backward(_layer(weights, i), tapes[i], ends, slope)
            result |= {f"{i} {name}": value for name, value in own.items()}
        result["strange pieces"] = slope[of_pieces].sum(axis=0)
    return result


def _arc_gradient(
    weights: _Weights, vectors: Float32Array, batch: Sequence[_Taught], rng: np.random.Generator
) -> tuple[_Weights, Float32Array]:
    """Gradients of the choice of arcs, and of the words' vectors (n, d)."""
    lengths = [len(one.heads) for one in batch]
    mask = dropout_mask(vectors.shape, rng, DROPOUT)
    dropped = vectors if mask is None else vectors * mask
    words = np.concatenate([weights["root"][None], dropped])
    result = {name: np.zeros_like(weights[name]) for name in _ARC_WEIGHTS}
    inner = {name: activated(words, weights[name]) for name in _PROJECTIONS}
    slopes = {name: np.zeros_like(value) for name, value in inner.items()}
    heads = np.concatenate([one.heads for one in batch])
    labels = np.concatenate([one.labels for one in batch])
    starts = np.cumsum(lengths) - lengths
    for start, n, one in zip(starts.tolist(), lengths, batch, strict=True):
        rows = np.arange(start + 1, start + n + 1)
        with_root = np.concatenate([[0], rows])
        dependents, candidates = with_one(inner["dependents"][rows]), inner["heads"][with_root]
        left = dependents @ weights["arcs"]
        scores = left @ candidates.T
        distances = distance_rows(n)
        scores[:, 1:] += weights["distances"][distances]
        error = _error(scores, one.heads) / len(heads)
        slope = error @ candidates
        slopes["heads"][with_root] += error.T @ left
        slopes["dependents"][rows] += slope @ weights["arcs"][:-1].T
        result["arcs"] += dependents.T @ slope
        np.add.at(result["distances"], distances, error[:, 1:])
    at = np.where(heads > 0, heads + np.repeat(starts, lengths), 0)
    dependents = with_one(inner["label_dependents"][1:])
    governors = with_one(inner["label_heads"][at])
    b = dependents.shape[1]
    forms = weights["label_forms"].reshape(b, -1)
    left = (dependents @ forms).reshape(len(heads), -1, b)
    error = _error(np.einsum("mkb,mb->mk", left, governors), labels) / len(heads)
    spread = (error[:, :, None] * governors[:, None]).reshape(len(heads), -1)
    result["label_forms"] += (dependents.T @ spread).reshape(b, -1, b)
    slopes["label_dependents"][1:] += (spread @ forms.T)[:, :-1]
    np.add.at(slopes["label_heads"], at, np.einsum("mk,mkb->mb", error, left)[:, :-1])
    back = np.zeros_like(words)
    for name in _PROJECTIONS:
        slope = slopes[name] * np.where(inner[name] > 0, np.float32(1), np.float32(SLOPE))
        result[name][:-1] = words.T @ slope
        result[name][-1] = slope.sum(axis=0)
        back += slope @ weights[name][:-1].T
    result["root"] += back[0]
    return result, back[1:] if mask is None else back[1:] * mask


def _error(scores: Float32Array, chosen: IntArray) -> Float32Array:
    """Probabilities minus 1 for what is right: the slope of the loss."""
    odds = np.exp(scores - scores.max(axis=1, keepdims=True))
    odds /= odds.sum(axis=1, keepdims=True)
    odds[np.arange(len(odds)), chosen] -= 1
    result: Float32Array = odds
    return result
