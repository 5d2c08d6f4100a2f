"""Parts of video files as files of their own, cut by the frames' own times.

A part has the frames that people would see between its start and its end, at the same times from
its start on, in the same orientation and proportions, and the same sound. Where frames can't be
copied, because others are needed to decode them, they are encoded.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from operator import itemgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from corpus_tools.video.frame_reading import open_video, picture, reason, upright
from corpus_tools.video.probe import MP4, WEBM, VideoInfo
from g3.errors import FormatError

if TYPE_CHECKING:
    import av

ENCODERS = {
    MP4: ("libx264", {"preset": "veryfast", "crf": "21", "bf": "0"}),
    WEBM: (
        "libvpx-vp9",
        {"deadline": "realtime", "cpu-used": "7", "crf": "24", "b": "0", "lag-in-frames": "0"},
    ),
}
"""Encoder and its options, by container. Without B-frames each frame's time is plain."""
SOUND = {MP4: {"aac", "mp3", "opus", "flac"}, WEBM: {"opus", "vorbis"}}
"""The codecs of sound that browsers play, by container. Other sound is left out."""
MUXED = {MP4: {"movflags": "+faststart"}, WEBM: {}}
"""The index of an MP4 file comes first, so that players start before they have all of it."""
_Timed: TypeAlias = tuple[float, Any]
"""A packet, and its time in a span in seconds."""
_SAME_S = 1e-6
_UNIT = Fraction(1, 90_000)
"""The unit of time of encoded frames, in seconds."""


@dataclass(frozen=True, slots=True)
class Span:
    """A run of a video's frames."""

    first: int
    """Index of the first frame."""
    end: int
    """Index of the frame after the last one."""
    start_s: float
    """Start in the file, in seconds since its first frame."""
    end_s: float
    """End in the file, in seconds since its first frame."""

    @property
    def duration_s(self) -> float:
        """Length in seconds."""
        return round(self.end_s - self.start_s, 6)


def whole(info: VideoInfo) -> Span:
    """Return the span of all frames of a file."""
    return Span(0, len(info.frame_times), 0.0, info.duration_s)


def span(info: VideoInfo, start_s: float, end_s: float) -> Span:
    """Return the frames that are seen between two times.

    A time that is nearer to the beginning of a frame than half a frame is taken for it, as times
    are often rounded. Otherwise the frame that is on the screen at `start_s` is the first one.

    Parameters
    ----------
    start_s, end_s
        In seconds since the file's first frame.

    Raises
    ------
    FormatError
        If the start isn't within the video, or the end is later than its end by more than a frame.
    """
    times = info.frame_times
    edges = np.append(times, info.duration_s)
    step = float(np.median(np.diff(edges)))
    if start_s >= info.duration_s - step / 2 or end_s > info.duration_s + max(step, 1 / info.fps):
        raise FormatError(
            f"the part from {start_s:g} to {end_s:g} s is not in the video, which is "
            f"{info.duration_s:g} s long",
            fix="correct its start and its end",
        )
    start, end = (_nearest(edges, t, step / 2) for t in (start_s, min(end_s, info.duration_s)))
    first = int(np.searchsorted(times, start, "left"))
    if first == len(times) or times[first] > start:
        first -= 1
    after = int(np.searchsorted(times, end, "left"))
    if after <= first:
        after, end = first + 1, float(edges[first + 1])
    return Span(first, after, start, end)


def _nearest(edges: NDArray[np.float64], t: float, slack: float) -> float:
    """Return the edge near to a time, the later one in the middle of two; else the time."""
    distances = np.abs(edges - t)
    near = np.flatnonzero(distances <= distances.min() + _SAME_S)[-1]
    return float(edges[near]) if distances[near] <= slack + _SAME_S else t


def constant_rate(info: VideoInfo, part: Span) -> float | None:
    """Return the frames a second of a span, or None if its frames differ in duration."""
    times = info.frame_times[part.first : part.end]
    if len(times) < 2:
        return info.fps
    rate = (len(times) - 1) / float(times[-1] - times[0])
    expected = times[0] + np.arange(len(times)) / rate
    # Containers round times, to milliseconds in WebM.
    is_constant = np.abs(times - expected).max() < max(0.1 / rate, 0.0015)
    return round(rate, 3) if is_constant else None


def first_picture(file: Path, info: VideoInfo, part: Span) -> NDArray[np.uint8]:
    """Return the first frame of a span as people see it.

    Returns
    -------
    NDArray[np.uint8]
        Shape (height, width, 3): red, green and blue, rows from the top down.

    Raises
    ------
    FormatError
        If the frame can't be read.
    """
    with _named(file, part):
        return picture(next(_frames(file, _Clock.of(info, part))), info.pixel_aspect)


def pictures(file: Path, info: VideoInfo, part: Span) -> Iterator[tuple[float, NDArray[np.uint8]]]:
    """Yield the frames of a span as people see them, each with its time in the file in seconds.

    They have the form that :func:`first_picture` gives, and the same errors.
    """
    clock = _Clock.of(info, part)
    with _named(file, part):
        for at, frame in zip(clock.times, _frames(file, clock), strict=True):
            yield float(at), picture(frame, info.pixel_aspect)


def frames(file: Path, info: VideoInfo, part: Span) -> Iterator[av.VideoFrame]:
    """Yield the frames of a span as they are stored; a FormatError if one can't be read."""
    with _named(file, part):
        yield from _frames(file, _Clock.of(info, part))


def cut(file: Path, info: VideoInfo, part: Span, target: Path) -> None:
    """Write a span of a video as a file of its own.

    Parameters
    ----------
    info
        The properties of `file`.
    target
        The new file, whose ending is that of the video's container.

    Raises
    ------
    FormatError
        If the frames can't be read, or this build of PyAV has no encoder.
    """
    with _named(file, part):
        try:
            _write(file, info, part, target, is_copied=True)
        except _OtherFramesError:
            _write(file, info, part, target, is_copied=False)


class _OtherFramesError(Exception):
    """A span can't be copied, as other frames are needed to decode it."""


@contextmanager
def _named(file: Path, part: Span) -> Iterator[None]:
    """Name the file and its part in errors."""
    import av  # noqa: PLC0415 - large, and not always installed

    try:
        yield
    except (av.FFmpegError, ValueError) as error:
        raise FormatError(
            f"the part from {part.start_s:g} to {part.end_s:g} s can't be cut: {reason(error)}",
            where=str(file),
            fix="make the video again, or install the wheel of PyAV: pip install av",
        ) from error


@dataclass(frozen=True, slots=True)
class _Clock:
    """The times of a span's frames, in seconds since the file's first frame."""

    part: Span
    times: NDArray[np.float64]
    """Times of the span's frames."""
    zero_s: float
    """The file's first frame on the container's clock."""
    after_s: float
    """Between the last frame and the one after it."""
    slack_s: float
    """Less than any two frames are apart."""

    @staticmethod
    def of(info: VideoInfo, part: Span) -> _Clock:
        steps = np.diff(info.frame_times)
        slack_s = float(steps[steps > 0].min(initial=info.duration_s)) / 4
        is_last = part.end == len(info.frame_times)
        after_s = np.inf if is_last else float(info.frame_times[part.end]) - slack_s
        times = info.frame_times[part.first : part.end]
        return _Clock(part, times, info.first_time_s, after_s, slack_s)

    def seconds(self, item: Any) -> float | None:
        """Return the time of a packet or a frame, in seconds."""
        if item.pts is None or item.time_base is None:
            return None
        return float(item.pts * item.time_base) - self.zero_s

    def has(self, seconds: float) -> bool:
        """Check that a time is within the span."""
        return bool(self.times[0] - self.slack_s <= seconds < self.after_s)

    def number(self, seconds: float) -> int:
        """Return the number of the frame that has a time; -1 if none has it."""
        nearest = int(np.searchsorted(self.times, seconds - self.slack_s))
        is_near = nearest < len(self.times) and self.times[nearest] <= seconds + self.slack_s
        return nearest if is_near else -1

    def seek(self, container: Any, stream: Any) -> None:
        """Go to the last key frame before the span, in a container that was just opened."""
        if self.times[0] > 0:
            at_s = float(self.times[0]) + self.zero_s + self.slack_s
            container.seek(round(at_s / stream.time_base), stream=stream)


def _write(file: Path, info: VideoInfo, part: Span, target: Path, *, is_copied: bool) -> None:
    import av  # noqa: PLC0415 - large, and not always installed

    kind, clock = target.suffix.lower().lstrip("."), _Clock.of(info, part)
    with av.open(str(target), "w", format=kind, options=MUXED[kind]) as out:
        pictures = _copied(file, clock, out) if is_copied else _encoded(file, info, clock, out)
        # Both make their streams before the first packet comes.
        for _, packet in heapq.merge(pictures, _sound(file, clock, out), key=itemgetter(0)):
            out.mux(packet)


def _copied(file: Path, clock: _Clock, out: Any) -> Iterator[_Timed]:
    """Yield the packets of a span, copied, with their times in it; an error if they need others."""
    part, times = clock.part, clock.times
    if part.start_s != times[0]:
        raise _OtherFramesError  # it begins within a frame
    container, source = open_video(file)
    with container:
        stream = out.add_stream_from_template(source, opaque=True)
        clock.seek(container, source)
        begin, seen = None, set[int]()
        for packet in container.demux(source):
            at = clock.seconds(packet)
            if at is None or packet.dts is None:
                continue  # the end of the file
            if at >= clock.after_s and packet.is_keyframe:
                break
            number = clock.number(at)
            if begin is None:
                if number != 0 or not packet.is_keyframe:
                    raise _OtherFramesError
                begin = packet.pts
            if not clock.has(at) or packet.is_discard or packet.is_corrupt:
                raise _OtherFramesError
            if number == len(times) - 1:
                packet.duration = max(round((part.end_s - at) / packet.time_base), 1)
            seen.add(number)  # -1: of a frame that isn't shown
            packet.pts, packet.dts, packet.stream = packet.pts - begin, packet.dts - begin, stream
            yield at - part.start_s, packet
        if len(seen - {-1}) < len(times):
            raise _OtherFramesError


def _encoded(file: Path, info: VideoInfo, clock: _Clock, out: Any) -> Iterator[_Timed]:
    """Yield the frames of a span, encoded upright, with their times in it."""
    part = clock.part
    starts = np.maximum(clock.times - part.start_s, 0.0)
    ends = np.append(starts[1:], part.duration_s)
    stream: Any = None
    pts, durations = -1, dict[int, int]()

    def packets(frame: av.VideoFrame | None) -> Iterator[_Timed]:
        for packet in stream.encode(frame):
            packet.duration = durations[packet.pts]  # encoders take the mean one
            yield float(packet.pts * packet.time_base), packet

    for frame, start_s, end_s in zip(_frames(file, clock), starts, ends, strict=True):
        flat = upright(frame)
        if stream is None:
            stream = _encoder(out, info, flat)
        flat.pts = pts = max(round(start_s / _UNIT), pts + 1)
        flat.time_base, durations[pts] = _UNIT, max(round((end_s - start_s) / _UNIT), 1)
        yield from packets(flat)
    yield from packets(None)


def _encoder(out: Any, info: VideoInfo, frame: av.VideoFrame) -> Any:
    """Add the stream into which frames like an upright one are encoded."""
    encoder, options = ENCODERS[out.format.name]
    stream = out.add_stream(encoder, rate=max(round(info.fps), 1))
    stream.width, stream.height, stream.pix_fmt = frame.width, frame.height, frame.format.name
    stream.options = options
    context = stream.codec_context
    stream.time_base = context.time_base = _UNIT
    context.colorspace, context.color_range = frame.colorspace, frame.color_range
    is_turned = info.rotation % 180 == 90
    context.sample_aspect_ratio = 1 / info.pixel_aspect if is_turned else info.pixel_aspect
    return stream


def _frames(file: Path, clock: _Clock) -> Iterator[av.VideoFrame]:
    """Yield the frames of a span; a ValueError if one is missing."""
    count = 0
    for is_sought in (True, False):
        container, source = open_video(file)
        with container:
            if is_sought:
                clock.seek(container, source)
            for frame in container.decode(source):
                at = clock.seconds(frame)
                if at is None or at < clock.times[0] - clock.slack_s:
                    continue
                if abs(at - clock.times[count]) > clock.slack_s or frame.is_corrupt:
                    break  # frames before the key frame are needed, too
                yield frame
                count += 1
                if count == len(clock.times):
                    return
        if count:
            break
    raise ValueError(f"frame {count + 1} of {len(clock.times)} is missing")


def _sound(file: Path, clock: _Clock, out: Any) -> Iterator[_Timed]:
    """Yield the packets of a span's sound, with their times in it."""
    part = clock.part
    container, pictures = open_video(file)
    with container:
        source = next(iter(container.streams.audio), None)
        codec = source.codec_context.codec if source and source.codec_context else None
        if codec is None or codec.canonical_name not in SOUND[out.format.name]:
            return
        clock.seek(container, pictures)
        stream = None
        for packet in container.demux(source):
            at = clock.seconds(packet)
            if at is None or packet.dts is None or at < part.start_s:
                continue
            if at >= part.end_s:
                break
            stream = stream or out.add_stream_from_template(source, opaque=True)
            shift = round((part.start_s + clock.zero_s) / packet.time_base)
            packet.pts, packet.dts, packet.stream = packet.pts - shift, packet.dts - shift, stream
            yield at - part.start_s, packet
