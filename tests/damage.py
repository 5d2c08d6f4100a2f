"""Ways in which files are damaged: by disks, by cables, by programs that were killed, by people."""

from __future__ import annotations

import io
import os
import random
import struct
import zipfile
from collections.abc import Iterator

TIMES = int(os.environ.get("CT_DAMAGES", "1"))
"""How many times as many damaged files to try as usual, to look for what is rare."""


def damaged(content: bytes, count: int, *, seed: int) -> Iterator[tuple[str, bytes]]:
    """Different bytes than `content`, with what was done to it."""
    rng = random.Random(seed)
    ways = [_flipped, _cut, _zeroed, _doubled, _removed, _exchanged, _overwritten]
    if content.startswith(b"PK"):
        ways += [_entry_edited, _rezipped, _header_edited]
    made = 0
    while made < count * TIMES:
        way = ways[made % len(ways)]
        result = way(content, rng)
        made += 1
        if result != content:
            yield f"{way.__name__[1:]}, {made}", result


def _block(content: bytes, rng: random.Random) -> tuple[int, int]:
    start = rng.randrange(len(content))
    return start, min(len(content), start + rng.choice([1, 2, 16, 64, 512]))


def _flipped(content: bytes, rng: random.Random) -> bytes:
    at, bit = rng.randrange(len(content)), rng.randrange(8)
    return content[:at] + bytes([content[at] ^ 1 << bit]) + content[at + 1 :]


def _cut(content: bytes, rng: random.Random) -> bytes:
    return content[: rng.randrange(len(content))]


def _zeroed(content: bytes, rng: random.Random) -> bytes:
    start, end = _block(content, rng)
    return content[:start] + bytes(end - start) + content[end:]


def _doubled(content: bytes, rng: random.Random) -> bytes:
    start, end = _block(content, rng)
    return content[:end] + content[start:]


def _removed(content: bytes, rng: random.Random) -> bytes:
    start, end = _block(content, rng)
    return content[:start] + content[end:]


def _exchanged(content: bytes, rng: random.Random) -> bytes:
    size = rng.choice([1, 4, 32])
    a, b = sorted(rng.randrange(max(1, len(content) - size)) for _ in range(2))
    if b - a < size:
        return content
    one, other = content[a : a + size], content[b : b + size]
    return content[:a] + other + content[a + size : b] + one + content[b + size :]


def _overwritten(content: bytes, rng: random.Random) -> bytes:
    at = rng.randrange(len(content))
    return content[:at] + bytes([rng.randrange(256)]) + content[at + 1 :]


def _entry_edited(content: bytes, rng: random.Random) -> bytes:
    """Flags, method, checksum, sizes or offset of a member, in the archive's directory."""
    starts = [i for i in range(len(content)) if content.startswith(b"PK\x01\x02", i)]
    at = rng.choice(starts) + rng.choice([8, 10, 16, 20, 24, 28, 42])
    value = struct.pack("<H", rng.choice([0, 1, 8, 12, 14, 99, 0xFFFF, rng.randrange(1 << 16)]))
    return content[:at] + value + content[at + 2 :]


def _rezipped(content: bytes, rng: random.Random) -> bytes:
    """Members that exchanged their names, were lost, or are there twice; all checksums right."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        members = [(name, archive.read(name)) for name in archive.namelist()]
    i, j = rng.randrange(len(members)), rng.randrange(len(members))
    match rng.randrange(3):
        case 0:
            names = [name for name, _ in members]
            names[i], names[j] = names[j], names[i]
            members = list(zip(names, (data for _, data in members), strict=True))
        case 1:
            del members[i]
        case _:
            members[i] = (members[i][0], members[j][1])
    return _zipped(members)


def _header_edited(content: bytes, rng: random.Random) -> bytes:
    """A member whose header says something else; its checksum is right."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        members = [(name, archive.read(name)) for name in archive.namelist()]
    i = rng.randrange(len(members))
    name, data = members[i]
    length = 10 + int.from_bytes(data[8:10], "little")
    header = data[:length]
    match rng.randrange(5):
        case 0:
            header = header.replace(b"'shape': (", b"'shape': (999999999999, ").replace(
                b" " * 14, b"", 1
            )
        case 1:
            header = header.replace(b"'<", b"'>")
        case 2:
            header = header.replace(b"'<f8'", b"'|O8'").replace(b"'<i8'", b"'<f8'")
        case 3:
            header = header.replace(b"(", b"((", 1).replace(b"  ", b" ", 1)
        case _:
            header = _flipped(header, rng)
    members[i] = (name, header + data[length:])
    return _zipped(members)


def _zipped(members: list[tuple[str, bytes]]) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in members:
            archive.writestr(zipfile.ZipInfo(name), data, zipfile.ZIP_DEFLATED)
    return out.getvalue()
