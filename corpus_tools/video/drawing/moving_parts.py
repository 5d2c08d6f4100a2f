"""Which parts of a picture what moves takes up, with its shadow."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from corpus_tools.video.drawing.camera import Camera
from corpus_tools.video.drawing.canvas import Canvas, Rectangle
from g3.groundings import FloatArray

PAD = 4
"""Pixels of frames around what moves that are drawn anew: shadows' edges are soft."""


def moving_parts(
    canvas: Canvas,
    geoms: npt.NDArray[np.int64],
    camera: Camera,
    size: tuple[int, int],
    *,
    light: FloatArray,
    ground_m: float,
) -> list[tuple[Rectangle, FloatArray]]:
    """Parts of the frame where something moves, and corners around what it is.

    Something was drawn on the canvas already. `geoms` are those of all that moves; `light` is where
    the sunlight goes, shape (3,).
    """
    found: list[tuple[Rectangle, FloatArray]] = []
    of = canvas.object_of_geom[geoms]
    for item in np.unique(of):
        corners = canvas.corners(geoms[of == item])
        rectangle = covering(
            with_shadow(corners, light, ground_m), camera, size, near_m=canvas.clip()[0]
        )
        if rectangle is None:
            continue
        # Parts that overlap become one, which may overlap others.
        while other := next((o for o in found if o[0].overlaps(rectangle)), None):
            found = [o for o in found if o is not other]
            rectangle = other[0].union(rectangle)
            corners = np.concatenate((other[1], corners))
        found.append((rectangle, corners))
    return found


def with_shadow(corners: FloatArray, light: FloatArray, ground_m: float) -> FloatArray:
    """Corners (n, 3), and where their shadows are on the ground (2 n, 3)."""
    height = np.maximum(corners[:, 2:] - ground_m, 0)
    return np.concatenate((corners, corners + height / max(1e-3, -light[2]) * light))


def covering(
    corners: FloatArray, camera: Camera, size: tuple[int, int], *, near_m: float
) -> Rectangle | None:
    """The part of the frame with what is inside corners (n, 3); None if there is none."""
    pixels, depth = camera.project(corners, size)
    if (depth < near_m).any():
        return Rectangle(0, 0, *size)
    pixels[:, 1] = size[1] - pixels[:, 1]
    low = np.clip(np.floor(pixels.min(axis=0)).astype(int) - PAD, 0, size)
    high = np.clip(np.ceil(pixels.max(axis=0)).astype(int) + PAD, 0, size)
    if (low >= high).any():
        return None
    return Rectangle(*low.tolist(), *(high - low).tolist())
