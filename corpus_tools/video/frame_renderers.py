"""The frames of a recording, drawn as its quality and camera ask."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

from corpus_tools.video.drawing.camera import CAMERAS, Camera
from corpus_tools.video.drawing.canvas import Canvas, Image, open_canvas
from corpus_tools.video.drawing.composite import FINER, Composite, averaged
from corpus_tools.video.drawing.drawn_moments import moving_objects
from corpus_tools.video.drawing.shadows import LARGEST_MAP
from corpus_tools.video.encode import Quality
from corpus_tools.world.physics.build import World
from corpus_tools.world.state.recording import Recording

SHADOW_SIZE = MappingProxyType({"draft": 1, "standard": 2048, "high": 4096})
"""Of MuJoCo's shadow map, for cameras that move; a draft has no shadows."""


@dataclass(frozen=True, slots=True, eq=False)
class Frames:
    """What a video needs of a recording.

    Parameters
    ----------
    cameras
        One for each frame, or a single one.
    frame
        The k-th frame, shape (height, width, 3), rows from the top down.
    objects
        Index of the object that each pixel of the first frame shows, -1 for none, (h, w).
    """

    cameras: list[Camera]
    frame: Callable[[int], Image]
    objects: npt.NDArray[np.int64]


@contextmanager
def open_frames(
    world: World, recording: Recording, camera: str, size: tuple[int, int], quality: Quality
) -> Iterator[Frames]:
    """Prepare to draw a recording's frames.

    Parameters
    ----------
    world
        Of the recording's context.
    recording
        Sampled at the video's frames.
    camera
        One of :data:`~corpus_tools.video.drawing.camera.CAMERAS`.
    size
        Width and height of a frame.
    """
    cameras = CAMERAS[camera](recording, size)
    shadows = quality != "draft"
    fine = (size[0] * FINER, size[1] * FINER)
    with open_canvas(
        world,
        (max(fine[0], LARGEST_MAP), max(fine[1], LARGEST_MAP)) if shadows else size,
        shadow_size=SHADOW_SIZE[quality],
        moving=moving_objects(recording),
    ) as canvas:
        canvas.show(recording, 0)
        objects = canvas.objects(cameras[0], size)[::-1]
        if shadows and len(cameras) == 1:
            frame = Composite(canvas, recording, cameras[0], size).frame
        else:

            def frame(k: int) -> Image:
                canvas.show(recording, k)
                return _whole(canvas, cameras[min(k, len(cameras) - 1)], size, shadows=shadows)

        yield Frames(cameras, frame, objects)


def _whole(canvas: Canvas, camera: Camera, size: tuple[int, int], *, shadows: bool) -> Image:
    """All that a camera sees, drawn at once: with shadows finely, without them fast."""
    finer = FINER if shadows else 1
    canvas.draw(camera, (size[0] * finer, size[1] * finer), shadows=shadows)
    return np.ascontiguousarray(averaged(canvas.pixels(), size)[::-1])
