"""Frames of a camera that moves: all is drawn, with and without the sun, and shadows between.

The picture with the sun is twice as wide and high as frames, which smooths edges; the one
without is only needed in the shadows, and is as large as frames.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence

import cv2
import numpy as np

from corpus_tools.video.camera import Camera
from corpus_tools.video.canvas import MOVING, Canvas, Image
from corpus_tools.video.composite import FINER
from corpus_tools.video.shadows import Shadows, ahead_of, lit, places, shade
from corpus_tools.world.recording import Recording

TEXEL_M, MOVING_TEXEL_M = 0.015, 0.006
"""Edges of texels in shadow maps: what moves is near the camera."""
SOFT = 3
"""Width of shadows' edges, pixels of frames."""


class Shaded:
    """Frames of a recording, each with its own camera.

    Parameters
    ----------
    canvas
        With the recording's world and its moving objects, and a sun.
    recording
        Sampled at the video's frames.
    cameras
        One for each frame.
    size
        Width and height of a frame; the canvas is larger by :data:`FINER`.
    """

    def __init__(
        self,
        canvas: Canvas,
        recording: Recording,
        cameras: Sequence[Camera],
        size: tuple[int, int],
    ) -> None:
        self._canvas, self._recording, self._cameras, self._size = canvas, recording, cameras, size
        canvas.show(recording, 0)
        self._shadows = Shadows(canvas, TEXEL_M)
        geoms = canvas.geoms_of(MOVING)
        of = canvas.object_of_geom[geoms]
        self._geoms = [geoms[of == item] for item in np.unique(of)]

    def frame(self, k: int) -> Image:
        """The k-th frame, shape (height, width, 3), rows from the top down."""
        canvas, camera = self._canvas, self._cameras[k]
        canvas.show(self._recording, k)
        canvas.draw(camera, (self._size[0] * FINER, self._size[1] * FINER))
        fine = canvas.pixels()
        bright = np.asarray(cv2.resize(fine, self._size, interpolation=cv2.INTER_AREA), np.uint8)
        canvas.draw(camera, self._size, sun=False)
        dark, depth = canvas.pixels(), canvas.depth()
        sunshine = np.asarray(cv2.subtract(bright, dark), np.uint8)
        rays, eye = places(camera, self._size, self._shadows.axes)
        place = rays * ahead_of(depth, canvas.clip()) + eye
        casting = [
            self._shadows.moving_alone(canvas.corners(geoms), MOVING_TEXEL_M)
            for geoms in self._geoms
        ]
        if self._shadows.still is not None:
            casting.append(self._shadows.still)
        suns = [shade(map_, place, map_.bias, SOFT) for map_ in casting]
        sun = functools.reduce(np.minimum, suns)
        return np.ascontiguousarray(lit(dark, sunshine, sun)[::-1])
