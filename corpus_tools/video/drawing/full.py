"""Frames drawn whole, one by one, for cameras that move or the highest quality."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from corpus_tools.video.drawing.camera import Camera
from corpus_tools.video.drawing.canvas import Canvas, Image
from corpus_tools.world.state.recording import Recording


class Full:
    """Frames of a recording, with MuJoCo's own shadows or none.

    Parameters
    ----------
    canvas
        With the recording's world.
    recording
        Sampled at the video's frames.
    cameras
        One for each frame, or a single one.
    size
        Width and height of a frame.
    shadows
        Whether to draw shadows.
    """

    def __init__(
        self,
        canvas: Canvas,
        recording: Recording,
        cameras: Sequence[Camera],
        size: tuple[int, int],
        *,
        shadows: bool,
    ) -> None:
        self._canvas, self._recording, self._cameras = canvas, recording, cameras
        self._size, self._shadows = size, shadows

    def frame(self, k: int) -> Image:
        """The k-th frame, shape (height, width, 3), rows from the top down."""
        canvas = self._canvas
        canvas.show(self._recording, k)
        camera = self._cameras[min(k, len(self._cameras) - 1)]
        canvas.draw(camera, self._size, shadows=self._shadows)
        return np.ascontiguousarray(canvas.pixels()[::-1])
