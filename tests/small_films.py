"""Small videos as cameras, recorders and editors of other people write them."""

from __future__ import annotations

import io
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
from av.video.frame import PictureType
from numpy.typing import NDArray

RATE = 10
"""Frames a second where no times are given."""
SIZE = (64, 48)
UNIT = Fraction(1, 1000)
FINE = {"g": "1000", "crf": "8", "forced-idr": "1", "deadline": "realtime", "cpu-used": "8"}
"""Options of encoders: shades stay apart, and there are no key frames but the wanted ones."""
CODECS = {".mp4": "libx264", ".webm": "libvpx"}
SOUNDS = {".mp4": "aac", ".webm": "libopus"}


class Pipe:
    """A file that can only be written to, as a recorder's is: no header is completed later."""

    def __init__(self) -> None:
        self.content = io.BytesIO()

    def write(self, content: bytes) -> int:
        return self.content.write(content)


def film(
    path: Path,
    times: Sequence[float] | int = RATE,
    *,
    codec: str = "",
    size: tuple[int, int] = SIZE,
    pixels: str = "yuv420p",
    aspect: Fraction = Fraction(1),
    turned: int = 0,
    is_mirrored: bool = False,
    sound_s: float = 0.0,
    last_s: float = 1 / RATE,
    keys: int = 1000,
    options: dict[str, str] | None = None,
    muxed: dict[str, str] | None = None,
    is_piped: bool = False,
    kind: str = "",
) -> Path:
    """Write a video whose frames can be told apart (:func:`numbers`), marked at the top left.

    Parameters
    ----------
    times
        Of the frames, in seconds; or how many there are, at `RATE`.
    turned
        Degrees clockwise by which players turn it; then it is mirrored if it `is_mirrored`.
    sound_s
        Length of the sound; 0 for none.
    last_s
        Duration of the last frame.
    keys
        Every how many frames there is a key frame.
    is_piped
        If the file is written to a pipe, so that its header states no length.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    if isinstance(times, int):
        times = [number / RATE for number in range(times)]
    pipe = Pipe()
    target: Any = pipe if is_piped else str(path)
    kind = kind or path.suffix[1:]
    muxed = {"movflags": "+faststart"} if muxed is None and kind == "mp4" else muxed or {}
    with av.open(target, "w", format=kind, options=muxed) as out:
        stream = out.add_stream(codec or CODECS[path.suffix], rate=RATE)
        stream.width, stream.height, stream.pix_fmt = *size, pixels
        context = stream.codec_context
        stream.time_base = context.time_base = UNIT
        context.sample_aspect_ratio = aspect
        stream.bit_rate, stream.options = 2_000_000, {**FINE, **(options or {})}
        if turned or is_mirrored:
            stream.set_display_rotation(-turned, hflip=is_mirrored)  # counter-clockwise
        sound = out.add_stream(SOUNDS[path.suffix], rate=48_000) if sound_s else None
        ends = [*times[1:], times[-1] + last_s]
        durations = {
            round(a / UNIT): round((b - a) / UNIT) for a, b in zip(times, ends, strict=True)
        }
        packets = []
        for number, at in enumerate(times):
            frame = av.VideoFrame.from_ndarray(picture(number, size), format="rgb24")
            frame = frame.reformat(format=pixels)
            frame.pts, frame.time_base = round(at / UNIT), UNIT
            if number % keys == 0:
                frame.pict_type = PictureType.I
            packets += stream.encode(frame)
        for packet in [*packets, *stream.encode(None)]:
            packet.duration = durations[packet.pts]
            out.mux(packet)
        if sound is not None:
            write_tone(out, sound, sound_s)
    if is_piped:
        path.write_bytes(pipe.content.getvalue())
    return path


def write_tone(out: Any, stream: Any, seconds: float) -> None:
    samples = 960 if stream.codec_context.name == "libopus" else 1024
    for number in range(round(seconds * 48_000 / samples)):
        t = (number * samples + np.arange(samples)) / 48_000
        wave = (0.3 * np.sin(2 * np.pi * 440 * t)).astype(np.float32)
        frame = av.AudioFrame.from_ndarray(np.tile(wave, (2, 1)), format="fltp", layout="stereo")
        frame.pts, frame.sample_rate, frame.time_base = (
            number * samples,
            48_000,
            Fraction(1, 48_000),
        )
        if stream.codec_context.name == "libopus":
            frame = av.AudioResampler("flt", "stereo", 48_000).resample(frame)[0]
        out.mux(stream.encode(frame))
    out.mux(stream.encode(None))


def picture(number: int, size: tuple[int, int]) -> NDArray[np.uint8]:
    """A frame: grey as its number, with a white corner at the top left and noise at the bottom."""
    width, height = size
    shown = np.full((height, width, 3), 20 + 4 * number, np.uint8)
    noise = np.random.default_rng(number).integers(0, 100, (height // 4, width, 1))
    shown[height - height // 4 :] = noise.astype(np.uint8)
    shown[: height // 3, : width // 3] = 255
    return shown


def numbers(path: Path) -> list[int]:
    """The numbers of a video's frames, by their grey."""
    with av.open(str(path)) as container:
        pictures = [f.to_ndarray(format="rgb24") for f in container.decode(video=0)]
    height, width, _ = pictures[0].shape
    middle = slice(height // 2 - 4, height // 2 + 4), slice(width // 2 - 4, width // 2 + 4)
    return [round((float(p[middle].mean()) - 20) / 4) for p in pictures]


def corner(shown: NDArray[np.uint8]) -> str:
    """Where the white corner of a picture is, such as ``top left``."""
    rows, columns = np.nonzero(shown.mean(axis=2) > 150)
    return " ".join(
        (
            "top" if rows.mean() < shown.shape[0] / 2 else "bottom",
            "left" if columns.mean() < shown.shape[1] / 2 else "right",
        )
    )


def cut_off(path: Path, share: float) -> Path:
    """Take away a file's end."""
    content = path.read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    return path
