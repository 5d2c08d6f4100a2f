"""Frames of a fixed camera without shadows: moving things go before one picture of the rest."""

from __future__ import annotations

import cv2
import numpy as np

from corpus_tools.video.drawing.camera import Camera
from corpus_tools.video.drawing.canvas import BACKDROP, MOVING, STILL, Canvas, Image, Rectangle
from corpus_tools.video.drawing.drawn_moments import same_state
from corpus_tools.video.drawing.shadows import moving_parts
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
        self._light = DOWN

    def _draw_part(self, frame: Image, part: Rectangle, corners: FloatArray) -> None:
        """Draw the moving things into a part of a frame."""
        canvas, here = self._canvas, part.slices
        canvas.draw(self._camera, self._size, groups=(MOVING,), part=part, sky=False)
        behind = np.ascontiguousarray(self._depth[here])
        nearer = cv2.compare(canvas.depth(), behind, cv2.CMP_LT)
        picture = np.ascontiguousarray(frame[here])
        cv2.copyTo(canvas.pixels(), nearer, picture)
        frame[here] = picture
