"""Frames of a fixed camera: what never moves is drawn once, what moves is put before it.

Everything is drawn once without the sun and once in nothing but its light, which shadows
take away. For the still background both pictures, their depth and the places that the
pixels show are kept, so that shadows of moving things fall rightly on all that is
there. Pictures are twice as wide and high as frames until the end, which smooths edges.
"""

from __future__ import annotations

import cv2
import numpy as np

from corpus_tools.video.drawing.camera import Camera
from corpus_tools.video.drawing.canvas import BACKDROP, MOVING, STILL, Canvas, Image, Rectangle
from corpus_tools.video.drawing.drawn_moments import same_state
from corpus_tools.video.drawing.shadows import Shadows, ahead_of, lit, merged, places, shade
from corpus_tools.world.physics.build import ground_of
from corpus_tools.world.state.recording import Recording
from g3.groundings import FloatArray

FINER = 2
"""How many times wider and higher pictures are than frames."""
PAD = 4
"""Pixels of frames around what moves that are drawn anew: shadows' edges are soft."""
SOFT = 5
"""Width of shadows' edges, pixels of the finer pictures."""
TOUCHING_M = 0.02
"""How far from what shades it something must be; less, and they touch."""
TEXELS_PER_PIXEL = 1.4
FINEST_M, COARSEST_M = 0.008, 0.05
"""Limits of texels' edges in shadow maps."""


class Composite:
    """Frames of a recording, seen by a fixed camera.

    Parameters
    ----------
    canvas
        With the recording's world and its moving objects, and a sun.
    recording
        Sampled at the video's frames.
    camera
        The camera.
    size
        Width and height of a frame; the canvas is larger by :data:`FINER`.
    """

    def __init__(
        self, canvas: Canvas, recording: Recording, camera: Camera, size: tuple[int, int]
    ) -> None:
        self._canvas, self._recording, self._camera, self._size = canvas, recording, camera, size
        self._fine = (size[0] * FINER, size[1] * FINER)
        self._ground = ground_of(recording.start)
        self._geoms = canvas.geoms_of(MOVING)
        canvas.show(recording, 0)
        self._draw_background()
        self._last: tuple[int, Image] | None = None

    def frame(self, k: int) -> Image:
        """The k-th frame, shape (height, width, 3), rows from the top down."""
        if self._last is not None and same_state(self._recording, self._last[0], k):
            return self._last[1]
        self._canvas.show(self._recording, k)
        frame = self._background.copy()
        for part, corners in self._parts():
            self._draw_part(frame, part, corners)
        picture = np.ascontiguousarray(frame[::-1])
        self._last = k, picture
        return picture

    def _draw_background(self) -> None:
        canvas, still = self._canvas, (BACKDROP, STILL)
        canvas.draw(self._camera, self._fine, groups=still, sun=False)
        self._dark = canvas.pixels()
        canvas.draw(self._camera, self._fine, groups=still, sky=False, other_light=False)
        self._sunshine = canvas.pixels()
        self._depth = canvas.depth()
        self._clip = canvas.clip()
        ahead = ahead_of(self._depth, self._clip)
        self._shadows = Shadows(canvas, self._texel(float(np.median(ahead))))
        self._rays, self._eye = places(self._camera, self._fine, self._shadows.axes)
        self._places = self._rays * ahead + self._eye
        if self._shadows.still is not None:
            sun = shade(self._shadows.still, self._places, self._shadows.still.bias, SOFT)
            self._sunshine = lit(np.zeros_like(self._dark), self._sunshine, sun)
        everywhere = np.full(self._depth.shape, 255, np.uint8)
        self._background = _averaged(lit(self._dark, self._sunshine, everywhere))

    def _texel(self, ahead_m: float) -> float:
        """Edge of a shadow map's texels that suits pixels so far ahead."""
        pixel = ahead_m * 2 * np.tan(self._camera.fovy / 2) / self._size[1]
        return float(np.clip(pixel / TEXELS_PER_PIXEL, FINEST_M, COARSEST_M))

    def _parts(self) -> list[tuple[Rectangle, FloatArray]]:
        """Parts of the frame where something moves, and corners around what it is."""
        found: list[tuple[Rectangle, FloatArray]] = []
        of = self._canvas.object_of_geom[self._geoms]
        for item in np.unique(of):
            corners = self._canvas.corners(self._geoms[of == item])
            rectangle = self._covering(corners)
            if rectangle is None:
                continue
            # Parts that overlap become one, which may overlap others.
            while other := next((o for o in found if o[0].overlaps(rectangle)), None):
                found = [o for o in found if o is not other]
                rectangle = other[0].union(rectangle)
                corners = np.concatenate((other[1], corners))
            found.append((rectangle, corners))
        return found

    def _covering(self, corners: FloatArray) -> Rectangle | None:
        """The part of the frame with what is inside corners (n, 3), and its shadow."""
        light = self._shadows.axes[2]
        height = np.maximum(corners[:, 2:] - self._ground, 0)
        shadow = corners + height / max(1e-3, -light[2]) * light
        pixels, depth = self._camera.project(np.concatenate((corners, shadow)), self._size)
        if (depth < self._clip[0]).any():
            return Rectangle(0, 0, *self._size)
        pixels[:, 1] = self._size[1] - pixels[:, 1]
        low = np.clip(np.floor(pixels.min(axis=0)).astype(int) - PAD, 0, self._size)
        high = np.clip(np.ceil(pixels.max(axis=0)).astype(int) + PAD, 0, self._size)
        if (low >= high).any():
            return None
        return Rectangle(*low.tolist(), *(high - low).tolist())

    def _draw_part(self, frame: Image, part: Rectangle, corners: FloatArray) -> None:
        canvas, shadows, fine = self._canvas, self._shadows, part.scaled(FINER)
        here = fine.slices
        moving = shadows.moving(corners)
        sun = shade(moving, self._places[:, here[0], here[1]], TOUCHING_M, SOFT)
        picture = lit(
            np.ascontiguousarray(self._dark[here]),
            np.ascontiguousarray(self._sunshine[here]),
            sun,
        )
        canvas.draw(self._camera, self._fine, groups=(MOVING,), part=fine, sky=False, sun=False)
        dark = canvas.pixels()
        canvas.draw(
            self._camera, self._fine, groups=(MOVING,), part=fine, sky=False, other_light=False
        )
        sunshine, depth = canvas.pixels(), canvas.depth()
        nearer = cv2.compare(depth, np.ascontiguousarray(self._depth[here]), cv2.CMP_LT)
        place = self._rays[:, here[0], here[1]] * ahead_of(depth, self._clip) + self._eye
        casting = merged(moving, shadows.still) if shadows.still is not None else moving
        sun = shade(casting, place, casting.bias, SOFT)
        cv2.copyTo(lit(dark, sunshine, sun), nearer, picture)
        frame[part.slices] = _averaged(picture)


def _averaged(picture: Image) -> Image:
    height, width = picture.shape[:2]
    size = (width // FINER, height // FINER)
    return np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.uint8)
