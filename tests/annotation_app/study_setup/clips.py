"""Tiny real videos, as a robot's camera may have written them."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import av
import numpy as np

WIDTH, HEIGHT, FPS, FRAMES = 64, 48, 10, 10
CODECS = {".mp4": "libx264", ".webm": "libvpx"}


def clip(path: Path, shade: int = 100, codec: str = "") -> Path:
    """A second of a grey picture."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec or CODECS[path.suffix], rate=FPS)
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuv420p"
        stream.time_base = Fraction(1, FPS)
        for number in range(FRAMES):
            image = np.full((HEIGHT, WIDTH, 3), shade + number, np.uint8)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(image, format="rgb24")))
        container.mux(stream.encode(None))
    return path
