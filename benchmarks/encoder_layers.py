"""Layers of the encoder with slopes, as `g3.language.parsing.encoder` computes them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from g3.language.parsing.encoder import HEADS, MATRICES, NORM_EPSILON, Float32Array, Layer

NOT_THERE = -1e4
"""Score of what a word can't attend to."""


class EncoderLayers(nn.Module):
    """Some layers of a BERT.

    Parameters
    ----------
    layers
        The matrices of each layer with their biases, by name.
    norms
        Gains and shifts of two normalisations of each layer, shape (4 layers, d).
    dropout
        Share of values that is left out in training.
    """

    def __init__(self, layers: Sequence[Layer], norms: Float32Array, dropout: float) -> None:
        super().__init__()
        self.layers = nn.ModuleList()
        for layer in layers:
            modules = {name: nn.Linear(1, 1) for name in MATRICES}
            for name, module in modules.items():
                weight, bias = (torch.from_numpy(part.copy()) for part in layer[name])
                module.weight, module.bias = nn.Parameter(weight), nn.Parameter(bias)
            self.layers.append(nn.ModuleDict(modules))
        self.norms = nn.Parameter(torch.from_numpy(norms.copy()))
        self.drop = nn.Dropout(dropout)

    def forward(self, x: Tensor, there: Tensor) -> Tensor:
        """Return the vectors of pieces of words (commands, pieces, d) after the layers.

        Parameters
        ----------
        x
            The vectors before, shape (commands, pieces, d).
        there
            Which pieces there are, shape (commands, pieces).
        """
        count, n, d = x.shape
        bias = torch.zeros(count, 1, 1, n).masked_fill(~there[:, None, None], NOT_THERE)
        for number, layer in enumerate(self.layers):
            norms = self.norms[4 * number :]
            query, key, value = (
                layer[name](x).view(count, n, HEADS, -1).transpose(1, 2) for name in MATRICES[:3]
            )
            mixed = functional.scaled_dot_product_attention(query, key, value, attn_mask=bias)
            mixed = layer["output"](mixed.transpose(1, 2).reshape(count, n, d))
            x = functional.layer_norm(x + self.drop(mixed), (d,), *norms[:2], NORM_EPSILON)
            inner = functional.gelu(layer["inner"](x), approximate="tanh")
            x = x + self.drop(layer["outer"](inner))
            x = functional.layer_norm(x, (d,), *norms[2:4], NORM_EPSILON)
        return x

    def arrays(self) -> list[Layer]:
        """Return the matrices of each layer with their biases, by name."""
        return [
            {name: (as_array(layer[name].weight), as_array(layer[name].bias)) for name in MATRICES}
            for layer in self.layers
        ]


def as_array(value: Tensor) -> Float32Array:
    """Return a tensor as an array."""
    result: Float32Array = value.detach().numpy().astype(np.float32)
    return result
