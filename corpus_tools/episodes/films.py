"""Videos made of an episode's pictures.

Pictures are other people's: only PNG and JPEG are decoded, and only up to a size.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from corpus_tools.video.picture_file import MOST_PIXELS
from g3.errors import FormatError

if TYPE_CHECKING:
    from corpus_tools.video.drawing.canvas import Image

RESTORE = "restore the dataset"
_CODECS = {b"\x89PNG": "png", b"\xff\xd8\xff": "mjpeg"}
"""The decoders of FFmpeg, by the first bytes of a picture."""


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """A frame of an episode."""

    pixels: Image
    """Red, green and blue, shape (height, width, 3)."""
    where: str
    """Its place, for errors."""


def decoded(content: bytes, where: str) -> Picture:
    """Decode a PNG or JPEG."""
    import av  # noqa: PLC0415 - large, and not always installed

    codec = next((name for head, name in _CODECS.items() if content.startswith(head)), None)
    if codec is None:
        raise FormatError("the picture is no PNG or JPEG", where=where, fix=RESTORE)
    context: Any = av.CodecContext.create(codec, "r")
    context.options = {"max_pixels": str(MOST_PIXELS)}
    context.thread_count = 1
    try:
        frames = [*context.decode(av.Packet(content)), *context.decode(None)]
        if not frames or min(frames[0].width, frames[0].height) < 2:
            raise ValueError("it has no pixels")
        pixels: Image = np.ascontiguousarray(frames[0].to_ndarray(format="rgb24"))
    except (av.FFmpegError, ValueError, MemoryError) as error:
        what = f"the picture can't be read: {error}"
        raise FormatError(what, where=where, fix=RESTORE) from error
    return Picture(pixels, where)


def write_film(pictures: Iterable[Picture], target: Path, fps: float, where: str) -> int:
    """Write a video of pictures at a constant rate, and return the number of its frames.

    An odd row or column at the end is left out.

    Parameters
    ----------
    fps
        Frames a second.
    where
        The place of the pictures, for the error that there are none.
    """
    from corpus_tools.video.encode import encode  # noqa: PLC0415 - needs PyAV

    every = iter(pictures)
    first = next(every, None)
    if first is None:
        raise FormatError("there are no pictures", where=where)
    shape = first.pixels.shape
    height, width = shape[0] // 2 * 2, shape[1] // 2 * 2
    count = 0

    def frames() -> Iterator[Image]:
        nonlocal count
        for count, picture in enumerate(chain([first], every), start=1):  # noqa: B007 - returned
            if picture.pixels.shape != shape:
                sizes = (f"{s[1]} by {s[0]} pixels" for s in (picture.pixels.shape, shape))
                what = "the picture has {}, others {}".format(*sizes)
                raise FormatError(what, where=picture.where, fix=RESTORE)
            yield picture.pixels[:height, :width]

    target.parent.mkdir(parents=True, exist_ok=True)
    rate = Fraction(fps).limit_denominator(1001)
    encode(frames(), target, size=(width, height), fps=rate, quality="standard")
    return count
