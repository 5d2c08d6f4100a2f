"""Pictures from elsewhere: measured by their headers, then decoded if they aren't too large.

A file of some kilobytes may hold billions of equal pixels. Its header says how many.
"""

from __future__ import annotations

import struct
from typing import Any

import numpy as np
import numpy.typing as npt

from g3.errors import FormatError

MOST_PIXELS = 1 << 26
"""Largest number of pixels of a picture: as a square, 8192 on a side."""
_AS = "save it as PNG or JPEG"


def decoded(content: bytes, *, where: str) -> npt.NDArray[np.uint8]:
    """Decode a picture: PNG, JPEG, WebP or BMP.

    Parameters
    ----------
    content
        The file's bytes.
    where
        Its name in errors.

    Returns
    -------
    array of shape (height, width, 3)
        Blue, green and red, turned as the file's orientation states.

    Raises
    ------
    FormatError
        If it is damaged, of another kind, or larger than `MOST_PIXELS`.
    """
    import cv2  # noqa: PLC0415 - large, and not always installed

    check_pixels(*size_of(content, where=where), where=where)
    try:
        picture = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR)
    except cv2.error:
        picture = None
    if picture is None:
        raise FormatError("the picture can't be read", where=where, fix=_AS)
    return picture.astype(np.uint8, copy=False)


def are_distances(content: bytes) -> bool:
    """Return True for the kinds of pictures that :func:`decoded_distances` reads."""
    is_png = content.startswith(b"\x89PNG")
    return content[24:25] == b"\x10" if is_png else content.startswith((b"II*\0", b"MM\0*"))


def decoded_distances(content: bytes, *, where: str) -> npt.NDArray[Any]:
    """Decode a depth map: TIFF, or PNG with 16 bits.

    Parameters
    ----------
    content
        The file's bytes.
    where
        Its name in errors.

    Returns
    -------
    array of shape (height, width)
        The numbers as they are stored: float32, uint16 or uint8.

    Raises
    ------
    FormatError
        If it is damaged, of another kind, or larger than `MOST_PIXELS`.
    """
    import cv2  # noqa: PLC0415 - large, and not always installed

    fix = "save it as TIFF of float32 or uint16, or as PNG of uint16"
    try:
        size = next(read(content) for head, read in _DEPTHS.items() if content.startswith(head))
    except (struct.error, ValueError, StopIteration) as error:
        what = "this is no depth map of a kind that is read"
        raise FormatError(what, where=where, fix=fix) from error
    check_pixels(*size, where=where)
    try:
        numbers = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error:
        numbers = None
    if numbers is None or numbers.ndim != 2 or numbers.shape != (size[1], size[0]):
        raise FormatError("the depth map can't be read", where=where, fix=fix)
    return numbers


def check_pixels(width: int, height: int, *, where: str) -> None:
    """Refuse a picture without pixels or with more than `MOST_PIXELS`; FormatError."""
    if width <= 0 or height <= 0 or width * height > MOST_PIXELS:
        raise FormatError(
            f"the picture has {width} by {height} pixels, and from 1 to {MOST_PIXELS} are read",
            where=where,
            fix="make it smaller",
        )


def size_of(content: bytes, *, where: str) -> tuple[int, int]:
    """Return the width and height in a picture's header, in pixels; nothing is decoded.

    Raises
    ------
    FormatError
        If the header is damaged, or of another kind than :func:`decoded` reads.
    """
    try:
        for starts, read in _HEADERS.items():
            if content.startswith(starts):
                return read(content)
    except (struct.error, ValueError) as error:
        what = "the picture's header is damaged or cut off"
        raise FormatError(what, where=where, fix=_AS) from error
    raise FormatError("this is no picture of a kind that is read", where=where, fix=_AS)


def _png(content: bytes) -> tuple[int, int]:
    kind, width, height = struct.unpack_from(">4sII", content, 12)
    if kind != b"IHDR":
        raise ValueError
    return width, height


def _jpeg(content: bytes) -> tuple[int, int]:
    """Read the first frame header; segments before it are passed over."""
    at = 2
    while True:
        mark, kind, length = struct.unpack_from(">BBH", content, at)
        if mark != 0xFF:
            raise ValueError
        if kind == 0xFF:  # a filler
            at += 1
        elif 0xC0 <= kind <= 0xCF and kind not in (0xC4, 0xC8, 0xCC):
            height, width = struct.unpack_from(">HH", content, at + 5)
            return width, height
        else:
            at += 2 if kind == 0x01 or 0xD0 <= kind <= 0xD7 else 2 + length


def _webp(content: bytes) -> tuple[int, int]:
    kind = content[8:16]
    if kind == b"WEBPVP8X":
        low_width, high_width, low_height, high_height = struct.unpack_from("<HBHB", content, 24)
        return (high_width << 16 | low_width) + 1, (high_height << 16 | low_height) + 1
    if kind == b"WEBPVP8L":
        (bits,) = struct.unpack_from("<I", content, 21)
        return (bits & 0x3FFF) + 1, (bits >> 14 & 0x3FFF) + 1
    if kind == b"WEBPVP8 ":
        width, height = struct.unpack_from("<HH", content, 26)
        return width & 0x3FFF, height & 0x3FFF
    raise ValueError


def _bmp(content: bytes) -> tuple[int, int]:
    (length,) = struct.unpack_from("<I", content, 14)
    width, height = struct.unpack_from("<HH" if length == 12 else "<ii", content, 18)
    return abs(width), abs(height)


def _grey_png(content: bytes) -> tuple[int, int]:
    """Read width and height of a PNG; a ValueError if it has colours or transparency."""
    if content[25:26] != b"\0":
        raise ValueError
    return _png(content)


def _tiff(content: bytes) -> tuple[int, int]:
    """Read width and height, tags 256 and 257, of the first picture.

    A ValueError if a pixel has several numbers (tag 277), or more than 32 bits (258): decoded, a
    few kilobytes would take gigabytes.
    """
    order = "<" if content.startswith(b"II") else ">"
    (at,) = struct.unpack_from(f"{order}I", content, 4)
    (count,) = struct.unpack_from(f"{order}H", content, at)
    sizes = {}
    for number in range(count):
        tag, kind = struct.unpack_from(f"{order}HH", content, at + 2 + 12 * number)
        if tag in (256, 257, 258, 277):
            if kind not in (3, 4) or tag in sizes:
                raise ValueError
            value = f"{order}{'H' if kind == 3 else 'I'}"
            (sizes[tag],) = struct.unpack_from(value, content, at + 10 + 12 * number)
    if not {256, 257} <= sizes.keys() or sizes.get(277, 1) != 1 or sizes.get(258, 1) > 32:
        raise ValueError
    return sizes[256], sizes[257]


_DEPTHS = {b"\x89PNG\r\n\x1a\n": _grey_png, b"II*\0": _tiff, b"MM\0*": _tiff}
_HEADERS = {
    b"\x89PNG\r\n\x1a\n": _png,
    b"\xff\xd8": _jpeg,
    b"RIFF": _webp,
    b"BM": _bmp,
}
