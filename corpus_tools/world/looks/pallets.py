"""Loads on wooden pallets, and crates: what the forks lift."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from corpus_tools.world.looks.atlas import board, colour, patch
from corpus_tools.world.looks.look_registry import drawn
from corpus_tools.world.looks.parts import Part, box, inside, join, quad
from corpus_tools.world.looks.vehicles import tyre
from corpus_tools.world.state.dimensions import BLOCK, ENTRY_HEIGHT, PALLET_HEIGHT
from corpus_tools.world.state.shapes import Shape
from g3.groundings import FloatArray

_SLATS = 5
"""Number of slats of each side of a crate."""
_OUT = 0.012
"""Distance by which its posts stand out, as a share of its width."""
_SLIT = 0.005
"""Half of the gap between two cartons."""


LoadOf: TypeAlias = Callable[[FloatArray, FloatArray, np.random.Generator], list[Part]]
"""Gives the parts of a load in the room between two opposite corners, shape (3,)."""


def on_pallet(kind: str) -> Callable[[LoadOf], LoadOf]:
    """Register the load of a kind of pallet."""

    def register(load: LoadOf) -> LoadOf:
        @drawn(kind)
        def whole(shape: Shape, rng: np.random.Generator) -> list[Part]:
            base, low, high = _pallet(shape, rng)
            return [base, *load(low, high, rng)]

        return load

    return register


@on_pallet("tire-pallet")
def tire_pallet(low: FloatArray, high: FloatArray, rng: np.random.Generator) -> list[Part]:
    """Build four stacks of tyres on a pallet."""
    size = high - low
    columns = [max(1, min(4, round(length / 0.55))) for length in size[:2]]
    pitch = size[:2] / columns
    radius = 0.485 * float(pitch.min())
    levels = max(1, min(4, round(float(size[2]) / 0.19)))
    width = float(size[2]) / levels
    stacks = [(x, y) for x in range(columns[0]) for y in range(columns[1])]
    lower = int(rng.integers(2 * len(stacks))) if levels > 1 and len(stacks) > 1 else len(stacks)
    parts = []
    for i, (x, y) in enumerate(stacks):
        top = levels - (i == lower)
        for level in range(top):
            slack = min(0.012, 0.5 * float(pitch.min()) - radius)
            middle = low[:2] + (np.array([x, y]) + 0.5) * pitch + rng.uniform(-slack, slack, 2)
            bottom = (*middle, low[2] + level * width)
            parts.append(tyre(bottom, radius, width, open_top=level == top - 1))
    return parts


@on_pallet("box-pallet")
def box_pallet(low: FloatArray, high: FloatArray, rng: np.random.Generator) -> list[Part]:
    """Build cartons of several sizes on a pallet, held by straps."""
    if rng.random() < 0.6:
        strap = np.array([0.006, 0.006, 0.003])
        return [*cartons(low, high - strap, rng), *_straps(low, high)]
    return cartons(low, high, rng, missing=1)


@drawn("crate")
def crate(shape: Shape, rng: np.random.Generator) -> list[Part]:
    """Build a wooden crate on feet: slats with gaps between them, posts at the corners, a brace."""
    base, low, high = _feet(shape)
    part = inside(low, high)
    dark, thin = colour("black", 0.5, 0.8), 0.035
    parts = [base, part((thin, 1 - thin), (thin, 1 - thin), (0.0, 0.96), dark, without="-z")]
    ends = np.linspace(0.0, 1.0, _SLATS + 1)
    for k, (a, b) in enumerate(pairwise(ends)):
        slat = a, b - 0.3 * (b - a) * (k < _SLATS - 1)
        for side in ((0.0, thin), (1 - thin, 1.0)):
            parts.append(part((0.0, 1.0), side, slat, board(k), along=True))
            parts.append(part(side, (thin, 1 - thin), slat, board(k + 4), along=True))
        lid = a, b - 0.22 * (b - a) * (k < _SLATS - 1)
        parts.append(part(lid, (0.0, 1.0), (0.96, 0.985), board(k + 2), along=True))
    corners = ((-_OUT, 0.1), (0.9, 1 + _OUT))
    for x in corners:
        parts.append(part(x, (0.0, 1.0), (0.985, 1.0), board(5), along=True))
        parts += [part(x, y, (0.0, 1.0), board(3), along=True, without="-z") for y in corners]
    return [*parts, _braces(low, high)]


def _braces(low: FloatArray, high: FloatArray) -> Part:
    """Build a board across each side, from one lower corner to the other upper one."""
    ends = np.array([(0.1, 0.0), (0.24, 0.0), (0.9, 1.0), (0.76, 1.0)])
    out = 1 + _OUT
    sides = []
    for axis, at, forth in ((0, -_OUT, 0), (0, out, 1), (1, -_OUT, 1), (1, out, 0)):
        along = ends if forth else ends * (-1, 1) + (1, 0)
        corners = np.insert(along, axis, at, axis=1)
        sides.append(quad(low + corners * (high - low), board(axis + 1)))
    return join(sides)


def cartons(
    low: FloatArray, high: FloatArray, rng: np.random.Generator, *, missing: int = 0
) -> list[Part]:
    """Build cartons that fill a box between opposite corners, shape (3,), layer by layer.

    `missing` is the number of missing cartons of the highest layer, where it has several and lies
    on another.
    """
    size = high - low
    layers = max(1, min(4, round(float(size[2]) / 0.4)))
    parts = []
    for layer in range(layers):
        bottom, top = low[2] + size[2] * np.array([layer, layer + 1]) / layers
        cells = _floor_plan(low[:2], high[:2], float(size.max()) / 5, rng)
        if 0 < layer == layers - 1 and len(cells) > 2:
            rng.shuffle(cells)
            cells = cells[missing:]
        for start, end in cells:
            parts.append(
                box(
                    (*(start + _SLIT), bottom),
                    (*(end - _SLIT), top),
                    patch("carton" if rng.random() < 0.65 else "carton-dark"),
                    tops=patch("carton-top"),
                    without="-z",
                )
            )
    return parts


def _floor_plan(
    low: FloatArray, high: FloatArray, least: float, rng: np.random.Generator
) -> list[tuple[FloatArray, FloatArray]]:
    """Return rectangles that fill one: it is cut across as long as it is longer than needed."""
    size = high - low
    axis = int(np.argmax(size))
    if size[axis] <= max(least, 0.75 if rng.random() < 0.5 else 0.5):
        return [(low, high)]
    end, start = high.copy(), low.copy()
    end[axis] = start[axis] = low[axis] + float(rng.choice([0.5, 0.5, 0.4, 0.6])) * size[axis]
    return _floor_plan(low, end, least, rng) + _floor_plan(start, high, least, rng)


def _straps(low: FloatArray, high: FloatArray) -> list[Part]:
    """Build two plastic bands around the load."""
    band, finish = 0.03, colour("light", 0.8, 1.0)
    middles = low[1] + (high[1] - low[1]) * np.array([0.27, 0.73])
    ends = [((low[0], y - band / 2, low[2]), (high[0], y + band / 2, high[2])) for y in middles]
    return [box(*pair, finish, without="-y +y -z") for pair in ends]


def _pallet(shape: Shape, rng: np.random.Generator) -> tuple[Part, FloatArray, FloatArray]:
    """Build a pallet that the forks can enter from every side, and return the room on it."""
    feet, low, high = _feet(shape)
    thick = (PALLET_HEIGHT / ENTRY_HEIGHT - 1) * (low[2] - shape.low[2])
    low[2] += thick
    across = high[1] - low[1]
    n = max(5, min(11, round(float(high[0] - low[0]) / 0.145)))
    edges = np.linspace(low[0], high[0], n + 1)
    gap = 0.18 * (edges[1] - edges[0])
    first = int(rng.integers(8))
    boards = [
        box(
            (a if k == 0 else a + gap / 2, low[1], low[2] - thick),
            (b if k == n - 1 else b - gap / 2, low[1] + across, low[2]),
            board(first + k),
            along=True,
        )
        for k, (a, b) in enumerate(pairwise(edges))
    ]
    return join([feet, *boards]), low, high


def _feet(shape: Shape) -> tuple[Part, FloatArray, FloatArray]:
    """Build nine blocks on three boards, and return the room above them."""
    low, high = shape.low.copy(), shape.high.copy()
    height = min(ENTRY_HEIGHT, 0.25 * float(high[2] - low[2]))
    foot = np.minimum(BLOCK, 0.2 * (high - low)[:2])
    sole = low[2] + 0.18 * height
    parts = []
    for row, y in enumerate(np.linspace(low[1], high[1] - foot[1], 3)):
        parts.append(box((low[0], y, low[2]), (high[0], y + foot[1], sole), board(row), along=True))
        for x in np.linspace(low[0], high[0] - foot[0], 3):
            ends = (x, y, sole), (x + foot[0], y + foot[1], low[2] + height)
            parts.append(box(*ends, board(row + 3), without="-z +z"))
    low[2] += height
    return join(parts), low, high
