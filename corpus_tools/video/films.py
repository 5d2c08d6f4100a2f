"""A recording as one video file, without all that stands beside a rendered item's video."""

from __future__ import annotations

from pathlib import Path

from corpus_tools.video.drawing.drawn_moments import sampled
from corpus_tools.video.encode import encode
from corpus_tools.video.frame_renderers import open_frames
from corpus_tools.video.manifest import Settings
from corpus_tools.world.physics.build import build_world
from corpus_tools.world.state.recording import Recording
from g3.storage.system_errors import about


def film(
    recording: Recording, path: Path, how: Settings | None = None, *, site: str = "yard"
) -> None:
    """Draw a recording into an MP4 file, as :class:`Settings` has it by default.

    `site` is what is around: one of :data:`~corpus_tools.world.looks.site_looks.SITES`.
    """
    how = how or Settings()
    shown = sampled(recording, how.fps, speed=how.speed, skip_idle=how.skip_idle)
    world = build_world(recording.start, site=site, names=how.names)
    new = path.with_name(f".{path.name}.new.mp4")
    try:
        with about(path, instead_of=new):
            with open_frames(world, shown, how.camera, how.size, how.quality) as frames:
                pictures = map(frames.frame, range(len(shown.t_ns)))
                encode(pictures, new, size=how.size, fps=how.fps, quality=how.quality)
            new.replace(path)
    finally:
        new.unlink(missing_ok=True)
