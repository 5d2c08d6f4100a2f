"""One picture with the colours and the surfaces of all things, and the finishes that use it.

The picture has 4 x 4 cells. The first holds plain colours, each from dark to bright, so that
a part can be darker where less light gets; the others hold patches such as planks and tyres.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np

from corpus_tools.world.looks.noise import Pixels, grain, pixels, speckle
from g3.groundings import FloatArray

CELL = 128
CELLS = 4
SIZE = CELL * CELLS

_COLOURS = {
    "yellow": (246, 178, 26),
    "black": (40, 41, 44),
    "dark": (66, 69, 74),
    "steel": (150, 155, 162),
    "light": (206, 209, 212),
    "white": (240, 240, 238),
    "red": (196, 44, 36),
    "orange": (240, 104, 24),
    "blue": (36, 92, 158),
    "navy": (42, 58, 92),
    "sky": (150, 186, 214),
    "glass": (92, 122, 146),
    "amber": (255, 158, 30),
    "lamp": (255, 246, 214),
    "skin": (216, 164, 132),
    "denim": (58, 78, 118),
    "rubber": (58, 58, 62),
    "wood": (196, 158, 106),
    "green": (66, 122, 84),
    "brown": (112, 78, 48),
    "lime": (206, 232, 52),
    "silver": (222, 226, 230),
    "concrete": (170, 168, 162),
    "teal": (44, 128, 140),
}
_COLUMNS, _SWATCH_WIDTH, _SWATCH_HEIGHT = 4, 32, 16
_DARKEST, _BRIGHTEST = 0.35, 1.1


@dataclass(frozen=True, slots=True)
class Finish:
    """How a surface is coloured: a rectangle of the atlas.

    Parameters
    ----------
    low, high
        Opposite corners in the atlas, from 0 to 1.
    shaded
        Whether the place in the rectangle says how much light there is, instead of where
        on the surface it is.
    """

    low: tuple[float, float]
    high: tuple[float, float]
    shaded: bool = False

    def uv(self, st: FloatArray, up: FloatArray) -> FloatArray:
        """Places in the atlas of points (n, 2) of a surface, from 0 to 1, with light (n,)."""
        if self.shaded:
            st = np.stack((up, np.full(len(st), 0.5)), axis=1)
        low, high = np.array(self.low), np.array(self.high)
        uv: FloatArray = low + st * (high - low)
        return uv


def colour(name: str, low: float = 0.75, high: float = 1.0) -> Finish:
    """A plain colour; the lowest and the highest points get that much of the light."""
    row, column = divmod(list(_COLOURS).index(name), _COLUMNS)
    v = (row + 0.5) * _SWATCH_HEIGHT / SIZE
    start, width = column * _SWATCH_WIDTH + 1.5, _SWATCH_WIDTH - 3

    def u(light: float) -> float:
        part = (light - _DARKEST) / (_BRIGHTEST - _DARKEST)
        return float((start + width * min(max(part, 0.0), 1.0)) / SIZE)

    return Finish((u(low), v), (u(high), v), shaded=True)


def patch(name: str, s: tuple[float, float] = (0, 1), t: tuple[float, float] = (0, 1)) -> Finish:
    """A surface of the atlas, or the part of it from `s` and `t` to `s` and `t`."""
    row, column = divmod(1 + list(_PATCHES).index(name), CELLS)
    margin = 2.0
    start = np.array([column, row]) * CELL + margin
    low, high = (start + np.array([s, t]).T * (CELL - 2 * margin)) / SIZE
    return Finish((float(low[0]), float(low[1])), (float(high[0]), float(high[1])))


def board(k: int) -> Finish:
    """The grain of the k-th of eight boards of raw wood, to be used ``along`` the edges."""
    return patch("boards", t=((k % 8 + 0.12) / 8, (k % 8 + 0.88) / 8))


@lru_cache(maxsize=1)
def picture() -> Pixels:
    """The atlas, shape (SIZE, SIZE, 3)."""
    atlas = np.zeros((SIZE, SIZE, 3))
    light = np.clip((np.arange(_SWATCH_WIDTH) - 1) / (_SWATCH_WIDTH - 3), 0, 1)
    light = _DARKEST + (_BRIGHTEST - _DARKEST) * light
    for i, rgb in enumerate(_COLOURS.values()):
        row, column = divmod(i, _COLUMNS)
        y, x = row * _SWATCH_HEIGHT, column * _SWATCH_WIDTH
        atlas[y : y + _SWATCH_HEIGHT, x : x + _SWATCH_WIDTH] = light[:, None] * np.array(rgb)
    for i, paint in enumerate(_PATCHES.values(), start=1):
        row, column = divmod(i, CELLS)
        y, x = row * CELL, column * CELL
        atlas[y : y + CELL, x : x + CELL] = paint(np.random.default_rng([7, i]))
    return pixels(atlas)


def _filled(rgb: tuple[float, float, float]) -> FloatArray:
    return np.tile(np.array(rgb, dtype=float), (CELL, CELL, 1))


def _rect(
    image: FloatArray,
    s: tuple[float, float],
    t: tuple[float, float],
    rgb: tuple[float, float, float] | float,
) -> None:
    """Fill a rectangle with a colour, or scale what is there."""
    x, y = (slice(round(a * CELL), round(b * CELL)) for a, b in (s, t))
    image[y, x] = image[y, x] * rgb if isinstance(rgb, float) else rgb


def _boards(rng: np.random.Generator) -> FloatArray:
    """Eight raw boards, one above the other, each of another tone."""
    image = _filled((204, 168, 118))
    rows = CELL // 8
    for k in range(8):
        tone = (0.86, 1.0, 0.93, 1.06, 0.9, 1.02, 0.82, 0.97)[k]
        streaks = grain(rng, rows, CELL)[..., None]
        image[k * rows : (k + 1) * rows] *= tone * (0.88 + 0.2 * streaks)
    return image


def _deck(rng: np.random.Generator) -> FloatArray:
    """Planks of a cargo deck along s, with gaps between them."""
    image = _filled((150, 112, 74))
    planks = 6
    edges = np.linspace(0, CELL, planks + 1).round().astype(int)
    for k, (low, high) in enumerate(pairwise(edges)):
        tone = (0.95, 1.06, 0.88, 1.02, 0.92, 1.08)[k]
        image[low:high] *= tone * (0.82 + 0.26 * grain(rng, high - low, CELL))[..., None]
        image[high - 2 : high] *= 0.45
    return image


def _carton(rng: np.random.Generator, rgb: tuple[float, float, float]) -> FloatArray:
    """The side of a carton: tape, a label with bars, arrows that point up, worn edges."""
    image = _filled(rgb) * (0.95 + 0.08 * speckle(rng, CELL))[..., None]
    image *= np.linspace(0.84, 1.03, CELL)[:, None, None]
    _rect(image, (0.44, 0.56), (0.72, 1), (206, 178, 128))
    _rect(image, (0.44, 0.56), (0, 0.14), (190, 160, 112))
    _rect(image, (0.09, 0.36), (0.2, 0.42), (236, 233, 224))
    for left, wide in ((0.12, 0.02), (0.16, 0.03), (0.21, 0.015), (0.25, 0.03), (0.30, 0.02)):
        _rect(image, (left, left + wide), (0.24, 0.38), (60, 58, 56))
    for middle in (0.72, 0.86):
        _rect(image, (middle - 0.015, middle + 0.015), (0.22, 0.36), 0.5)
        for k in range(6):
            half, t = 0.05 * (1 - k / 6), 0.36 + k * 0.016
            _rect(image, (middle - half, middle + half), (t, t + 0.016), 0.5)
    return _edged(image, 0.8)


def _carton_top(rng: np.random.Generator) -> FloatArray:
    """The top of a carton: two flaps and a strip of tape over the slit."""
    image = _filled((197, 152, 98)) * (0.95 + 0.08 * speckle(rng, CELL))[..., None]
    _rect(image, (0, 1), (0.49, 0.51), 0.6)
    _rect(image, (0, 1), (0.43, 0.57), (216, 190, 140))
    return _edged(image, 0.82)


def _edged(image: FloatArray, factor: float) -> FloatArray:
    for s, t in (
        ((0, 1), (0, 0.03)),
        ((0, 1), (0.97, 1)),
        ((0, 0.03), (0, 1)),
        ((0.97, 1), (0, 1)),
    ):
        _rect(image, s, t, factor)
    return image


def _tyre(rng: np.random.Generator) -> FloatArray:
    """A tyre from its inside over its side and tread: t goes over the rubber, s around it."""
    image = _filled((52, 52, 56)) * (0.92 + 0.14 * speckle(rng, CELL))[..., None]
    t = (np.arange(CELL) + 0.5) / CELL
    across = np.abs(2 * t - 1)
    bright = np.interp(
        across,
        [0, 0.26, 0.33, 0.36, 0.5, 0.56, 0.62, 0.72, 0.76, 0.84, 1],
        [1, 1.0, 1.7, 1.75, 1.3, 1.3, 1.8, 1.5, 1.2, 0.5, 0.28],
    )
    image *= bright[:, None, None]
    lug = 8
    s = np.arange(CELL)
    for side in (-1, 1):
        rows = (side * (2 * t - 1) > 0.03) & (across < 0.3)
        slant = (across[rows] * 14).astype(int)
        groove = ((s[None, :] + slant[:, None] + (lug // 2 if side > 0 else 0)) % lug) < 3
        image[rows] *= np.where(groove, 0.45, 1.12)[..., None]
    image[np.abs(across) < 0.035] *= 0.45
    return image


def _hazard(rng: np.random.Generator) -> FloatArray:
    """Slanting stripes, yellow and black."""
    s, t = np.meshgrid(np.arange(CELL), np.arange(CELL))
    yellow = ((s + t) // (CELL // 4)) % 2 == 0
    colours = np.where(yellow[..., None], (244.0, 186, 32), (38.0, 38, 40))
    worn: FloatArray = colours * (0.94 + 0.08 * speckle(rng, CELL))[..., None]
    return worn


def _wheel(rng: np.random.Generator) -> FloatArray:
    """A steel wheel seen from the side, with a hub and bolts; black in the corners."""
    centre = (CELL - 1) / 2
    s, t = np.meshgrid(np.arange(CELL) - centre, np.arange(CELL) - centre)
    radius, angle = np.hypot(s, t) / (CELL / 2), np.arctan2(t, s)
    grey = np.interp(
        radius,
        [0, 0.2, 0.22, 0.3, 0.34, 0.7, 0.8, 0.86, 0.95, 1],
        [150, 190, 90, 190, 200, 176, 140, 214, 220, 120],
    )
    bolts = (np.abs(radius - 0.46) < 0.06) & (np.abs(np.sin(4 * angle)) < 0.35)
    grey = np.where(bolts, 86, grey)
    holes = (np.abs(radius - 0.68) < 0.07) & (np.abs(np.cos(4 * angle)) < 0.35)
    grey = np.where(holes, 52, grey) * (0.95 + 0.08 * speckle(rng, CELL))
    return np.repeat(grey[..., None], 3, axis=2)


def _vest(rng: np.random.Generator) -> FloatArray:
    """A warning vest: s around the body, t up it, with bands that reflect."""
    image = _filled((250, 108, 22)) * (0.94 + 0.1 * speckle(rng, CELL))[..., None]
    for low in (0.16, 0.44):
        _rect(image, (0, 1), (low - 0.02, low + 0.16), (214, 236, 60))
        _rect(image, (0, 1), (low + 0.03, low + 0.11), (236, 238, 236))
    for middle in (0.12, 0.38, 0.62, 0.88):
        _rect(image, (middle - 0.045, middle + 0.045), (0.55, 1), (214, 236, 60))
        _rect(image, (middle - 0.022, middle + 0.022), (0.55, 1), (236, 238, 236))
    return image


def _crate(rng: np.random.Generator) -> FloatArray:
    """The side of a crate: planks across, a frame with a brace around them, nails."""
    image = _filled((176, 126, 74))
    planks = np.linspace(0, CELL, 7).round().astype(int)
    for k, (low, high) in enumerate(pairwise(planks)):
        tone = (0.98, 0.9, 1.04, 0.93, 1.0, 0.88)[k]
        image[low:high] *= tone * (0.84 + 0.24 * grain(rng, high - low, CELL))[..., None]
        image[high - 2 : high] *= 0.4
    s, t = np.meshgrid(np.arange(CELL), np.arange(CELL))
    brace = np.abs(s - t) < 0.11 * CELL
    frame = np.minimum(np.minimum(s, CELL - 1 - s), np.minimum(t, CELL - 1 - t)) < 0.15 * CELL
    wood = (200.0, 154, 98) * (0.86 + 0.2 * grain(rng, CELL, CELL))[..., None]
    image[brace] = wood[brace]
    image[(np.abs(s - t) >= 0.11 * CELL) & (np.abs(s - t) < 0.14 * CELL)] *= 0.5
    image[frame] = wood[frame]
    rim = np.minimum(np.minimum(s, CELL - 1 - s), np.minimum(t, CELL - 1 - t))
    image[(rim >= 0.15 * CELL) & (rim < 0.175 * CELL)] *= 0.45
    for a in (0.07, 0.5, 0.93):
        for b in (0.07, 0.93):
            for x, y in ((a, b), (b, a)):
                _rect(image, (x - 0.012, x + 0.012), (y - 0.012, y + 0.012), (70, 62, 54))
    return image


def _grille(rng: np.random.Generator) -> FloatArray:
    """The front of a truck: a grille of bars between two lamps, with a bumper below."""
    image = _filled((208, 212, 216)) * (0.97 + 0.05 * speckle(rng, CELL))[..., None]
    _rect(image, (0.22, 0.78), (0.3, 0.92), (44, 46, 50))
    for k in range(5):
        _rect(image, (0.22, 0.78), (0.36 + 0.12 * k, 0.40 + 0.12 * k), (176, 180, 186))
    for left in (0.03, 0.81):
        _rect(image, (left, left + 0.16), (0.42, 0.72), (70, 72, 76))
        _rect(image, (left + 0.02, left + 0.14), (0.45, 0.69), (255, 248, 220))
        _rect(image, (left, left + 0.16), (0.3, 0.38), (250, 150, 30))
    _rect(image, (0, 1), (0, 0.22), (58, 60, 64))
    _rect(image, (0.36, 0.64), (0.06, 0.16), (232, 232, 226))
    return image


def _window(rng: np.random.Generator) -> FloatArray:
    """Glass that mirrors the sky, in a dark frame."""
    image = _filled((1, 1, 1))
    s, t = np.meshgrid(np.arange(CELL) / CELL, np.arange(CELL) / CELL)
    image *= np.stack((44 + 74 * t, 60 + 92 * t, 76 + 104 * t), axis=2)
    shine = ((s + 0.6 * t) % 1.0 > 0.62) & ((s + 0.6 * t) % 1.0 < 0.74)
    image[shine] = image[shine] * 1.16 + 10
    rim = np.minimum(np.minimum(s, 1 - s), np.minimum(t, 1 - t)) < 0.05
    image[rim] = (34, 35, 38)
    return image * (0.98 + 0.03 * speckle(rng, CELL))[..., None]


def _plate(rng: np.random.Generator) -> FloatArray:
    """Steel plate with raised studs."""
    image = _filled((132, 138, 146)) * (0.93 + 0.12 * speckle(rng, CELL))[..., None]
    s, t = np.meshgrid(np.arange(CELL), np.arange(CELL))
    u, v = (s + t) % 16, (s - t) % 16
    flat = (s // 16 + t // 16) % 2 == 0
    stud = np.where(
        flat, (np.abs(u - 8) < 2) & (np.abs(v - 8) < 6), (np.abs(v - 8) < 2) & (np.abs(u - 8) < 6)
    )
    image[stud] *= 1.22
    return image


def _cone(rng: np.random.Generator) -> FloatArray:
    """A traffic cone: t goes up it."""
    image = _filled((244, 92, 22)) * (0.94 + 0.08 * speckle(rng, CELL))[..., None]
    _rect(image, (0, 1), (0.34, 0.52), (240, 240, 236))
    _rect(image, (0, 1), (0.68, 0.84), (240, 240, 236))
    return image * np.linspace(0.86, 1.05, CELL)[:, None, None]


_PATCHES: dict[str, Callable[[np.random.Generator], FloatArray]] = {
    "boards": _boards,
    "deck": _deck,
    "carton": lambda rng: _carton(rng, (196, 150, 96)),
    "carton-dark": lambda rng: _carton(rng, (172, 126, 78)),
    "carton-top": _carton_top,
    "tyre": _tyre,
    "hazard": _hazard,
    "wheel": _wheel,
    "vest": _vest,
    "crate": _crate,
    "grille": _grille,
    "window": _window,
    "plate": _plate,
    "cone": _cone,
}
