"""Ways in which files are damaged: by disks, cables, programs that were killed, people, attackers.

Bytes of any file are flipped, cut, doubled, exchanged. In texts, values get other types and sizes,
keys and lines are doubled or swapped. Archives are damaged inside, too, with right checksums.
"""

from __future__ import annotations

import gzip
import io
import os
import random
import re
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
    elif content.startswith(b"\x1f\x8b"):
        ways += [_regzipped] * len(_OF_TEXT)
    elif _is_text(content):
        ways += _OF_TEXT
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


# Of texts


def _is_text(content: bytes) -> bool:
    try:
        return "\0" not in content.decode()
    except UnicodeDecodeError:
        return False


_STRING = rb'"(?:[^"\\\n]|\\.)*"'
_VALUE = re.compile(
    rb"-?\b\d+(?:\.\d+)?(?:[eE][-+]?\d+)?\b|" + _STRING + rb"|\b(?:true|false|null)\b"
)
_PAIR = re.compile(rb'("[^"\n]{1,40}"\s*:\s*)("[^"\n]*"|-?[\d.]+|true|false|null),?')
_OTHERS = (
    b"null", b"true", b"-1", b"0", b"1e308", b"-1e308", b"1e999", b"NaN", b"Infinity", b"9" * 30,
    b"9007199254740993", b"-9223372036854775809", b"0.1", b'""', b'"x"', b"[]", b"{}", b"[[]]",
    b"[null]", b'{"": 0}', b'"\\ud800"', b'"\\u0000"', b'"../../x"', b'"/dev/zero"', b"2026-01-01",
    b'"' + b"x" * 100_000 + b'"', b"9" * 5000,
)  # fmt: skip
_BYTES = (
    b"\xff", b"\xc0\x80", b"\xed\xa0\x80", b"\xf8\x88\x80\x80\x80", b"\x00", b"\xef\xbb\xbf",
    b"\xe2\x80\xa8", b"\xc2\x85", b"\x0c", b"\r", b"\x1b[2J", b'"', b"\\",
)  # fmt: skip


def _retyped(content: bytes, rng: random.Random) -> bytes:
    """Another value, of another type or size, in the place of one."""
    values = list(_VALUE.finditer(content))
    if not values:
        return content
    value = rng.choice(values)
    return content[: value.start()] + rng.choice(_OTHERS) + content[value.end() :]


def _nested(content: bytes, rng: random.Random) -> bytes:
    """A value in many brackets."""
    deep = rng.choice([30, 2000, 100_000])
    left, right = rng.choice([(b"[", b"]"), (b'{"a":', b"}")])
    values = list(_VALUE.finditer(content))
    start, end = rng.choice(values).span() if values else (0, len(content))
    return content[:start] + left * deep + content[start:end] + right * deep + content[end:]


def _misspelt(content: bytes, rng: random.Random) -> bytes:
    """Bytes that are no UTF-8, or characters that end lines or texts for some programs."""
    at = rng.randrange(len(content))
    return content[:at] + rng.choice(_BYTES) + content[at:]


def _line_doubled(content: bytes, rng: random.Random) -> bytes:
    lines = content.splitlines(keepends=True)
    at = rng.randrange(len(lines))
    return b"".join((*lines[: at + 1], *lines[at:]))


def _lines_swapped(content: bytes, rng: random.Random) -> bytes:
    lines = content.splitlines(keepends=True)
    a, b = rng.randrange(len(lines)), rng.randrange(len(lines))
    lines[a], lines[b] = lines[b], lines[a]
    return b"".join(lines)


def _line_removed(content: bytes, rng: random.Random) -> bytes:
    lines = content.splitlines(keepends=True)
    del lines[rng.randrange(len(lines))]
    return b"".join(lines)


def _key_doubled(content: bytes, rng: random.Random) -> bytes:
    """A key of an object that is there twice, with another value."""
    pairs = list(_PAIR.finditer(content))
    if not pairs:
        return content
    pair = rng.choice(pairs)
    again = pair[1] + rng.choice(_OTHERS) + b", "
    return content[: pair.start()] + again + content[pair.start() :]


def _key_removed(content: bytes, rng: random.Random) -> bytes:
    pairs = list(_PAIR.finditer(content))
    if not pairs:
        return content
    pair = rng.choice(pairs)
    return content[: pair.start()] + content[pair.end() :]


def _recoded(content: bytes, rng: random.Random) -> bytes:
    """Saved by another program: as UTF-16, with other line ends, or in capitals."""
    return rng.choice(
        [content.decode().encode("utf-16"), content.upper(), content.replace(b"\n", b"\r\n")]
    )


_OF_TEXT = [
    _retyped, _retyped, _retyped, _nested, _misspelt, _line_doubled, _lines_swapped, _line_removed,
    _key_doubled, _key_removed, _recoded,
]  # fmt: skip


def _regzipped(content: bytes, rng: random.Random) -> bytes:
    """The text in an archive damaged, and packed again as it was."""
    plain = gzip.decompress(content)
    edited = rng.choice(_OF_TEXT)(plain, rng)
    return content if edited == plain else gzip.compress(edited, 6, mtime=0)


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
