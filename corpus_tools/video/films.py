"""A recording as one video file: sampled, drawn and encoded."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from corpus_tools.video.drawing.camera import Camera
from corpus_tools.video.drawing.canvas import Image
from corpus_tools.video.drawing.drawn_moments import sampled
from corpus_tools.video.encode import encode
from corpus_tools.video.frame_renderers import open_frames
from corpus_tools.video.manifest import Settings
from corpus_tools.world.physics.build import build_world
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
