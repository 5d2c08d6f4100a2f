"""Parts of video files as videos of their own, cut when somebody first watches them.

Robots' datasets have many episodes one after the other in a file. A part has a folder with a
manifest, which names the file and the part, and no video. :func:`ensure` makes that: the frames
from the part's beginning up to its end, and no others. So no video is stored twice but those that
people watch, and the cut ones can be deleted at any time.
"""

from __future__ import annotations

import hashlib
import secrets
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Any

import msgspec

from annotation_app.items.scenes import MANIFEST
from g3.errors import FormatError

if TYPE_CHECKING:
    import av
    from av.container import InputContainer

CLIP = "clip.mp4"
"""What a cut video is called, in the folder with its manifest."""
PLAYED = ("h264", "vp8", "vp9", "av1")
"""What browsers play, as FFmpeg calls it."""
FASTSTART = {"movflags": "+faststart"}
"""The index comes first in the file, so that players start before they have all of it."""
ENCODER, OPTIONS = "libx264", {"preset": "veryfast", "crf": "21"}


class Part(msgspec.Struct, frozen=True):
    """A part of a video file, in seconds from the file's first frame."""

    file: str
    start_s: float
    end_s: float


class _Manifest(msgspec.Struct, frozen=True):
    sha256: str
    part: Part


@dataclass(frozen=True, slots=True)
class Look:
    """What a video, or a part of it, looks like."""

    duration_s: float
    """How long it is."""
    fps: float
    """Frames per second."""
    codec: str
    """How it is encoded, as FFmpeg calls that."""
    picture: bytes
    """Its first frame as PNG."""


def look_at(file: Path, start_s: float = 0.0, end_s: float | None = None) -> Look:
    """Look at a video, or a part; a FormatError if it can't be read or PyAV isn't installed."""
    with _opened(file) as container:
        stream = container.streams.video[0]
        rate = float(stream.average_rate or stream.guessed_rate or 0)
        frame = next(_frames(container, start_s), None)
        if frame is None or rate <= 0:
            raise _unreadable(file, "it has no frames there")
        whole = container.duration / 1e6 if container.duration else stream.frames / rate
        duration_s = (whole if end_s is None else min(end_s, whole)) - start_s
        codec = stream.codec_context.codec.canonical_name
        return Look(max(duration_s, 1 / rate), round(rate, 3), codec, _png(frame))


def is_clip(path: Path) -> bool:
    """Whether a file is a part of another one, cut or not yet."""
    return _manifest(path) is not None


def clip_digest(path: Path) -> str | None:
    """What identifies a clip, which is known before it is cut; None for other files."""
    manifest = _manifest(path)
    return None if manifest is None else manifest.sha256


def digest_of_part(sha256: str, start_s: float, end_s: float) -> str:
    """What identifies a part of a file, of which the SHA-256 is given."""
    return hashlib.sha256(f"{sha256} {start_s!r} {end_s!r}".encode()).hexdigest()


def ensure(path: Path) -> None:
    """Cut a clip if it isn't there; a FormatError if its video can't be read.

    Several servers may do that at once: each writes a file of its own, the last one stays.
    """
    manifest = None if path.is_file() else _manifest(path)
    if manifest is None:
        return
    part, file = manifest.part, Path(manifest.part.file)
    new = path.with_name(f".{path.stem}-{secrets.token_hex(4)}{path.suffix}")
    try:
        # A part can be copied if it can be played by itself, as episodes of datasets can.
        if not _copied(file, new, part.start_s, part.end_s):
            _encode(file, new, part.start_s, part.end_s)
        new.replace(path)
    finally:
        new.unlink(missing_ok=True)


def _manifest(path: Path) -> _Manifest | None:
    """What tells how to cut a clip; None for other files."""
    if path.name != CLIP:
        return None
    try:
        return msgspec.json.decode(path.with_name(MANIFEST).read_bytes(), type=_Manifest)
    except (OSError, msgspec.DecodeError):
        return None


def _copied(file: Path, target: Path, start_s: float, end_s: float) -> bool:
    """Copy a part without decoding it, if it begins with a key frame and one follows it."""
    import av  # noqa: PLC0415 - large, and not always installed

    with _opened(file) as container, av.open(str(target), "w", options=FASTSTART) as out:
        source = container.streams.video[0]
        scale = float(source.time_base or 1)
        slack = 0.5 / float(source.average_rate or source.guessed_rate or 25)
        container.seek(int((start_s + slack) / scale), stream=source)
        stream = out.add_stream_from_template(source, opaque=True)
        first = None
        for packet in container.demux(source):
            if packet.pts is None or packet.dts is None:
                break  # the end of the file
            time = packet.pts * scale
            if first is None:
                if not packet.is_keyframe or abs(time - start_s) > slack:
                    return False
                first = packet.pts
            if time >= end_s - slack:
                if packet.is_keyframe:
                    break
                return False
            packet.pts, packet.dts, packet.stream = packet.pts - first, packet.dts - first, stream
            out.mux(packet)
        return first is not None


def _encode(file: Path, target: Path, start_s: float, end_s: float) -> None:
    """Encode the frames of a part anew."""
    import av  # noqa: PLC0415 - large, and not always installed

    with _opened(file) as container, av.open(str(target), "w", options=FASTSTART) as out:
        source = container.streams.video[0]
        rate = source.average_rate or source.guessed_rate or Fraction(25)
        stream = out.add_stream(ENCODER, rate=rate)
        stream.width, stream.height = source.width // 2 * 2, source.height // 2 * 2
        stream.pix_fmt, stream.options = "yuv420p", OPTIONS
        # Up to half a frame before the end, as times are rounded.
        last = end_s - 0.5 / float(rate)
        for number, frame in enumerate(_frames(container, start_s)):
            if float(frame.time or 0) >= last and number:
                break
            picture = frame.reformat(stream.width, stream.height, "yuv420p")
            picture.pts, picture.time_base = number, 1 / Fraction(rate)
            out.mux(stream.encode(picture))
        out.mux(stream.encode(None))


def _frames(container: InputContainer, start_s: float) -> Iterator[av.VideoFrame]:
    """The frames of a video from a time on."""
    import av  # noqa: PLC0415 - large, and not always installed

    stream = container.streams.video[0]
    stream.thread_type = "AUTO"
    rate = float(stream.average_rate or stream.guessed_rate or 25)
    try:
        if start_s > 0:
            container.seek(int(start_s / float(stream.time_base or 1)), stream=stream)
        for frame in container.decode(stream):
            if float(frame.time or 0) > start_s - 0.5 / rate:
                yield frame
    except av.FFmpegError as error:
        raise _unreadable(Path(container.name), _why(error)) from error


def _opened(file: Path) -> Any:
    try:
        import av  # noqa: PLC0415 - large, and not always installed
    except ImportError as error:
        raise FormatError(
            "videos are read with PyAV, which isn't installed",
            fix="pip install 'corpus-tools-g3[render]'",
        ) from error
    try:
        container = av.open(str(file))
    except (av.FFmpegError, OSError) as error:
        raise _unreadable(file, _why(error)) from error
    if not container.streams.video:
        container.close()
        raise _unreadable(file, "it has no pictures")
    return container


def _png(frame: av.VideoFrame) -> bytes:
    import cv2  # noqa: PLC0415 - as above

    is_written, picture = cv2.imencode(".png", frame.to_ndarray(format="bgr24"))
    assert is_written  # noqa: S101 - any frame can be
    content: bytes = picture.tobytes()
    return content


def to_mp4(file: Path, new: str = "") -> str:
    """The command that makes a video which all browsers play; ``new`` is its name."""
    made = f"{new or f'{file.stem}-new'}.mp4"
    return f"ffmpeg -i {quote(file.name)} -c:v libx264 -pix_fmt yuv420p {quote(made)}"


def _why(error: Exception) -> str:
    """What FFmpeg says, without its number and the file's name."""
    return str(getattr(error, "strerror", None) or error)


def _unreadable(file: Path, why: str) -> FormatError:
    return FormatError(
        f"the video can't be read: {why}", where=str(file), fix=f"make it again: {to_mp4(file)}"
    )
