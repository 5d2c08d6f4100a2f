"""Pictures are measured by their headers; those that are too large are never decoded."""

from __future__ import annotations

import contextlib
import struct
import tracemalloc
import zlib

import cv2
import numpy as np
import pytest

from corpus_tools.video.picture_file import (
    MOST_PIXELS,
    decoded,
    decoded_distances,
    size_of,
)
from g3.errors import FormatError
from tests.damage import damaged


def encoded(suffix: str, width: int = 37, height: int = 23) -> bytes:
    pixels = np.random.default_rng(1).integers(0, 255, (height, width, 3), dtype=np.uint8)
    _, content = cv2.imencode(suffix, pixels)
    return content.tobytes()


def empty_png(width: int, height: int) -> bytes:
    """A PNG of black pixels, which takes a thousandth of their number."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        end = struct.pack(">I", zlib.crc32(kind + data))
        return struct.pack(">I", len(data)) + kind + data + end

    packer = zlib.compressobj(9)
    row = bytes(1 + (width + 7) // 8)
    data = b"".join(packer.compress(row) for _ in range(height)) + packer.flush()
    head = struct.pack(">IIBBBBB", width, height, 1, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", data) + chunk(b"IEND", b"")


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".webp", ".bmp"])
def test_the_header_has_the_size_of_the_decoded_picture(suffix):
    content = encoded(suffix)
    assert size_of(content, where="x") == (37, 23)
    assert decoded(content, where="x").shape == (23, 37, 3)


def test_a_picture_of_40000_by_40000_pixels_is_refused_without_being_decoded():
    content = empty_png(40_000, 40_000)
    assert len(content) < 300_000
    tracemalloc.start()
    with pytest.raises(FormatError, match="40000 by 40000 pixels") as found:
        decoded(content, where="bomb.png")
    assert found.value.where == "bomb.png"
    assert tracemalloc.get_traced_memory()[1] < 1e6
    tracemalloc.stop()


def test_the_largest_picture_is_read():
    side = int(MOST_PIXELS**0.5)
    assert size_of(empty_png(side, side), where="x") == (side, side)
    assert decoded(empty_png(side, 8), where="x").shape == (8, side, 3)
    with pytest.raises(FormatError):
        decoded(empty_png(side, side + 1), where="x")


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".webp", ".bmp"])
def test_damaged_pictures_are_refused_or_small(suffix):
    for _, content in damaged(encoded(suffix), 150, seed=1):
        with contextlib.suppress(FormatError):
            picture = decoded(content, where="x.png")
            assert picture.shape[0] * picture.shape[1] <= MOST_PIXELS


@pytest.mark.parametrize("content", [b"", b"\xff", b"\xff\xd8", b"BM", b"GIF89a", b"\xff\xd8" * 9])
def test_what_is_no_picture_is_refused(content):
    with pytest.raises(FormatError):
        decoded(content, where="x")


def tiff(*tags: tuple[int, int, int]) -> bytes:
    """A TIFF's header and first directory, without pixels."""
    entries = b"".join(struct.pack("<HHII", tag, kind, 1, value) for tag, kind, value in tags)
    return b"II*\0" + struct.pack("<IH", 8, len(tags)) + entries + bytes(4)


SIZE = ((256, 3, 8000), (257, 3, 8000))


@pytest.mark.parametrize(
    "tags",
    [
        ((277, 3, 4),), ((277, 3, 4), (277, 3, 1)), ((277, 1, 4),), ((277, 3, 0),),
        ((258, 3, 64),), ((258, 3, 32), (277, 3, 65535)),
    ],
)  # fmt: skip
def test_distances_of_several_numbers_are_refused_without_being_decoded(tags):
    with pytest.raises(FormatError, match="no depth map of a kind"):
        decoded_distances(tiff(*SIZE, *tags), where="x")


def test_distances_with_colours_are_refused():
    colours = cv2.imencode(".png", np.zeros((4, 4, 3), np.uint16))[1].tobytes()
    with pytest.raises(FormatError, match="no depth map of a kind"):
        decoded_distances(colours, where="x")


@pytest.mark.parametrize("kind", [np.float32, np.uint16])
def test_distances_of_one_number_are_read(kind):
    values = np.arange(12, dtype=kind).reshape(3, 4)
    content = cv2.imencode(".tiff", values)[1].tobytes()
    assert np.array_equal(decoded_distances(content, where="x"), values)
