"""Loads of pallets that are named for what they are: machines, and what comes with them."""

from __future__ import annotations

import numpy as np

from corpus_tools.world.looks.atlas import colour, patch
from corpus_tools.world.looks.pallets import cartons, on_pallet
from corpus_tools.world.looks.parts import Part, box, inside, mirrored, rod, turned
from g3.groundings import FloatArray

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
