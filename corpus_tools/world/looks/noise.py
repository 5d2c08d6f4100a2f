"""Patterns for textures, the same on every machine."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from g3.groundings import FloatArray

Pixels: TypeAlias = npt.NDArray[np.uint8]
"""A picture, shape (height, width, 3). The first row is at the bottom."""


def pixels(image: FloatArray) -> Pixels:
    """The picture of colours from 0 to 255."""
    rounded: Pixels = np.clip(np.rint(image), 0, 255).astype(np.uint8)
    return rounded


def speckle(rng: np.random.Generator, size: int) -> FloatArray:
    """Uneven grey that can be tiled, shape (size, size), from 0 to 1."""
    total = np.zeros((size, size))
    cells, weight, weights = 4, 1.0, 0.0
    while cells <= size // 2:
        total += weight * _stretched(rng.random((cells, cells)), size, size)
        weights += weight
        cells, weight = cells * 2, weight * 0.75
    return _spread(total / weights)


def grain(rng: np.random.Generator, height: int, width: int) -> FloatArray:
    """Streaks along the second axis, shape (height, width), from 0 to 1."""
    fine = _stretched(rng.random((max(height, 2), 4)), height, width)
    broad = _stretched(rng.random((max(height // 4, 2), 3)), height, width)
    return _spread(0.6 * fine + 0.4 * broad)


def _stretched(coarse: FloatArray, height: int, width: int) -> FloatArray:
    """A periodic grid, enlarged with straight lines between its values."""

    def stretch(values: FloatArray, length: int) -> FloatArray:
        at = np.arange(length) * len(values) / length
        low = at.astype(int)
        part = (at - low)[:, None]
        stretched: FloatArray = values[low] * (1 - part) + values[(low + 1) % len(values)] * part
        return stretched

    stretched: FloatArray = stretch(stretch(coarse, height).T, width).T
    return stretched


def _spread(values: FloatArray) -> FloatArray:
    spread: FloatArray = (values - values.min()) / max(float(np.ptp(values)), 1e-9)
    return spread
