"""Frames of a fixed camera without shadows: what moves is put before one picture of the rest."""

from __future__ import annotations

import cv2
import numpy as np

from corpus_tools.video.drawing.camera import Camera
from corpus_tools.video.drawing.canvas import BACKDROP, MOVING, STILL, Canvas, Image
from corpus_tools.video.drawing.drawn_moments import same_state
from corpus_tools.video.drawing.moving_parts import moving_parts
from corpus_tools.world.state.recording import Recording

DOWN = np.array([0.0, 0.0, -1.0])


class Pasted:
    """Frames of a recording, seen by a fixed camera.

    Parameters
    ----------
    canvas
        With the recording's world and its moving objects.
    recording
        Sampled at the video's frames.
    camera
        The camera.
    size
        Width and height of a frame.
    """

    def __init__(
        self, canvas: Canvas, recording: Recording, camera: Camera, size: tuple[int, int]
    ) -> None:
        self._canvas, self._recording, self._camera, self._size = canvas, recording, camera, size
        self._geoms = canvas.geoms_of(MOVING)
        canvas.show(recording, 0)
        canvas.draw(camera, size, groups=(BACKDROP, STILL))
        self._background, self._depth = canvas.pixels(), canvas.depth()
        self._last: tuple[int, Image] | None = None

    def frame(self, k: int) -> Image:
        """The k-th frame, shape (height, width, 3), rows from the top down."""
        if self._last is not None and same_state(self._recording, self._last[0], k):
            return self._last[1]
        canvas = self._canvas
        canvas.show(self._recording, k)
        frame = self._background.copy()
        parts = moving_parts(
            canvas, self._geoms, self._camera, self._size, light=DOWN, ground_m=0.0
        )
        for part, _ in parts:
            here = part.slices
            canvas.draw(self._camera, self._size, groups=(MOVING,), part=part, sky=False)
            behind = np.ascontiguousarray(self._depth[here])
            nearer = cv2.compare(canvas.depth(), behind, cv2.CMP_LT)
            picture = np.ascontiguousarray(frame[here])
            cv2.copyTo(canvas.pixels(), nearer, picture)
            frame[here] = picture
        picture = np.ascontiguousarray(frame[::-1])
        self._last = k, picture
        return picture
