"""Encoding frames as videos that browsers play."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from pathlib import Path
from types import MappingProxyType
from typing import Literal, TypeAlias

import av
from av.video.reformatter import ColorRange, Colorspace, VideoReformatter

from corpus_tools.video.drawing.canvas import Image
from g3.errors import CorpusError

Quality: TypeAlias = Literal["draft", "standard", "high"]

ENCODER = "libx264"

OPTIONS = MappingProxyType(
    {
        "draft": {"preset": "ultrafast", "crf": "27"},
        "standard": {"preset": "veryfast", "crf": "21"},
        "high": {"preset": "medium", "crf": "17"},
    }
)
"""Options of the encoder, by quality."""
_KEY_FRAME_S = 2
"""Players can jump this finely without decoding much."""
_REC_709_FROM = 720
"""Players take pictures of this height for Rec. 709, smaller ones for Rec. 601."""


def encode(
    frames: Iterable[Image],
    path: Path,
    *,
    size: tuple[int, int],
    fps: int | Fraction,
    quality: Quality,
) -> None:
    """Write frames as H.264 in MP4, at a constant rate.

    The same frames give the same bytes. The index comes first in the file, so that players
    start before they have all of it.

    Parameters
    ----------
    frames
        Of shape (height, width, 3), red, green and blue, rows from the top down.
    size
        Width and height, both even.
    """
    options = {"movflags": "+faststart", "fflags": "+bitexact"}
    with av.open(str(path), "w", format="mp4", options=options) as container:
        try:
            stream = container.add_stream(ENCODER, rate=fps)
        except (ValueError, av.error.FFmpegError) as error:
            raise CorpusError(
                f"this build of PyAV has no {ENCODER}", fix="install the wheel: pip install av"
            ) from error
        stream.width, stream.height = size
        stream.pix_fmt = "yuv420p"
        stream.time_base = 1 / Fraction(fps)
        key_frames = {"g": str(round(_KEY_FRAME_S * fps))}
        stream.options = {**OPTIONS[quality], "threads": "1", **key_frames}
        stream.codec_context.thread_count = 1
        space = Colorspace.ITU709 if size[1] >= _REC_709_FROM else Colorspace.ITU601
        # One for all frames: each new one starts threads and makes tables.
        reformatter = VideoReformatter()
        for k, picture in enumerate(frames):
            frame = reformatter.reformat(
                av.VideoFrame.from_ndarray(picture, format="rgb24"),
                format="yuv420p",
                dst_colorspace=space,
                dst_color_range=ColorRange.MPEG,
            )
            frame.pts = k
            frame.time_base = 1 / Fraction(fps)
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
