"""One picture with the colours and the surfaces of all things, and the finishes that use it.

``atlas.png`` has 5 x 5 cells. Its first row is the lowest, so surfaces are upside down in it. The
first cell holds plain colours, four in a row. Each goes from dark to bright, so that parts with
less light can be darker. The others hold patches such as planks and tyres, in this order.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from g3.groundings import FloatArray
from g3.short_repr import short_repr

PICTURE = Path(__file__).with_name("atlas.png")

CELL = 128
CELLS = 5
SIZE = CELL * CELLS

# fmt: off
_COLOURS = (
    "yellow", "black", "dark", "steel",
    "light", "white", "red", "orange",
    "blue", "navy", "sky", "glass",
    "amber", "lamp", "skin", "denim",
    "rubber", "wood", "green", "brown",
    "lime", "silver", "concrete", "teal",
)
_PATCHES = (
    "boards", "deck", "carton", "carton-dark",
    "carton-top", "tyre", "hazard", "wheel", "vest",
    "crate", "grille", "window", "plate", "cone",
    "bricks", "washer", "fridge", "vents", "corrugated",
    "doors", "earth", "sign", "cladding", "roller",
)
# fmt: on
_COLUMNS, _SWATCH_WIDTH, _SWATCH_HEIGHT = 4, 32, 16
_DARKEST, _BRIGHTEST = 0.35, 1.1


@short_repr
@dataclass(frozen=True, slots=True)
class Finish:
    """Colouring of a surface: a rectangle of the atlas."""

    low: tuple[float, float]
    high: tuple[float, float]
    """Opposite corners in the atlas, from 0 to 1."""
    shaded: bool = False
    """True if places in the rectangle stand for the amount of light, instead of for places on the
    surface."""

    def uv(self, st: FloatArray, up: FloatArray) -> FloatArray:
        """Return places in the atlas of points (n, 2) of a surface, 0 to 1, with light (n,)."""
        if self.shaded:
            st = np.stack((up, np.full(len(st), 0.5)), axis=1)
        low, high = np.array(self.low), np.array(self.high)
        uv: FloatArray = low + st * (high - low)
        return uv


def colour(name: str, low: float = 0.75, high: float = 1.0) -> Finish:
    """Return a plain colour; the lowest and the highest points get that much of the light."""
    row, column = divmod(_COLOURS.index(name), _COLUMNS)
    v = (row + 0.5) * _SWATCH_HEIGHT / SIZE
    start, width = column * _SWATCH_WIDTH + 1.5, _SWATCH_WIDTH - 3

    def u(light: float) -> float:
        part = (light - _DARKEST) / (_BRIGHTEST - _DARKEST)
        return float((start + width * min(max(part, 0.0), 1.0)) / SIZE)

    return Finish((u(low), v), (u(high), v), shaded=True)


def patch(name: str, s: tuple[float, float] = (0, 1), t: tuple[float, float] = (0, 1)) -> Finish:
    """Return a surface of the atlas, or the part of it from `s` and `t` to `s` and `t`."""
    row, column = divmod(1 + _PATCHES.index(name), CELLS)
    margin = 2.0
    start = np.array([column, row]) * CELL + margin
    low, high = (start + np.array([s, t]).T * (CELL - 2 * margin)) / SIZE
    return Finish((float(low[0]), float(low[1])), (float(high[0]), float(high[1])))


def board(k: int) -> Finish:
    """Return the grain of the k-th of eight boards of raw wood, to be used ``along`` the edges."""
    return patch("boards", t=((k % 8 + 0.12) / 8, (k % 8 + 0.88) / 8))
