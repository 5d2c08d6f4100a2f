"""Loads on wooden pallets, machines among them, and crates: what the forks lift."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from corpus_tools.world.looks.atlas import board, colour, patch
from corpus_tools.world.looks.look_registry import drawn
from corpus_tools.world.looks.parts import Part, box, inside, join, mirrored, quad, rod, turned
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


_GAP_M = 0.02
"""Between machines on a pallet."""


@on_pallet("refrigerator-pallet")
def refrigerators(low: FloatArray, high: FloatArray, rng: np.random.Generator) -> list[Part]:
    """Build tall white boxes with two doors, each with a handle."""
    return _machines(low, high, "fridge", 2.7)


@on_pallet("washing-machine-pallet")
def washing_machines(low: FloatArray, high: FloatArray, rng: np.random.Generator) -> list[Part]:
    """Build white boxes with a round window below a panel."""
    return _machines(low, high, "washer", 1.5)


def _machines(low: FloatArray, high: FloatArray, front: str, slender: float) -> list[Part]:
    """Build machines some times as high as wide, one or two a side, with a front to all sides."""
    size = high - low
    counts = [1 if slender * length < 1.5 * size[2] else 2 for length in size[:2]]
    pitch = size[:2] / counts
    parts = []
    for cell in np.ndindex(*counts):
        start = low[:2] + cell * pitch + _GAP_M / 2
        end = start + pitch - _GAP_M
        parts.append(box((*start, low[2]), (*end, high[2]), patch(front), tops=colour("white")))
    return parts


@on_pallet("bricks-pallet")
def bricks(low: FloatArray, high: FloatArray, rng: np.random.Generator) -> list[Part]:
    """Build red bricks in courses; some of the upper ones are gone."""
    part, courses = inside(low, high), patch("bricks")
    return [
        part((0.02, 0.98), (0.02, 0.98), (0.0, 0.75), courses, tops=courses),
        part((0.02, 0.62), (0.02, 0.98), (0.75, 1.0), patch("bricks", t=(0, 0.25)), tops=courses),
    ]


@on_pallet("generator-pallet")
def generator(low: FloatArray, high: FloatArray, rng: np.random.Generator) -> list[Part]:
    """Build a green housing with louvres and a panel, a fuel tank before it, an exhaust on it."""
    part, size = inside(low, high), high - low
    dark, green, black = colour("dark"), colour("green", 0.7, 1.1), colour("black", 0.8, 1.1)
    vents, steel = patch("vents"), colour("steel", 0.7, 1.1)
    tank = low + size * (0.86, 0.5, 0.38)
    radius = 0.13 * float(min(size[0], size[2]))
    half = 0.36 * float(size[1])
    drum = mirrored([(0.0, -half), (0.9 * radius, -half), (radius, -0.95 * half)])
    muffler = [low + size * (0.22, 0.3, z) for z in (0.8, 0.9, 1.0)]
    return [
        part((0.0, 1.0), (0.06, 0.94), (0.0, 0.12), black),
        part((0.03, 0.68), (0.1, 0.9), (0.12, 0.8), green, tops=colour("green", 0.8, 1.0)),
        part((0.02, 0.69), (0.14, 0.86), (0.2, 0.72), vents, without="-y +y -z +z"),
        part((0.08, 0.38), (0.09, 0.91), (0.2, 0.72), vents, without="-x +x -z +z"),
        part((0.44, 0.64), (0.085, 0.915), (0.36, 0.72), colour("light")),
        part((0.47, 0.61), (0.08, 0.92), (0.56, 0.68), colour("navy")),
        part((0.47, 0.51), (0.08, 0.92), (0.42, 0.5), colour("red", 1.0, 1.1)),
        part((0.55, 0.61), (0.08, 0.92), (0.42, 0.5), colour("lime")),
        *(part((0.74, 0.98), y, (0.12, 0.3), dark) for y in ((0.2, 0.26), (0.74, 0.8))),
        turned(drum, colour("red", 0.7, 1.1), centre=tank, axis="y", segments=14),
        rod(tank, (*tank[:2], tank[2] + 1.3 * radius), 0.35 * radius, black, segments=8),
        rod(muffler[0], muffler[1], 0.07 * float(size[1]), steel, segments=10),
        rod(muffler[1], muffler[2], 0.035 * float(size[1]), black, segments=8),
    ]


@on_pallet("generator-accessories-pallet")
def accessories(low: FloatArray, high: FloatArray, rng: np.random.Generator) -> list[Part]:
    """Build a drum of orange cable, red cans of fuel, and cartons."""
    part, size = inside(low, high), high - low
    radius = 0.48 * float(min(size[2], 0.55 * size[0]))
    half = 0.2 * float(size[1])
    reel = low + np.array((0.28 * size[0], 0.72 * size[1], radius))
    flange = [(0.0, -half), (radius, -half), (radius, -0.8 * half), (0.55 * radius, -0.8 * half)]
    coil = [(0.85 * radius, -0.8 * half), (0.85 * radius, 0.8 * half)]
    load = [
        *cartons(low, low + size * (1.0, 0.48, 1.0), rng),
        turned(mirrored(flange), colour("wood", 0.7, 1.05), centre=reel, axis="y", segments=18),
        turned(coil, colour("orange", 0.7, 1.1), centre=reel, axis="y", segments=18),
    ]
    red = colour("red", 0.65, 1.05)
    for x in (0.62, 0.82):
        load += [
            part((x, x + 0.16), (0.55, 0.92), (0.0, 0.45), red),
            part((x + 0.05, x + 0.11), (0.62, 0.78), (0.45, 0.52), red),
            part((x + 0.05, x + 0.11), (0.82, 0.9), (0.45, 0.55), colour("black")),
        ]
    return load
