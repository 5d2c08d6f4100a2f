"""The properties of video files, measured by decoding each file once.

A container's header may lack a length, give a mean frame rate, or list frames that the file doesn't
hold. :func:`probe` therefore decodes all frames. It keeps the result in the cache folder by the
file's SHA-256 digest, so that no file is decoded twice, under any name.

All times are on one clock: seconds since the first frame. On the container's own clock the first
frame may be later than 0 (:attr:`VideoInfo.first_time_s`).

FFmpeg reads a file that was cut off as a shorter one. The sizes that the outermost boxes or
elements of MP4 and WebM files state distinguish the two.
"""

from __future__ import annotations

import hashlib
import stat
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import msgspec
import numpy as np
from numpy.typing import NDArray

from corpus_tools.video.frame_reading import open_video, orientation, reason, square, unreadable
from g3.errors import FormatError
from g3.short_repr import short_repr
from g3.storage.atomic_file import write_bytes
from g3.storage.cache_folder import cache_folder

if TYPE_CHECKING:
    import av


OnShare = Callable[[float], None]
"""Called with the share of the file that is decoded, from 0 to 1."""

MP4, WEBM, MATROSKA = "mp4", "webm", "matroska"
_AV1 = {"yuv420p", "yuvj420p", "yuv420p10le", "gray", "gray10le"}
PLAYED = {
    MP4: {"h264": {"yuv420p", "yuvj420p"}, "vp9": {"yuv420p", "yuvj420p"}, "av1": _AV1},
    WEBM: {
        "vp8": {"yuv420p", "yuva420p"},
        "vp9": {"yuv420p", "yuvj420p", "yuva420p", "yuv420p10le"},
        "av1": _AV1,
    },
}
"""The pixel formats that all common browsers play, by container and codec."""

_VERSION = 2
"""Raised whenever results are to be made again."""
_FALLBACK_S = 0.04
"""The duration of a single frame whose container gives none."""
_LEAST_LOSS_S = 0.5
"""Least shortfall of the frames against the header's length that shows missing frames."""
_SETTLED_NS = 2_000_000_000
"""The age of a file's last change from which its digest is kept by its path. A second change may
have the same time as the first."""
_BLOCK = 1 << 20


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class VideoInfo:
    """The properties of a video file."""

    sha256: str
    """Digest of the file's content, in hexadecimal."""
    frame_times: NDArray[np.float64]
    """Presentation times of all frames, shape (n,) with n ≥ 1, seconds, ascending from 0."""
    first_time_s: float
    """Time of the first frame on the container's own clock, seconds; it may be negative."""
    duration_s: float
    """Length from the first frame to the end of the last one, seconds."""
    width: int
    """Pixels across as displayed: after rotation, with square pixels."""
    height: int
    """Pixels from top to bottom as displayed: after rotation, with square pixels."""
    rotation: int
    """Degrees by which stored frames are turned clockwise for display: 0, 90, 180 or 270."""
    is_mirrored: bool
    """True if stored frames are mirrored, left to right, before they are turned."""
    pixel_aspect: Fraction
    """Width of a stored pixel divided by its height."""
    container: str
    """Kind of file: ``mp4``, ``webm`` or ``matroska``; QuickTime's files count as ``mp4``."""
    codec: str
    """FFmpeg's canonical name of the codec, such as ``h264``."""
    pixel_format: str
    """FFmpeg's name of the pixel format, such as ``yuv420p``."""
    fps: float
    """Mean rate of the frames, per second."""
    has_audio: bool
    """True if there is sound."""
    is_playable: bool
    """True if all common browsers play this codec and pixel format in this container."""
    stated_s: float
    """Length that the container's header gives, seconds; 0 if it gives none."""
    problem: str
    """The reason why the file isn't whole: cut off, or damaged; empty if it is whole."""


class _Kept(msgspec.Struct, frozen=True, array_like=True):
    """A result as it is kept."""

    info: dict[str, Any]
    frame_times: bytes


def probe(file: Path, *, progress: OnShare | None = None) -> VideoInfo:
    """Return the properties of a video file, which is decoded unless it was before.

    Parameters
    ----------
    progress
        Called while the file is decoded, never if its properties are in the cache.

    Returns
    -------
    VideoInfo
        Also for a file that is cut off or damaged but has a frame: look at its ``problem``.

    Raises
    ------
    FormatError
        If the file can't be read, is no MP4, QuickTime, WebM or Matroska file, has no frame that
        can be decoded, or changes meanwhile; or if PyAV isn't installed.
    """
    before = _stamp(file)
    sha256 = file_digest(file)
    info = _kept(sha256)
    if info is None:
        with _TURN:
            info = _kept(sha256) or _decoded(file, sha256, progress)
            if _stamp(file) != before:
                what = "the file changed while it was read"
                raise FormatError(what, where=str(file), fix="wait until it is whole")
            _keep(_result_file(sha256), _packed(info))
    with _NOTING:
        _RECENT[sha256] = info
        if len(_RECENT) > _MOST_RECENT:
            del _RECENT[next(iter(_RECENT))]
    return info


def file_digest(file: Path) -> str:
    """Return the SHA-256 digest of a file's content, in hexadecimal.

    That of a large file is kept by the file's path, size, inode and times of change, so that it
    isn't read again.

    Raises
    ------
    FormatError
        If it is no regular file, or can't be read.
    """
    stamp = _stamp(file)
    if stamp.size <= _BLOCK:  # read as quickly as what is kept
        return _content_digest(file)
    key = hashlib.sha256(msgspec.json.encode(stamp)).hexdigest()
    index = cache_folder() / "videos" / "files" / key
    with suppress(OSError, ValueError):
        digest, _, seal = index.read_text("ascii").partition(" ")
        if seal == _seal(key, digest):
            return digest
    digest = _content_digest(file)
    if _stamp(file) == stamp and time.time_ns() - max(stamp.changed_ns) > _SETTLED_NS:
        _keep(index, f"{digest} {_seal(key, digest)}".encode())
    return digest


def _content_digest(file: Path) -> str:
    hasher = hashlib.sha256()
    try:
        with file.open("rb") as content:
            while block := content.read(_BLOCK):
                hasher.update(block)
    except OSError as error:
        raise _no_file(file, error) from error
    return hasher.hexdigest()


class _Stamp(msgspec.Struct, frozen=True):
    """The marks of a file that differ when it was changed."""

    path: str
    size: int
    changed_ns: tuple[int, int]
    place: tuple[int, int]


def _stamp(file: Path) -> _Stamp:
    try:
        path = file.resolve()
        status = path.stat()
    except (OSError, RuntimeError) as error:
        raise _no_file(file, error) from error
    if not stat.S_ISREG(status.st_mode):
        raise FormatError("it is no regular file", where=str(file), fix="give a video file")
    changed_ns = (status.st_mtime_ns, status.st_ctime_ns)
    return _Stamp(str(path), status.st_size, changed_ns, (status.st_dev, status.st_ino))


def _no_file(file: Path, error: Exception) -> FormatError:
    return FormatError(
        f"the file can't be read: {reason(error)}", where=str(file), fix="correct its path or mode"
    )


def _seal(key: str, digest: str) -> str:
    return hashlib.sha256(f"{key} {digest}".encode()).hexdigest()[:16]


_RECENT: dict[str, VideoInfo] = {}
"""Results by digest, of use where the cache folder can't be written."""
_MOST_RECENT = 64
_NOTING = threading.Lock()
_TURN = threading.Lock()
"""Two requests for the same file decode it once."""


def _result_file(sha256: str) -> Path:
    return cache_folder() / "videos" / f"{sha256}-{_VERSION}"


def _packed(info: VideoInfo) -> bytes:
    values = {name: getattr(info, name) for name in VideoInfo.__slots__}
    times = values.pop("frame_times").astype("<f8").tobytes()
    values["pixel_aspect"] = [info.pixel_aspect.numerator, info.pixel_aspect.denominator]
    content = msgspec.msgpack.encode(_Kept(values, times))
    return hashlib.sha256(content).digest() + content


def _kept(sha256: str) -> VideoInfo | None:
    """Return the result for a digest; None if none is kept, or a damaged one."""
    if (recent := _RECENT.get(sha256)) is not None:
        return recent
    try:
        content = _result_file(sha256).read_bytes()
    except OSError:
        return None
    digest, content = content[:32], content[32:]
    if hashlib.sha256(content).digest() != digest:
        return None
    kept = msgspec.msgpack.decode(content, type=_Kept)
    aspect = Fraction(*kept.info.pop("pixel_aspect"))
    times = np.frombuffer(kept.frame_times, "<f8")
    return VideoInfo(**kept.info, frame_times=times, pixel_aspect=aspect)


def _keep(file: Path, content: bytes) -> None:
    """Write into the cache, if that is possible."""
    with suppress(OSError, FormatError):
        file.parent.mkdir(parents=True, exist_ok=True)
        write_bytes(file, content)


@dataclass(slots=True)
class _Pass:
    """The outcome of decoding a stream."""

    first: av.VideoFrame | None = None
    marks: list[tuple[int, int]] = field(default_factory=list)
    """Time and duration of each frame in the stream's unit; a duration may be 0."""
    damaged: int = 0
    """Number of damaged packets or frames."""
    damaged_at: int | None = None
    """The time of the first of them."""
    end: str = ""
    """The reason why the stream ended early."""

    def note_damage(self, at: int | None) -> None:
        self.damaged += 1
        if self.damaged_at is None:
            self.damaged_at = at


def _decoded(file: Path, sha256: str, progress: OnShare | None) -> VideoInfo:
    """Return the properties of a file, by decoding it."""
    structure = read_structure(file)
    if not structure.kind:
        raise unreadable(file, "it is no MP4, QuickTime, WebM or Matroska file")
    container, stream = open_video(file)
    with container:
        outcome = _decode(container, stream, file.stat().st_size, progress)
        first = outcome.first
        if first is None:
            raise unreadable(file, outcome.end or structure.problem or "it has no frames")
        unit = Fraction(stream.time_base or 1)
        times, duration_s = _clock(outcome, unit, stream.average_rate)
        rotation, is_mirrored = orientation(first)
        aspect = Fraction(stream.sample_aspect_ratio or 1)
        size = square(first.width, first.height, aspect)
        codec = str(stream.codec_context.codec.canonical_name)
        pixel_format = str(first.format.name)
        return VideoInfo(
            sha256=sha256,
            frame_times=times,
            first_time_s=float(min(outcome.marks)[0] * unit),
            duration_s=duration_s,
            width=size[rotation % 180 == 90],
            height=size[rotation % 180 != 90],
            rotation=rotation,
            is_mirrored=is_mirrored,
            pixel_aspect=aspect,
            container=structure.kind,
            codec=codec,
            pixel_format=pixel_format,
            fps=_mean_rate(times, duration_s),
            has_audio=bool(container.streams.audio),
            is_playable=pixel_format in PLAYED.get(structure.kind, {}).get(codec, set()),
            stated_s=float(container.duration or 0) / 1e6,
            problem=_problem(outcome, structure, stream, duration_s),
        )


def _decode(container: Any, stream: Any, size: int, progress: OnShare | None) -> _Pass:
    """Decode a stream to its end, past damaged parts."""
    import av  # noqa: PLC0415 - large, and not always installed

    outcome = _Pass()
    packets = container.demux(stream)
    while True:
        try:
            packet = next(packets, None)
        except (av.FFmpegError, OSError) as error:
            outcome.end = reason(error)
            break
        if packet is None:
            break
        if progress is not None and packet.pos is not None and packet.pos > 0 < size:
            progress(min(packet.pos / size, 1.0))
        if packet.is_corrupt:
            outcome.note_damage(packet.pts)
        try:
            frames = packet.decode()
        except av.FFmpegError:
            outcome.note_damage(packet.pts)
            continue
        for frame in frames:
            _note_frame(outcome, frame)
    if progress is not None:
        progress(1.0)
    return outcome


def _note_frame(outcome: _Pass, frame: av.VideoFrame) -> None:
    at = frame.pts
    if at is None:
        at = frame.dts if frame.dts is not None else sum(outcome.marks[-1] if outcome.marks else ())
    if outcome.first is None:
        outcome.first = frame
    if frame.is_corrupt:
        outcome.note_damage(at)
    outcome.marks.append((at, frame.duration or 0))


def _clock(
    outcome: _Pass, unit: Fraction, rate: Fraction | None
) -> tuple[NDArray[np.float64], float]:
    """Return the frames' times from the first one on, and their length, in seconds."""
    marks = np.array(sorted(outcome.marks), np.int64)
    times = (marks[:, 0] - marks[0, 0]) * float(unit)
    last_s = float(marks[-1, 1] * unit)
    if last_s <= 0:
        steps = np.diff(times)
        usual = float(np.median(steps)) if len(steps) else 0.0
        last_s = usual or (float(1 / rate) if rate else _FALLBACK_S)
    return times, round(float(times[-1]) + last_s, 6)


def _mean_rate(times: NDArray[np.float64], duration_s: float) -> float:
    span_s = float(times[-1])
    return round((len(times) - 1) / span_s if span_s > 0 else 1 / duration_s, 3)


def _problem(outcome: _Pass, structure: Structure, stream: Any, duration_s: float) -> str:
    """Return the reason why a file isn't whole; empty if it is."""
    if structure.problem:
        return structure.problem
    unit = float(stream.time_base or 1)
    if structure.kind == MP4:  # whose header has been made of the frames
        stated = (stream.duration or 0) * unit
        step = duration_s / len(outcome.marks)
        if stated > duration_s + max(_LEAST_LOSS_S, 2 * step):
            return f"it is cut off: it has {duration_s:.2f} s of pictures, of {stated:.2f} s"
    if outcome.end:
        return f"it can't be read to its end: {outcome.end}"
    if outcome.damaged:
        what = f"it is damaged: {outcome.damaged} of its frames can't be decoded"
        if outcome.damaged_at is None:
            return what
        at_s = max(outcome.damaged_at - min(outcome.marks)[0], 0) * unit
        return f"{what}, the first at {at_s:.2f} s"
    return ""


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
