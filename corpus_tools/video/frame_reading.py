"""Opening video files with PyAV, and their frames as pictures that people see."""

from __future__ import annotations

from fractions import Fraction
from importlib.util import find_spec
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from corpus_tools.video.picture_file import MOST_PIXELS
from g3.errors import FormatError

if TYPE_CHECKING:
    import av

CONTAINERS = "mov,matroska"
"""The formats that are opened, as FFmpeg calls them. Playlists, which name other files, aren't."""
WIDEST = 16_384
"""The greatest width and height of a picture as displayed."""


def to_mp4(file: Path, new: str = "") -> str:
    """Return the command that makes a video which all browsers play.

    Parameters
    ----------
    new
        Name of the new file, without its ending; the old one with ``-new`` if it is empty.
    """
    made = f"{new or f'{file.stem}-new'}.mp4"
    return f"ffmpeg -i {quote(file.name)} -c:v libx264 -pix_fmt yuv420p {quote(made)}"


def unreadable(file: Path, why: str) -> FormatError:
    """Return the error that a video can't be read, with its reason."""
    return FormatError(
        f"the video can't be read: {why}", where=str(file), fix=f"make it again: {to_mp4(file)}"
    )


def reason(error: Exception) -> str:
    """Return FFmpeg's text of an error, without its number and the file's name."""
    return str(getattr(error, "strerror", None) or error)


def has_decoder() -> bool:
    """Return True if videos can be read here: PyAV comes with an extra."""
    return find_spec("av") is not None


def open_video(file: Path) -> tuple[Any, Any]:
    """Open a video file with PyAV.

    Returns
    -------
    tuple
        The container, which the caller closes, and the video stream that browsers play: the first
        one that is no cover picture.

    Raises
    ------
    FormatError
        If the file can't be read or has no such stream, or PyAV isn't installed.
    """
    try:
        import av  # noqa: PLC0415 - large, and not always installed
    except ImportError as error:
        raise FormatError(
            "videos are read with PyAV, which isn't installed",
            fix="pip install 'corpus-tools-g3[render]'",
        ) from error
    try:
        container = av.open(str(file), options={"format_whitelist": CONTAINERS})
    except (av.FFmpegError, OSError, ValueError) as error:
        raise unreadable(file, reason(error)) from error
    cover = av.stream.Disposition.attached_pic
    for stream in container.streams.video:
        if not stream.disposition & cover and stream.codec_context is not None:
            stream.thread_type = "AUTO"
            stream.codec_context.options = {"max_pixels": str(MOST_PIXELS)}
            return container, stream
    container.close()
    raise unreadable(file, "it has no video, or one of a kind that FFmpeg can't decode")


def orientation(frame: av.VideoFrame) -> tuple[int, bool]:
    """Return how a stored frame is turned for display.

    Returns
    -------
    tuple
        Degrees clockwise (0, 90, 180 or 270), and whether it is mirrored, left to right, first.
    """
    side_data: Any = frame.side_data
    for item in side_data:
        if item.type.name == "DISPLAYMATRIX":
            a, b, _, c, d = np.frombuffer(bytes(item), np.dtype("<i4"), 5).astype(np.float64)
            is_mirrored = bool(a * d - b * c < 0)
            angle = np.rad2deg(np.arctan2(-b, -a) if is_mirrored else np.arctan2(b, a))
            return int(np.round(angle / 90)) * 90 % 360, is_mirrored
    return 0, False


def square(width: int, height: int, aspect: Fraction) -> tuple[int, int]:
    """Return a picture's size with square pixels. Nothing shrinks, as in browsers."""
    if aspect >= 1:
        return min(round(width * aspect), WIDEST), height
    return width, min(round(height / aspect), WIDEST)


def picture(frame: av.VideoFrame, aspect: Fraction) -> NDArray[np.uint8]:
    """Return a frame as people see it: upright, with square pixels.

    Parameters
    ----------
    aspect
        Width of a stored pixel divided by its height.

    Returns
    -------
    NDArray[np.uint8]
        Shape (height, width, 3): red, green and blue, rows from the top down.
    """
    width, height = square(frame.width, frame.height, aspect)
    rotation, is_mirrored = orientation(frame)
    stored: Any = frame.reformat(width, height, "rgb24").to_ndarray()
    shown = stored[:, ::-1] if is_mirrored else stored
    return np.ascontiguousarray(np.rot90(shown, -rotation // 90))


def upright(frame: av.VideoFrame) -> av.VideoFrame:
    """Return a frame turned as people see it, for an encoder.

    Returns
    -------
    av.VideoFrame
        In 8-bit YUV 4:2:0 in the video range, with even sizes. Its pixels have the same aspect, or
        the inverse one if it was turned by 90 degrees.
    """
    import av  # noqa: PLC0415 - large, and not always installed

    rotation, is_mirrored = orientation(frame)
    width, height = (max(pixels // 2 * 2, 2) for pixels in (frame.width, frame.height))
    # The colours stay as they are coded, so that players take them for the same.
    flat = frame.reformat(
        width, height, "yuv420p", dst_colorspace=frame.colorspace, dst_color_range="MPEG"
    )
    if not rotation and not is_mirrored:
        return flat
    samples: Any = flat.to_ndarray().ravel()
    planes, at = [], 0
    for shrink in (1, 2, 2):
        rows, columns = height // shrink, width // shrink
        plane = samples[at : at + rows * columns].reshape(rows, columns)
        at += plane.size
        planes.append(np.rot90(plane[:, ::-1] if is_mirrored else plane, -rotation // 90).ravel())
    across = height if rotation % 180 == 90 else width
    turned: Any = np.concatenate(planes).reshape(-1, across)
    made = av.VideoFrame.from_ndarray(turned, "yuv420p")
    made.colorspace, made.color_range = flat.colorspace, flat.color_range
    return made
