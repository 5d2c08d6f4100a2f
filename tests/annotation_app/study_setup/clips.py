"""Tiny real videos, as a robot's camera may have written them."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
from numpy.typing import NDArray

WIDTH, HEIGHT, FPS, FRAMES = 64, 48, 10, 10
CODECS = {".mp4": "libx264", ".webm": "libvpx"}


def clip(path: Path, shade: int = 100, codec: str = "") -> Path:
    """A second of a grey picture."""
    shades = (shade + number for number in range(FRAMES))
    return film(path, [np.full((HEIGHT, WIDTH, 3), one, np.uint8) for one in shades], codec)


def film(path: Path, pictures: Sequence[NDArray[np.uint8]], codec: str = "") -> Path:
    """A video of pictures."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec or CODECS[path.suffix], rate=FPS)
        stream.height, stream.width, _ = pictures[0].shape
        stream.pix_fmt, stream.time_base = "yuv420p", Fraction(1, FPS)
        for image in pictures:
            container.mux(stream.encode(av.VideoFrame.from_ndarray(image, format="rgb24")))
        container.mux(stream.encode(None))
    return path
