"""The outermost structure of MP4 and WebM files: their kind, and whether their end is there.

FFmpeg reads a file that was cut off as a shorter one. The sizes that its boxes or elements state
distinguish the two.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

MP4, WEBM, MATROSKA = "mp4", "webm", "matroska"

_BOXES = (
    *(b"ftyp", b"styp", b"moov", b"mdat", b"moof", b"mfra", b"sidx", b"free", b"skip", b"wide"),
    *(b"uuid", b"meta", b"pnot", b"udta", b"emsg", b"prft"),
)
_HEADER, _SEGMENT, _CLUSTER = 0x1A45DFA3, 0x18538067, 0x1F43B675
_KIND = 0x4282
"""The element of the header that names the kind of file."""


@dataclass(frozen=True, slots=True)
class Structure:
    """The outermost structure of a file."""

    kind: str
    """One of ``mp4``, ``webm`` and ``matroska``; empty for other files."""
    problem: str
    """The reason why it isn't whole; empty if there is none."""


def read_structure(file: Path) -> Structure:
    """Read the outermost structure of a file, but none of its pictures."""
    size = file.stat().st_size
    with file.open("rb") as content:
        head = content.read(8)
        if int.from_bytes(head[:4], "big") == _HEADER:
            return _matroska(content, size)
        return _mp4(content, size) if head[4:] in _BOXES else Structure("", "")


def _mp4(content: BinaryIO, size: int) -> Structure:
    at = 0
    while at + 8 <= size:
        content.seek(at)
        head = content.read(16)
        length = int.from_bytes(head[:4], "big")
        if length == 1:
            length = int.from_bytes(head[8:], "big")
        if head[4:8] not in _BOXES or length < 8:
            break  # the last box may have no length, and anything may follow it
        if at + length > size:
            return Structure(MP4, _cut_off(at + length, size))
        at += length
    return Structure(MP4, "")


def _matroska(content: BinaryIO, size: int) -> Structure:
    """Walk through the elements. Those without a length, as recorders write them, are entered."""
    kind, at, end, is_sized = MATROSKA, 0, size, False
    while at < end:
        content.seek(at)
        name, length = _number(content, has_marker=True), _number(content, has_marker=False)
        inside = content.tell()
        if name is None or length is None:
            if inside >= size:
                return Structure(kind, _cut_off(inside + 1, size))
            # Behind a segment of unknown length anything may follow.
            return Structure(kind, f"it is damaged at byte {at}" if is_sized else "")
        if name == _SEGMENT:
            is_sized = length >= 0
            end = inside + length if is_sized else size
            if end > size:
                return Structure(kind, _cut_off(end, size))
        if name == _HEADER:
            kind = _kind(content, inside + max(length, 0))
        is_entered = name == _SEGMENT or length < 0
        at = inside if is_entered else inside + length
        if at > size:
            return Structure(kind, _cut_off(at, size))
    return Structure(kind, "")


def _kind(content: BinaryIO, end: int) -> str:
    """Return the kind that a header names, which ends at a byte."""
    while content.tell() < end:
        name, length = _number(content, has_marker=True), _number(content, has_marker=False)
        if name is None or length is None or not 0 <= length <= end:
            break
        value = content.read(length)
        if name == _KIND:
            return WEBM if value.rstrip(b"\0") == b"webm" else MATROSKA
    return MATROSKA


def _number(content: BinaryIO, *, has_marker: bool) -> int | None:
    """Read a number of variable length; None if there is none, -1 for an unknown length."""
    first = content.read(1)
    if not first or not first[0]:
        return None
    more = 8 - first[0].bit_length()
    rest = content.read(more)
    if len(rest) < more:
        return None
    value = int.from_bytes(first + rest, "big")
    if has_marker:
        return value if more < 4 else None
    value &= (1 << 7 * (more + 1)) - 1
    return -1 if value == (1 << 7 * (more + 1)) - 1 else value


def _cut_off(needed: int, size: int) -> str:
    return f"it is cut off: it has {size} bytes, of {needed} or more"
