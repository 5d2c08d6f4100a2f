"""Frames of a fixed camera: still things are drawn once, moving things are put before them.

Everything is drawn once without the sun and once in nothing but its light, which shadows take away.
Of the still background, both pictures, their depth and the places that the pixels show are kept. So
the shadows of moving things fall rightly on it. Pictures are twice as wide and high as frames until
the end, which smooths edges.
"""

from __future__ import annotations

import cv2
import numpy as np

from corpus_tools.video.drawing.camera import Camera
from corpus_tools.video.drawing.canvas import BACKDROP, MOVING, STILL, Canvas, Image, Rectangle
from corpus_tools.video.drawing.drawn_moments import same_state
from corpus_tools.video.drawing.shadows import (
    Shadows,
    ahead_of,
    lit,
    merged,
    moving_parts,
    places,
    shade,
)
from corpus_tools.world.physics.build import ground_of
from corpus_tools.world.state.recording import Recording
from g3.groundings import FloatArray

DOWN = np.array([0.0, 0.0, -1.0])


class Pasted:
    """Frames of a recording, seen by a fixed camera.

    The canvas has the recording's world and its moving objects, and the recording is sampled at the
    video's frames. `size` is the width and height of a frame.
    """

    def __init__(
        self, canvas: Canvas, recording: Recording, camera: Camera, size: tuple[int, int]
    ) -> None:
        self._canvas, self._recording, self._camera, self._size = canvas, recording, camera, size
        self._geoms = canvas.geoms_of(MOVING)
        canvas.show(recording, 0)
        self._draw_background()
        self._last: tuple[int, Image] | None = None

    def frame(self, k: int) -> Image:
        """Draw the k-th frame, shape (height, width, 3), rows from the top down."""
        if self._last is not None and same_state(self._recording, self._last[0], k):
            return self._last[1]
        self._canvas.show(self._recording, k)
        frame = self._background.copy()
        parts = moving_parts(
            self._canvas,
            self._geoms,
            self._camera,
            self._size,
            light=self._light,
            ground_m=ground_of(self._recording.start),
            lamp_m=self._lamp_m,
        )
        for part, corners in parts:
            self._draw_part(frame, part, corners)
        picture = np.ascontiguousarray(frame[::-1])
        self._last = k, picture
        return picture

    def _draw_background(self) -> None:
        """Draw the still things."""
        self._canvas.draw(self._camera, self._size, groups=(BACKDROP, STILL))
        self._background, self._depth = self._canvas.pixels(), self._canvas.depth()
        self._light, self._lamp_m = DOWN, 0.0

    def _draw_part(self, frame: Image, part: Rectangle, corners: FloatArray) -> None:
        """Draw the moving things into a part of a frame."""
        canvas, here = self._canvas, part.slices
        canvas.draw(self._camera, self._size, groups=(MOVING,), part=part, sky=False)
        behind = np.ascontiguousarray(self._depth[here])
        nearer = cv2.compare(canvas.depth(), behind, cv2.CMP_LT)
        picture = np.ascontiguousarray(frame[here])
        cv2.copyTo(canvas.pixels(), nearer, picture)
        frame[here] = picture


FINER = 2
"""Ratio of pictures' width and height to those of frames."""
SOFT = 5
"""Width of shadows' edges, pixels of the finer pictures."""
TOUCHING_M = 0.02
"""Least distance of a thing from its shade, in metres; nearer, and they touch."""
TEXELS_PER_PIXEL = 1.4
FINEST_M, COARSEST_M = 0.008, 0.05
"""Limits of texels' edges in shadow maps."""


class Composite(Pasted):
    """Frames of a recording with the sun's shadows, seen by a fixed camera.

    The canvas has a sun, and is larger than frames by :data:`FINER`.
    """

    def _draw_background(self) -> None:
        canvas, still = self._canvas, (BACKDROP, STILL)
        self._fine = (self._size[0] * FINER, self._size[1] * FINER)
        canvas.draw(self._camera, self._fine, groups=still, sun=False)
        self._dark = canvas.pixels()
        canvas.draw(self._camera, self._fine, groups=still, sky=False, other_light=False)
        self._sunshine = canvas.pixels()
        self._depth = canvas.depth()
        self._clip = canvas.clip()
        ahead = ahead_of(self._depth, self._clip)
        self._shadows = Shadows(canvas, self._texel(float(np.median(ahead))))
        self._light, self._lamp_m = self._shadows.axes[2], self._shadows.lamp_m
        self._rays, self._eye = places(self._camera, self._fine, self._shadows.axes)
        self._places = self._rays * ahead + self._eye
        if (casters := self._shadows.still) is not None:
            sun = shade(casters, self._places, casters.bias, SOFT, self._lamp_m)
            self._sunshine = lit(np.zeros_like(self._dark), self._sunshine, sun)
        everywhere = np.full(self._depth.shape, 255, np.uint8)
        self._background = _averaged(lit(self._dark, self._sunshine, everywhere))

    def _texel(self, ahead_m: float) -> float:
        """Return the edge of a shadow map's texels that suits pixels so far ahead."""
        pixel = ahead_m * 2 * np.tan(self._camera.fovy / 2) / self._size[1]
        return float(np.clip(pixel / TEXELS_PER_PIXEL, FINEST_M, COARSEST_M))

    def _draw_part(self, frame: Image, part: Rectangle, corners: FloatArray) -> None:
        canvas, shadows, fine = self._canvas, self._shadows, part.scaled(FINER)
        here = fine.slices
        moving = shadows.moving(corners)
        sun = shade(moving, self._places[:, here[0], here[1]], TOUCHING_M, SOFT, self._lamp_m)
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
        sun = shade(casting, place, casting.bias, SOFT, self._lamp_m)
        cv2.copyTo(lit(dark, sunshine, sun), nearer, picture)
        frame[part.slices] = _averaged(picture)


def _averaged(picture: Image) -> Image:
    height, width = picture.shape[:2]
    size = (width // FINER, height // FINER)
    return np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.uint8)
