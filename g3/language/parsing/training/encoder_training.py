"""Gradients of the encoder's layers (:mod:`g3.language.parsing.encoder`).

The forward pass keeps what the backward pass needs. Commands are one after another, not padded.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple, TypeAlias

import numpy as np

from g3.language.parsing.encoder import (
    GELU_CUBIC,
    GELU_SCALE,
    HEADS,
    MATRICES,
    NORM_EPSILON,
    Encoder,
    Float32Array,
    layer_arrays,
    with_last_layers,
)

NORMS = ("gain 1", "shift 1", "gain 2", "shift 2")
"""Gains and shifts of a layer's two normalisations."""

Layer: TypeAlias = Mapping[str, Float32Array]
"""Weights of a layer: its matrices (out, in), their biases ("query bias"), and `NORMS`."""


class _Tape(NamedTuple):
    """Values of a layer's forward pass that its backward pass needs."""

    x: Float32Array
    query: Float32Array
    key: Float32Array
    value: Float32Array
    shares: list[Float32Array]
    mixed: Float32Array
    mask: Float32Array | None
    norm: tuple[Float32Array, Float32Array]
    middle: Float32Array
    inner: Float32Array
    tanh: Float32Array
    active: Float32Array
    second_mask: Float32Array | None
    second_norm: tuple[Float32Array, Float32Array]


def layer_weights(encoder: Encoder, number: int) -> dict[str, Float32Array]:
    """Return a copy of a layer's weights."""
    weights = {}
    for name in MATRICES:
        matrix, bias = encoder.layers[number][name]
        weights[name], weights[f"{name} bias"] = matrix.copy(), bias.copy()
    norms = encoder.norms[2 + 4 * number :][:4].copy()
    return weights | dict(zip(NORMS, norms, strict=True))


def with_layers(encoder: Encoder, layers: Sequence[Layer]) -> Encoder:
    """Return an encoder with other last layers, rounded as in a file."""
    if not layers:
        return encoder
    norms = [layer[name] for layer in layers for name in NORMS]
    matrices = [
        {name: (layer[name], layer[f"{name} bias"]) for name in MATRICES} for layer in layers
    ]
    return with_last_layers(encoder, layer_arrays(matrices, norms))


def forward(
    layer: Layer, x: Float32Array, ends: Sequence[int], rng: np.random.Generator, dropout: float
) -> tuple[Float32Array, _Tape]:
    """Return a layer's output for pieces of words (N, d), and what its gradient needs.

    Parameters
    ----------
    layer
        Its weights.
    x
        The vectors of the pieces of all commands.
    ends
        Where each command ends.
    rng
        Source of chance for dropout.
    dropout
        Share of what is added that is left out.
    """
    query, key, value = (x @ layer[name].T + layer[f"{name} bias"] for name in MATRICES[:3])
    mixed = np.empty_like(x)
    shares = []
    for start, end in zip([0, *ends], ends, strict=False):
        q, k, v = (_in_heads(y[start:end]) for y in (query, key, value))
        share = _softmax(q @ k.transpose(0, 2, 1) / np.float32(np.sqrt(q.shape[2])))
        mixed[start:end] = _joined(share @ v)
        shares.append(share)
    added, mask = _dropped(mixed @ layer["output"].T + layer["output bias"], rng, dropout)
    middle, norm = _normed(x + added, layer["gain 1"], layer["shift 1"])
    inner = middle @ layer["inner"].T + layer["inner bias"]
    tanh = np.tanh(GELU_SCALE * (inner + GELU_CUBIC * inner * inner * inner))
    active = np.float32(0.5) * inner * (1 + tanh)
    added, second_mask = _dropped(active @ layer["outer"].T + layer["outer bias"], rng, dropout)
    output, second_norm = _normed(middle + added, layer["gain 2"], layer["shift 2"])
    tape = _Tape(
        x, query, key, value, shares, mixed, mask, norm, middle, inner, tanh, active, second_mask,
        second_norm,
    )  # fmt: skip
    return output, tape


def backward(
    layer: Layer, tape: _Tape, ends: Sequence[int], slope: Float32Array
) -> tuple[Float32Array, dict[str, Float32Array]]:
    """Return the gradients of a layer's input and of its weights, given that of its output."""
    result: dict[str, Float32Array] = {}
    slope = _norm_slope(slope, tape.second_norm, layer, 2, result)
    at_inner = _linear_slope(
        _undropped(slope, tape.second_mask), tape.active, layer, "outer", result
    )
    cubic = GELU_SCALE * (1 + 3 * GELU_CUBIC * tape.inner * tape.inner)
    at_inner *= np.float32(0.5) * (1 + tape.tanh + tape.inner * (1 - tape.tanh * tape.tanh) * cubic)
    slope = slope + _linear_slope(at_inner, tape.middle, layer, "inner", result)
    slope = _norm_slope(slope, tape.norm, layer, 1, result)
    mixed = _linear_slope(_undropped(slope, tape.mask), tape.mixed, layer, "output", result)
    query, key, value = (np.empty_like(tape.x) for _ in range(3))
    for start, end, share in zip([0, *ends], ends, tape.shares, strict=False):
        q, k, v = (_in_heads(y[start:end]) for y in (tape.query, tape.key, tape.value))
        back = _in_heads(mixed[start:end])
        value[start:end] = _joined(share.transpose(0, 2, 1) @ back)
        at = share * (back @ v.transpose(0, 2, 1))
        at -= share * at.sum(axis=2, keepdims=True)
        at /= np.float32(np.sqrt(q.shape[2]))
        query[start:end] = _joined(at @ k)
        key[start:end] = _joined(at.transpose(0, 2, 1) @ q)
    for name, own in zip(MATRICES[:3], (query, key, value), strict=True):
        slope = slope + _linear_slope(own, tape.x, layer, name, result)
    return slope, result


def _in_heads(x: Float32Array) -> Float32Array:
    heads: Float32Array = x.reshape(len(x), HEADS, -1).transpose(1, 0, 2)
    return heads


def _joined(x: Float32Array) -> Float32Array:
    rows: Float32Array = x.transpose(1, 0, 2).reshape(x.shape[1], -1)
    return rows


def _softmax(scores: Float32Array) -> Float32Array:
    scores -= scores.max(axis=2, keepdims=True)
    np.exp(scores, out=scores)
    scores /= scores.sum(axis=2, keepdims=True)
    return scores


def dropout_mask(
    shape: tuple[int, ...], rng: np.random.Generator, dropout: float
) -> Float32Array | None:
    """Return what dropout multiplies by; None without dropout."""
    if not dropout:
        return None
    kept = rng.random(shape, dtype=np.float32) >= dropout
    mask: Float32Array = kept / np.float32(1 - dropout)
    return mask


def _dropped(
    x: Float32Array, rng: np.random.Generator, dropout: float
) -> tuple[Float32Array, Float32Array | None]:
    mask = dropout_mask(x.shape, rng, dropout)
    return _undropped(x, mask), mask


def _undropped(x: Float32Array, mask: Float32Array | None) -> Float32Array:
    return x if mask is None else x * mask


def _normed(
    x: Float32Array, gain: Float32Array, shift: Float32Array
) -> tuple[Float32Array, tuple[Float32Array, Float32Array]]:
    x = x - x.mean(axis=1, keepdims=True)
    scale = 1 / np.sqrt(np.square(x).mean(axis=1, keepdims=True) + np.float32(NORM_EPSILON))
    x *= scale
    return x * gain + shift, (x, scale)


def _norm_slope(
    slope: Float32Array,
    norm: tuple[Float32Array, Float32Array],
    layer: Layer,
    number: int,
    result: dict[str, Float32Array],
) -> Float32Array:
    x, scale = norm
    result[f"gain {number}"] = (slope * x).sum(axis=0)
    result[f"shift {number}"] = slope.sum(axis=0)
    slope = slope * layer[f"gain {number}"]
    along = (slope * x).mean(axis=1, keepdims=True)
    back: Float32Array = scale * (slope - slope.mean(axis=1, keepdims=True) - x * along)
    return back


def _linear_slope(
    slope: Float32Array, x: Float32Array, layer: Layer, name: str, result: dict[str, Float32Array]
) -> Float32Array:
    result[name] = slope.T @ x
    result[f"{name} bias"] = slope.sum(axis=0)
    back: Float32Array = slope @ layer[name]
    return back
