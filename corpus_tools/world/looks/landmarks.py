"""Large things that stay where they are: containers, signs, heaps of earth."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from corpus_tools.world.looks.atlas import colour, patch
from corpus_tools.world.looks.look_registry import drawn
from corpus_tools.world.looks.parts import Part, inside, quads
from corpus_tools.world.state.shapes import Shape

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
