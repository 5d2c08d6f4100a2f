"""Shadows of the sun, and the parts of a picture that moving things and their shadows take up.

Shadows are looked up in depths that are drawn as the sun sees them.

Coordinates u and v lie across the sunlight, d along it, all in metres.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from corpus_tools.video.drawing.camera import Camera
from corpus_tools.video.drawing.canvas import MOVING, STILL, Canvas, Depth, Image, Rectangle
from g3.groundings import FloatArray
from g3.short_repr import short_repr

Float32Array = npt.NDArray[np.float32]

LARGEST_MAP = 2048
"""Most texels along one edge."""
BIAS_TEXELS = 2.5
"""Least distance behind the caster of a shadow, in texels; nearer, a thing would shade itself."""
NOTHING = np.float32(1e6)
_TURN = np.pi * (3 - np.sqrt(5)) * np.arange(9)
_DISC = np.sqrt((np.arange(9) + 0.5) / 9) * np.stack((np.cos(_TURN), np.sin(_TURN)))
"""Points u, v of a lamp with radius 1, spread evenly, shape (2, 9)."""


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class ShadowMap:
    """Distances along the sunlight to the first thing."""

    first: tuple[float, float]
    """Column and row of the map's corner, in texels from u = v = 0."""
    texel: float
    """Length of a texel's edge."""
    depth: Depth
    """The d of the first thing in the light, :data:`NOTHING` for nothing, shape (h, w)."""

    @property
    def bias(self) -> float:
        """Least distance behind the caster of a shadow for things on the map itself."""
        return BIAS_TEXELS * self.texel


def sunlight(direction: FloatArray) -> FloatArray:
    """Return unit vectors along u, v and d, shape (3, 3), for light in a direction (3,)."""
    ahead = direction / np.linalg.norm(direction)
    side = np.array([0.0, 1.0, 0.0]) if abs(ahead[1]) < 0.9 else np.array([1.0, 0.0, 0.0])
    right = np.cross(ahead, side)
    right /= np.linalg.norm(right)
    return np.stack((right, np.cross(right, ahead), ahead))


class Shadows:
    """Casters of shadows in a canvas's world with a sun; at the start as the canvas's data are.

    `wanted` is the edge of the maps' texels in metres; longer where the world is large. `axes` are
    as :func:`sunlight` gives them; `still` is the map of what never moves, None if nothing does;
    `lamp_m` is the radius of soft edges, 0 for sharp ones.
    """

    def __init__(self, canvas: Canvas, texel_m: float) -> None:
        self._canvas = canvas
        self.axes = sunlight(canvas.data.light_xdir[canvas.sun])
        self.lamp_m = float(canvas.model.light_bulbradius[canvas.sun])
        still = canvas.corners(canvas.geoms_of(STILL))
        along = np.concatenate((still, canvas.corners(canvas.geoms_of(MOVING)))) @ self.axes.T
        self.texel = max(texel_m, _extent(along) / (LARGEST_MAP - 4))
        self.still = self._map(still, STILL, self.texel) if len(still) else None

    def moving(self, corners: FloatArray) -> ShadowMap:
        """Return the map of the moving things at their present poses, within corners (n, 3)."""
        return self._map(corners, MOVING, self.texel)

    def moving_alone(self, corners: FloatArray, texel_m: float) -> ShadowMap:
        """Return such a map, not to be merged with that of still things, as fine as needed."""
        texel = max(texel_m, _extent(corners @ self.axes.T) / (LARGEST_MAP - 4))
        return self._map(corners, MOVING, texel)

    def _map(self, points: FloatArray, group: int, texel: float) -> ShadowMap:
        along = points @ self.axes.T
        low, high = along.min(axis=0), along.max(axis=0)
        x, y = (int(np.floor(value / texel)) - 1 for value in low[:2])
        # What moves can go so far that a map of all of it would be too large.
        width, height = (
            min(int(np.ceil(value / texel)) + 1 - start, LARGEST_MAP)
            for value, start in zip(high[:2], (x, y), strict=True)
        )
        corner = np.array([x * texel, y * texel, low[2] - 0.1])
        far = np.array([(x + width) * texel, (y + height) * texel, high[2] + 0.1])
        self._canvas.draw_along(self.axes, corner, far, (width, height), group)
        drawn = self._canvas.depth()
        depth = np.float32(corner[2]) + drawn * np.float32(far[2] - corner[2])
        depth[drawn >= 1] = NOTHING
        return ShadowMap((x, y), texel, depth)


def _extent(along: FloatArray) -> float:
    return float(np.ptp(along[:, :2], axis=0).max())


def merged(ours: ShadowMap, other: ShadowMap) -> ShadowMap:
    """Return our map with the other things that the light meets first there."""
    height, width = ours.depth.shape
    x, y = ours.first[0] - other.first[0], ours.first[1] - other.first[1]
    rows = slice(max(0, y), max(0, min(other.depth.shape[0], y + height)))
    columns = slice(max(0, x), max(0, min(other.depth.shape[1], x + width)))
    depth = ours.depth.copy()
    if rows.start < rows.stop and columns.start < columns.stop:
        here = depth[rows.start - y : rows.stop - y, columns.start - x : columns.stop - x]
        np.minimum(here, other.depth[rows, columns], out=here)
    return ShadowMap(ours.first, ours.texel, depth)


def shade(
    map_: ShadowMap, place: Float32Array, bias: float, soft: int, lamp_m: float = 0.0
) -> Image:
    """Return the share of the sun at places, from 0, none, to 255, all of it; shape (h, w).

    `place` has u, v and d of each pixel, shape (3, h, w). `bias` is how far behind another thing a
    place must be to be in its shadow, `soft` the width of shadows' edges in pixels, `lamp_m` their
    radius in metres.
    """
    u, v, d = place
    scale = np.float32(1 / map_.texel)
    x = u * scale - np.float32(map_.first[0] + 0.5)
    y = v * scale - np.float32(map_.first[1] + 0.5)
    share = np.zeros(d.shape, np.float32)
    points = _DISC.T * lamp_m / map_.texel if lamp_m else np.zeros((1, 2))
    for at_u, at_v in points.astype(np.float32):
        first = cv2.remap(
            map_.depth,
            x + at_u,
            y + at_v,
            cv2.INTER_NEAREST,
            borderMode=cv2.BORDER_CONSTANT,
            borderValue=float(NOTHING),
        )
        first += np.float32(bias)
        cv2.accumulate(cv2.compare(d, first, cv2.CMP_LE), share)
    sunny = cv2.convertScaleAbs(share, alpha=1 / len(points))
    return np.asarray(cv2.blur(sunny, (soft, soft)), np.uint8)


def places(camera: Camera, size: tuple[int, int], axes: FloatArray) -> tuple[Float32Array, ...]:
    """Return u, v and d for each metre ahead at each pixel (3, h, w), and start (3, 1, 1).

    Rows run from the bottom up.
    """
    right, down, ahead = (axes @ camera.axes.T).T.astype(np.float32)
    focal = size[1] / 2 / np.tan(camera.fovy / 2)
    x = ((np.arange(size[0]) + 0.5 - size[0] / 2) / focal).astype(np.float32)
    y = ((np.arange(size[1]) + 0.5 - size[1] / 2) / focal).astype(np.float32)
    across = right[:, None] * x + ahead[:, None]
    rays = across[:, None, :] - (down[:, None] * y)[:, :, None]
    return rays, (axes @ camera.position).astype(np.float32)[:, None, None]


def lit(dark: Image, sunshine: Image, sun: Image) -> Image:
    """Add the share of the sun's light that :func:`shade` gives to a picture without the sun."""
    share = cv2.merge((sun, sun, sun))
    return np.asarray(cv2.add(dark, cv2.multiply(sunshine, share, scale=1 / 255)), np.uint8)


def ahead_of(depth: Depth, clip: tuple[float, float]) -> Float32Array:
    """Return the distances ahead of a camera with perspective, of drawn depths, in metres."""
    near, far = clip
    metres: Float32Array = np.float32(near * far) / (
        np.float32(far) - depth * np.float32(far - near)
    )
    return metres


PAD = 4
"""Pixels of frames around moving things that are drawn again: shadows' edges are soft."""


def moving_parts(
    canvas: Canvas,
    geoms: npt.NDArray[np.int64],
    camera: Camera,
    size: tuple[int, int],
    *,
    light: FloatArray,
    ground_m: float,
    lamp_m: float = 0.0,
) -> list[tuple[Rectangle, FloatArray]]:
    """Return the parts of the frame with moving things, and corners around these things.

    Something was drawn on the canvas already. `geoms` are those of all that moves; `light` is where
    the sunlight goes, shape (3,), `lamp_m` the radius of shadows' edges.
    """
    parts: list[tuple[Rectangle, FloatArray]] = []
    of = canvas.object_of_geom[geoms]
    for item in np.unique(of):
        corners = canvas.corners(geoms[of == item])
        rectangle = covering(
            with_shadow(corners, light, ground_m, lamp_m), camera, size, near_m=canvas.clip()[0]
        )
        if rectangle is None:
            continue
        # Parts that overlap become one, which may overlap others.
        while other := next((o for o in parts if o[0].overlaps(rectangle)), None):
            parts = [o for o in parts if o is not other]
            rectangle = other[0].union(rectangle)
            corners = np.concatenate((other[1], corners))
        parts.append((rectangle, corners))
    return parts


def with_shadow(
    corners: FloatArray, light: FloatArray, ground_m: float, lamp_m: float = 0.0
) -> FloatArray:
    """Return corners (n, 3), and those of their shadows on the ground, with edges of a radius."""
    height = np.maximum(corners[:, 2:] - ground_m, 0)
    shadow = corners + height / max(1e-3, -light[2]) * light
    around = [np.array([x, y, 0.0]) * lamp_m for x in (-1, 1) for y in (-1, 1)]
    edges = [shadow + offset for offset in around] if lamp_m else [shadow]
    return np.concatenate((corners, *edges))


def covering(
    corners: FloatArray, camera: Camera, size: tuple[int, int], *, near_m: float
) -> Rectangle | None:
    """Return the part of the frame with all inside corners (n, 3); None if there is none."""
    pixels, depth = camera.project(corners, size)
    if (depth < near_m).any():
        return Rectangle(0, 0, *size)
    pixels[:, 1] = size[1] - pixels[:, 1]
    low = np.clip(np.floor(pixels.min(axis=0)).astype(int) - PAD, 0, size)
    high = np.clip(np.ceil(pixels.max(axis=0)).astype(int) + PAD, 0, size)
    if (low >= high).any():
        return None
    return Rectangle(*low.tolist(), *(high - low).tolist())
