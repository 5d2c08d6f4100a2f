"""Furniture of yards, and large things that stay: containers, signs, berms."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from corpus_tools.world.looks.atlas import board, colour, patch
from corpus_tools.world.looks.look_registry import drawn
from corpus_tools.world.looks.pallets import cartons
from corpus_tools.world.looks.parts import Part, box, disc, inside, quads, rod, turned
from corpus_tools.world.state.shapes import Shape
from g3.groundings import FloatArray


@drawn("shelf")
def shelf(shape: Shape, rng: np.random.Generator) -> list[Part]:
    """Build a rack with three floors of goods: cartons and plastic bins."""
    low, part = shape.low, inside(shape.low, shape.high)
    post = np.minimum(0.09 / shape.size[:2], 0.1)
    beam = min(0.11 / float(shape.size[2]), 0.04)
    blue, orange = colour("blue", 0.75, 1.05), colour("orange", 0.95, 1.0)
    y_ends = (0.0, post[1]), (1 - post[1], 1.0)
    parts = []
    for x in (0.0, 1 - post[0]):
        parts += [part((x, x + post[0]), y, (0.0, 1.0), blue, without="-z") for y in y_ends]
        brace = low[0] + (x + post[0] / 2) * shape.size[0]
        sides = [low[1] + share * shape.size[1] for share in (post[1] / 2, 1 - post[1] / 2)]
        z = low[2] + shape.size[2] * (np.arange(5) / 4.2 + 0.02)
        for k in range(4):
            start, end = (brace, sides[k % 2 - 1], z[k]), (brace, sides[-(k % 2)], z[k + 1])
            parts.append(rod(start, end, 0.027, blue, segments=4))
    floors = (0.04, 0.38, 0.71)
    for i, (floor, above) in enumerate(pairwise((*floors, 1.0 + beam))):
        span = post[0], 1 - post[0]
        for y in ((0.0, post[1] / 2), (1 - post[1], 1 - post[1] / 2)):
            parts.append(part(span, y, (floor - beam, floor), orange))
        planks = (floor - 0.02 * beam, floor + 0.02 * beam)
        parts.append(part(span, (0.0, 1.0), planks, board(i), along=True, without="-x +x -y +y"))
        corner = low + shape.size * (span[0], 0, floor)
        parts += _goods(corner, low + shape.size * (span[1], 1, above - beam), i, rng)
    return parts


def _goods(low: FloatArray, high: FloatArray, floor: int, rng: np.random.Generator) -> list[Part]:
    """Build the goods on a floor of a rack, in bays a metre wide."""
    size = high - low
    bays = max(1, min(6, round(float(size[0]))))
    pitch = size[0] / bays
    parts: list[Part] = []
    for bay in range(bays):
        start = low + np.array([(bay + 0.06) * pitch, 0.08 * size[1], 0.0])
        height = size[2] * float(rng.choice([0.55, 0.75, 0.9]))
        end = np.array([start[0] + 0.88 * pitch, high[1] - 0.08 * size[1], low[2] + height])
        what = (bay + 2 * floor) % 3
        if what == 0:
            bin_ = colour("sky", 0.6, 0.85)
            parts.append(box(start, end, bin_, tops=colour("sky", 0.5, 0.5), without="-z"))
        else:
            parts += cartons(start, end, rng)
    return parts


@drawn("barrel", gloss=True)
def barrel(shape: Shape, rng: np.random.Generator) -> list[Part]:
    """Build a blue steel drum."""
    x, y, z = shape.middle[0], shape.middle[1], shape.low[2]
    radius, height = float(shape.size[:2].min()) / 2, float(shape.size[2])
    blue, rib = colour("blue", 0.7, 1.05), 0.955
    profile = [(0.97, 0.0), (1.0, 0.015), (0.97, 0.04), (rib, 0.05)]
    for at in (0.34, 0.66):
        profile += [(rib, at - 0.03), (1.0, at - 0.012), (1.0, at + 0.012), (rib, at + 0.03)]
    profile += [(rib, 0.95), (0.98, 0.965), (1.0, 0.985), (0.98, 1.0), (0.92, 1.0), (0.91, 0.97)]
    shell = np.array(profile) * (radius, height)
    lid = z + 0.97 * height
    parts = [
        turned(shell, blue, centre=(x, y, z), segments=20, smooth=True),
        disc((x, y, lid), 0.92 * radius, colour("blue", 0.85, 0.85), segments=20),
    ]
    for angle, size in ((0.6, 0.13 * radius), (3.6, 0.08 * radius)):
        bung = x + 0.6 * radius * np.cos(angle), y + 0.6 * radius * np.sin(angle)
        rim = [(size, 0), (size, 0.018 * height)]
        parts.append(turned(rim, colour("steel"), centre=(*bung, lid), segments=8))
        parts.append(disc((*bung, lid + 0.018 * height), size, colour("light"), segments=8))
    return parts


@drawn("cone")
def cone(shape: Shape, rng: np.random.Generator) -> list[Part]:
    """Build a traffic cone."""
    (x, y, _), (low, high) = shape.middle, (shape.low, shape.high)
    radius, height = 0.4 * float(shape.size[:2].min()), float(shape.size[2])
    foot = 0.06 * height
    profile = [(radius, 0.0), (0.16 * radius, height - foot)]
    top = (x, y, high[2])
    return [
        box(low, (high[0], high[1], low[2] + foot), colour("orange", 0.7, 0.9)),
        turned(profile, patch("cone"), centre=(x, y, low[2] + foot), segments=16),
        disc(top, 0.16 * radius, colour("dark"), segments=16),
    ]


@drawn("other")
def other(shape: Shape, rng: np.random.Generator) -> list[Part]:
    """Build a steel case with a darker rim."""
    low, high = shape.low, shape.high
    rim = 0.06 * shape.size * (0, 0, 1)
    return [
        box(low, (*high[:2], low[2] + rim[2]), colour("dark")),
        box(low + rim, high - rim, patch("plate"), without="-z +z"),
        box((*low[:2], high[2] - rim[2]), high, colour("dark", 0.8, 1.0), tops=patch("plate")),
    ]


_PANEL_M = 1.2
"""Length of a piece of a container's wall."""
_CELLS = 12, 8
"""Cells of a heap's surface, along and across."""


@drawn("container")
def container(shape: Shape, rng: np.random.Generator) -> list[Part]:
    """Build a container for ships: corrugated steel, with doors at its ends."""
    part, size = inside(shape.low, shape.high), shape.size
    rust, wall = colour("brown", 0.6, 0.9), patch("corrugated")
    post_x, post_y = 0.12 / max(1.2, size[0]), 0.12 / max(1.2, size[1])
    panels = np.linspace(post_x, 1 - post_x, max(2, round(float(size[0]) / _PANEL_M)) + 1)
    parts = [
        part((a, b), (0.01, 0.99), (0.0, 0.99), wall, tops=wall, without="-x +x -z")
        for a, b in pairwise(panels)
    ]
    doors, ends = patch("doors"), (post_y, 1 - post_y)
    parts.append(part((0.004, 0.996), ends, (0.0, 0.99), doors, without="-y +y -z +z"))
    for y in ((0.0, post_y), (1 - post_y, 1.0)):
        parts += [part(x, y, (0.0, 1.0), rust) for x in ((0.0, post_x), (1 - post_x, 1.0))]
        parts += [part((0.0, 1.0), y, z, rust) for z in ((0.0, 0.05), (0.96, 1.0))]
    return parts


@drawn("sign")
def sign(shape: Shape, rng: np.random.Generator) -> list[Part]:
    """Build a board with an arrow and lines of writing on a steel post with a foot."""
    part, size = inside(shape.low, shape.high), shape.size
    post = [min(0.5, 0.04 / length) for length in size[:2].tolist()]
    upright = [(0.5 - half, 0.5 + half) for half in post]
    board = min(0.55, float(size[:2].max() / size[2]))
    thick = min(0.2, 0.03 / float(size[0])), min(0.2, 0.03 / float(size[1]))
    x, y, sides = (0.0, 1.0), (0.5 - thick[1], 0.5 + thick[1]), "-x +x"
    if size[1] >= size[0]:
        x, y, sides = (0.5 - thick[0], 0.5 + thick[0]), (0.0, 1.0), "-y +y"
    return [
        part((0.0, 1.0), (0.0, 1.0), (0.0, 0.04), colour("concrete")),
        part(*upright, (0.0, 1 - board), colour("steel", 0.7, 1.0)),
        part(x, y, (1 - board, 1.0), colour("steel")),
        part(_wider(x), _wider(y), (1 - board, 1.0), patch("sign"), without=f"{sides} -z +z"),
    ]


def _wider(span: tuple[float, float]) -> tuple[float, float]:
    """Return a span that lies just outside of another, unless that is all there is."""
    return max(0.0, span[0] - 0.01), min(1.0, span[1] + 0.01)


@drawn("berm")
def berm(shape: Shape, rng: np.random.Generator) -> list[Part]:
    """Build a long heap of earth."""
    u, v = (np.linspace(0, 1, n + 1) for n in _CELLS)
    u, v = np.meshgrid(u, v, indexing="ij")
    height = np.minimum(1, 3 * np.minimum(u, 1 - u)) * np.sin(np.pi * v) ** 0.8
    height *= 1 - 0.16 * rng.random(u.shape)
    height /= height.max()
    at = shape.low + shape.size * np.stack((u, v, height), axis=2)
    cells = np.stack((at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]), axis=2)
    return [quads(cells.reshape(-1, 4, 3), patch("earth"))]
