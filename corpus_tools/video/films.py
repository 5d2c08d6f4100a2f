"""A recording as one video file: sampled, drawn and encoded."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from corpus_tools.video.drawing.camera import CAMERAS, Camera
from corpus_tools.video.drawing.canvas import Canvas, Image, sun_of
from corpus_tools.video.drawing.composite import FINER, Composite, Pasted
from corpus_tools.video.drawing.drawn_moments import moving_objects, sampled
from corpus_tools.video.drawing.shaded import Shaded
from corpus_tools.video.drawing.shadows import LARGEST_MAP
from corpus_tools.video.encode import Quality, encode
from corpus_tools.video.manifest import Settings
from corpus_tools.world.physics.build import World, build_world
from corpus_tools.world.state.recording import Recording
from g3.short_repr import short_repr
from g3.storage.system_errors import about


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class Film:
    """A video of a recording."""

    recording: Recording
    """The recording, sampled at the video's frames."""
    cameras: list[Camera]
    """One for each frame, or a single one."""
    objects: npt.NDArray[np.int64]
    """Index of the object that each pixel of the first frame shows, -1 for none, (h, w)."""
    poster: int
    """Index of the frame after half of all motion: carrying, in most recordings that carry."""


OnFrame: TypeAlias = Callable[[Film, int, Image], None]
"""Called with a film, the index of a frame that is done, and that frame."""


def film(
    recording: Recording,
    path: Path,
    settings: Settings | None = None,
    *,
    site: str = "yard",
    on_frame: OnFrame | None = None,
) -> Film:
    """Draw a recording into an MP4 file, which gets its name when it is whole.

    Parameters
    ----------
    settings
        How it is drawn; the default of each if left out.
    site
        Surroundings: one of :data:`~corpus_tools.world.looks.site_looks.SITES`.
    on_frame
        Called after each frame.
    """
    how = settings or Settings()
    shown = sampled(recording, how.fps, speed=how.speed, skip_idle=how.skip_idle)
    world = build_world(recording.start, site=site, names=how.names)
    new = path.with_name(f".{path.name}.new.mp4")
    try:
        with about(path, instead_of=new):
            with open_frames(world, shown, how.camera, how.size, how.quality) as frames:
                made = Film(shown, frames.cameras, frames.objects, _middle_of_motion(shown))
                pictures = _pictures(made, frames.frame, on_frame)
                encode(pictures, new, size=how.size, fps=how.fps, quality=how.quality)
            new.replace(path)
    finally:
        new.unlink(missing_ok=True)
    return made


def _pictures(
    made: Film, frame: Callable[[int], Image], on_frame: OnFrame | None
) -> Iterator[Image]:
    for k in range(len(made.recording.t_ns)):
        picture = frame(k)
        yield picture
        if on_frame is not None:
            on_frame(made, k, picture)


def _middle_of_motion(recording: Recording) -> int:
    way = np.linalg.norm(np.diff(recording.position, axis=0), axis=2).sum(axis=1)
    done = np.concatenate(([0.0], np.cumsum(way)))
    return int(np.searchsorted(done, done[-1] / 2))


SAMPLES = 4
SHADOW_SIZE = 4096
"""Size of MuJoCo's shadow map, for the highest quality."""


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class Frames:
    """Source of the frames of a video of a recording."""

    cameras: list[Camera]
    """One for each frame, or a single one."""
    frame: Callable[[int], Image]
    """The k-th frame, shape (height, width, 3), rows from the top down."""
    objects: npt.NDArray[np.int64]
    """Index of the object that each pixel of the first frame shows, -1 for none, (h, w)."""


@contextmanager
def open_frames(
    world: World, recording: Recording, camera: str, size: tuple[int, int], quality: Quality
) -> Iterator[Frames]:
    """Prepare to draw the frames of a recording that is sampled at the video's frames.

    `camera` is one of :data:`~corpus_tools.video.drawing.camera.CAMERAS`.
    """
    cameras = CAMERAS[camera](recording, size)
    shaded = quality == "standard" and sun_of(world.model) is not None
    best = quality == "high"
    canvas = Canvas(
        world,
        canvas_size(size) if shaded else size,
        samples=SAMPLES if best else 0,
        shadow_size=SHADOW_SIZE if best else 1,
        moving=moving_objects(recording),
    )
    with closing(canvas):
        canvas.show(recording, 0)
        objects = canvas.objects(cameras[0], size)[::-1]
        if quality == "draft" and len(cameras) == 1:
            frame = Pasted(canvas, recording, cameras[0], size).frame
        elif not shaded:
            frame = partial(_whole, canvas, recording, cameras, size=size, shadows=best)
        elif len(cameras) == 1:
            frame = Composite(canvas, recording, cameras[0], size).frame
        else:
            frame = Shaded(canvas, recording, cameras, size).frame
        yield Frames(cameras, frame, objects)


def _whole(
    canvas: Canvas,
    recording: Recording,
    cameras: Sequence[Camera],
    k: int,
    *,
    size: tuple[int, int],
    shadows: bool,
) -> Image:
    """Draw a frame wholly by MuJoCo, with its own shadows or none."""
    canvas.show(recording, k)
    canvas.draw(cameras[min(k, len(cameras) - 1)], size, shadows=shadows)
    return np.ascontiguousarray(canvas.pixels()[::-1])


def canvas_size(size: tuple[int, int]) -> tuple[int, int]:
    """Return the size of a canvas for the finer pictures of frames, and for shadow maps."""
    return max(size[0] * FINER, LARGEST_MAP), max(size[1] * FINER, LARGEST_MAP)
