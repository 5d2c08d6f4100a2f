"""Episodes of robots' recordings: MCAP files, ROS 2 bags (MCAP or SQLite) and ROS 1 bags.

A recording is an episode. Its cameras are the topics with compressed images, compressed video or
raw images, in ROS's messages or Foxglove's. Frames come as they are published; a video has them at
a constant rate, each from its time on.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from itertools import islice, repeat
from pathlib import Path
from typing import Any

import numpy as np

from corpus_tools.episodes.bag_reading import (
    ENDINGS,
    Published,
    Recording,
    message_of,
    opened,
    recordings_in,
)
from corpus_tools.episodes.curves import MOST_NUMBERS, EpisodeCurves
from corpus_tools.episodes.films import Picture, decoded
from corpus_tools.episodes.study_tables import OnError, RecordedEpisode
from corpus_tools.tables.curve_file import LONGEST_NAME, MOST_CURVES, Curve, Values
from corpus_tools.video.picture_file import MOST_PIXELS
from g3.errors import CorpusError, FormatError

COMPRESSED, VIDEO, RAW = "CompressedImage", "CompressedVideo", "Image"
CAMERA_TYPES = {COMPRESSED: COMPRESSED, VIDEO: VIDEO, RAW: RAW, "RawImage": RAW}
"""Kinds of messages with pictures, by the last names of their types."""
FPS, FASTEST, SLOWEST = 10.0, 120.0, 1.0
"""Frames a second of a video with one frame, and the limits for others."""
FRAMES_TO_MEASURE = 200
MOST_GAP_S = 600.0
MOST_BACK_S = 1.0
"""Seconds by which a message may be older than the one before it."""
ROWS_AT_ONCE = 1 << 12
MESSAGES_TO_NAME = 2000
"""Number of messages in which the names of curves are looked for."""
_CODECS = {"h264": "h264", "h265": "hevc", "hevc": "hevc", "vp9": "vp9", "av1": "av1"}
_COLOURS = {
    "rgb8": (0, 1, 2), "bgr8": (2, 1, 0), "rgba8": (0, 1, 2), "bgra8": (2, 1, 0),
    "mono8": (0, 0, 0), "8UC1": (0, 0, 0), "8UC3": (2, 1, 0),
}  # fmt: skip
"""The channels of red, green and blue in each encoding."""
_CHANNELS = {"rgb8": 3, "bgr8": 3, "8UC3": 3, "rgba8": 4, "bgra8": 4, "mono8": 1, "8UC1": 1}
_NS = 1e-9
_POSE = tuple(f"{part}.{axis}" for part in ("position", "orientation") for axis in "xyzw")
_TWIST = tuple(f"{part}.{axis}" for part in ("linear", "angular") for axis in "xyz")
_WRENCH = tuple(f"{part}.{axis}" for part in ("force", "torque") for axis in "xyz")
NUMBERS: Mapping[str, tuple[str, tuple[str, ...]]] = {
    "JointState": ("", ("position", "velocity", "effort")),
    "Pose": ("", _POSE), "PoseStamped": ("pose", _POSE),
    "Twist": ("", _TWIST), "TwistStamped": ("twist", _TWIST),
    "Wrench": ("", _WRENCH), "WrenchStamped": ("wrench", _WRENCH),
    **{f"Float{n}": ("", ("data",)) for n in (32, 64)},
    **{f"Float{n}MultiArray": ("", ("data",)) for n in (32, 64)},
}  # fmt: skip
"""Fields of messages that are drawn as curves, with the field that holds them, by type."""


@dataclass(frozen=True, slots=True)
class Recordings:
    """The recordings of a folder, or one.

    Parameters
    ----------
    path
        The given file or folder, resolved.
    files
        Files and bags, in the order of their names.
    kinds
        The kind of messages of each camera of the first.
    numbers
        The type of messages of each topic of the first that is drawn as curves.
    """

    path: Path
    files: tuple[Path, ...]
    kinds: Mapping[str, str]
    numbers: Mapping[str, str]
    fps: float | None = None
    """Frames a second of the videos, instead of the cameras'."""
    without_cameras: str = (
        "record a topic with compressed images (sensor_msgs/CompressedImage, "
        "foxglove.CompressedImage), compressed video or raw images"
    )
    notes: tuple[str, ...] = ()

    @property
    def cameras(self) -> tuple[str, ...]:
        """The topics with pictures."""
        return tuple(self.kinds)

    @property
    def depth_cameras(self) -> frozenset[str]:
        """The topics that are named so."""
        return frozenset(topic for topic in self.kinds if "depth" in topic.lower())

    @property
    def other_cameras(self) -> frozenset[str]:
        """The topics that some other one has in another form."""
        return frozenset(t for t in self.kinds if any(o.startswith(f"{t}/") for o in self.kinds))

    def episodes(self, cameras: Sequence[str], on_error: OnError) -> Iterator[RecordedEpisode]:
        """Yield a recording after the other."""
        for index, file in enumerate(self.files):
            try:
                with opened(file) as recording:
                    yield self._episode(index, recording, cameras)
            except CorpusError as error:
                on_error(error)

    def _episode(self, index: int, recording: Recording, cameras: Sequence[str]) -> RecordedEpisode:
        path = recording.path
        # The beginning is read twice: so many pictures at once may be too large for the memory.
        with closing(self._shown(recording, cameras[0])) as shown:
            times = np.array([time_ns for time_ns, _ in islice(shown, FRAMES_TO_MEASURE)])
        if not len(times):
            where = f"{path}, {cameras[0]}"
            raise FormatError("there are no pictures", where=where, fix="leave the recording out")
        first_ns, fps = int(times[0]), self.fps or _rate(times)
        views = {
            camera: _at_constant_rate(
                self._shown(recording, camera), fps, first_ns, f"{path}, {camera}"
            )
            for camera in cameras
        }
        source = path.name if path == self.path else path.relative_to(self.path).as_posix()
        curves = partial(self._curves, recording, fps, first_ns)
        return RecordedEpisode(index, source, (), fps, views, str(first_ns), curves)

    def _shown(self, recording: Recording, camera: str) -> Generator[Shown]:
        where = f"{recording.path}, {camera}"
        return _shown(recording.messages((camera,)), self.kinds[camera], where)

    def _curves(
        self, recording: Recording, fps: float, first_ns: int, frames: int
    ) -> EpisodeCurves | None:
        """Return the numbers that are published, at each frame the last ones up to then."""
        if not self.numbers:
            return None
        columns: dict[Curve, int] = {}
        sizes: dict[str, int] = {}
        for message in islice(recording.messages(self.numbers), MESSAGES_TO_NAME):
            for curve, _ in self._values(recording, message):
                is_new = curve not in columns and len(columns) < MOST_CURVES
                if is_new and sizes.get(curve.group, 0) < MOST_NUMBERS:
                    columns[curve] = len(columns)
                    sizes[curve.group] = sizes.get(curve.group, 0) + 1
        if not columns:
            return None
        # Those of a group stand together.
        ordered = sorted(columns, key=lambda curve: list(sizes).index(curve.group))
        places = {curve: place for place, curve in enumerate(ordered)}
        values = (
            (message.time_ns, self._values(recording, message))
            for message in recording.messages(self.numbers)
        )
        return EpisodeCurves(ordered, fps, frames, _sampled(values, places, fps, first_ns, frames))

    def _values(self, recording: Recording, message: Published) -> list[tuple[Curve, float]]:
        with message_of(f"{recording.path}, {message.topic}"):
            return _numbers(message.topic, self.numbers[message.topic], message.content())


def open_recordings(path: Path, *, fps: float | None = None) -> Recordings:
    """Find the recordings, and the cameras of the first.

    Parameters
    ----------
    path
        A file, a ROS 2 bag's folder, or a folder of such.
    fps
        Frames a second of the videos; by default as many as the camera has.
    """
    path = path.resolve()
    files = tuple(recordings_in(path))
    if not files:
        fix = f"name a file that ends in {', '.join(ENDINGS)}, a bag's folder, or a folder of these"
        raise FormatError("there are no recordings", where=str(path), fix=fix)
    with opened(files[0]) as recording:
        types = sorted(recording.types().items())
    kinds = {topic: CAMERA_TYPES[kind] for topic, kind in types if kind in CAMERA_TYPES}
    numbers = {topic: kind for topic, kind in types if kind in NUMBERS}
    return Recordings(path, files, kinds, numbers, fps)


Shown = tuple[int, Callable[[], Picture]]
"""A time in nanoseconds, and a picture that is decoded when it is needed."""


def _shown(messages: Iterator[Published], kind: str, where: str) -> Generator[Shown]:
    """Yield the pictures of a topic with their times."""
    if kind == VIDEO:
        yield from _of_video(messages, where)
        return
    for number, message in enumerate(messages):
        yield message.time_ns, _of_image(message, kind, f"{where}, picture {number}")


def _of_image(message: Published, kind: str, where: str) -> Callable[[], Picture]:
    def picture() -> Picture:
        with message_of(where):
            content = message.content()
            if kind == RAW:
                return Picture(_raw_pixels(content), where)
            return decoded(bytes(content.data), where)

    return picture


def _raw_pixels(message: Any) -> Any:
    """Return the pixels of a raw image, shape (height, width, 3)."""
    height, width, encoding = int(message.height), int(message.width), str(message.encoding)
    if encoding not in _COLOURS:
        raise ValueError(f"the encoding {encoding!r:.40} isn't among {', '.join(_COLOURS)}")
    if not min(height, width) >= 2 or height * width > MOST_PIXELS:
        raise ValueError(f"the size is {width} by {height} pixels")
    row, channels = int(message.step), _CHANNELS[encoding]
    pixels = np.frombuffer(bytes(message.data), np.uint8)
    if row < width * channels or len(pixels) < row * height:
        raise ValueError(f"there are {len(pixels)} bytes of {width} by {height} pixels")
    pixels = pixels[: row * height].reshape(height, row)[:, : width * channels]
    return np.ascontiguousarray(pixels.reshape(height, width, channels)[..., _COLOURS[encoding]])


def _of_video(messages: Iterator[Published], where: str) -> Iterator[Shown]:
    """Yield the frames of a video, one message each; those before the first key frame are lost."""
    import av  # noqa: PLC0415 - large, and not always installed

    context: Any = None
    times: list[int] = []
    has_begun = False
    for number, message in enumerate(messages):
        place = f"{where}, picture {number}"
        times.append(message.time_ns)
        with message_of(place):
            content = message.content()
            if context is None:
                context = _video_decoder(str(content.format))
            packet = av.Packet(bytes(content.data))
            packet.pts = number
            try:
                frames = context.decode(packet)
            except av.FFmpegError:
                if has_begun:
                    raise
                continue
            for frame in frames:
                has_begun = True
                yield times[frame.pts], _fixed(_frame(frame, place))
    with message_of(where):
        for frame in context.decode(None) if context is not None else ():
            yield times[frame.pts], _fixed(_frame(frame, where))


def _video_decoder(form: str) -> Any:
    import av  # noqa: PLC0415 - as above

    if form.lower() not in _CODECS:
        raise ValueError(f"the format {form!r:.40} isn't among {', '.join(_CODECS)}")
    context: Any = av.CodecContext.create(_CODECS[form.lower()], "r")
    context.options = {"max_pixels": str(MOST_PIXELS), "flags": "low_delay"}
    context.thread_count = 1
    return context


def _frame(frame: Any, where: str) -> Picture:
    return Picture(np.ascontiguousarray(frame.to_ndarray(format="rgb24")), where)


def _fixed(picture: Picture) -> Callable[[], Picture]:
    return lambda: picture


def _rate(times_ns: Any) -> float:
    """Return a camera's frames a second, a whole number if they are near to one."""
    gaps = np.diff(times_ns) * _NS
    usual = float(np.median(gaps[gaps > 0])) if (gaps > 0).any() else 1 / FPS
    rate = min(max(1 / usual, SLOWEST), FASTEST)
    return float(round(rate)) if abs(rate - round(rate)) < 0.05 * rate else round(rate, 2)


def _at_constant_rate(
    shown: Iterator[Shown], fps: float, first_ns: int, where: str
) -> Iterator[Picture]:
    """Yield a picture for each frame: the last that was taken up to then, to half a frame.

    Until a camera's first picture that one is seen, and of those before `first_ns` the last.
    """
    last_ns = first_ns
    before: Callable[[], Picture] | None = None
    frame = 0
    for time_ns, picture in shown:
        gap_s = (time_ns - last_ns) * _NS
        is_before = time_ns < first_ns and frame == 0
        if gap_s > MOST_GAP_S or (gap_s < -MOST_BACK_S and not is_before):
            what = f"after {(last_ns - first_ns) * _NS:g} s comes {(time_ns - first_ns) * _NS:g} s"
            fix = "cut the recording there, or sort it: mcap sort FILE"
            raise FormatError(f"the times of pictures don't go on: {what}", where=where, fix=fix)
        last_ns = max(last_ns, time_ns)
        following = int((last_ns - first_ns) * _NS * fps + 0.5)
        if following > frame:
            yield from repeat((before or picture)(), following - frame)
            frame = following
        before = picture
    if before is not None:
        yield before()


def _numbers(topic: str, kind: str, message: Any) -> list[tuple[Curve, float]]:
    """Return the numbers of a message with the names of their curves."""
    holder, fields = NUMBERS[kind]
    holding = _field(message, holder) if holder else message
    joints = _field(message, "name") if kind == "JointState" else ()
    found = []
    for name in fields:
        value = _field(holding, name)
        if value is None:
            continue
        values = np.asarray(value, np.float64).reshape(-1)
        if len(values) > MOST_NUMBERS:
            continue
        group, names = topic, [name]
        if kind == "JointState":
            group, names = f"{topic} {name}", [str(joint) for joint in joints or ()]
        if kind.endswith("MultiArray") or (kind == "JointState" and len(names) != len(values)):
            names = [str(number) for number in range(1, len(values) + 1)]
        found += [
            (Curve(group[:LONGEST_NAME], one[:LONGEST_NAME]), float(number))
            for one, number in zip(names, values, strict=False)
        ]
    return found


def _field(message: Any, name: str) -> Any:
    """Return a field of a message, which may be in others; None if there is none."""
    for part in name.split("."):
        if isinstance(message, Mapping):
            message = message.get(part)
        else:
            message = getattr(message, part, None)
    return message


def _sampled(
    messages: Iterator[tuple[int, list[tuple[Curve, float]]]],
    places: Mapping[Curve, int],
    fps: float,
    first_ns: int,
    frames: int,
) -> Iterator[Values]:
    """Yield the rows of all frames; numbers stay until others are published."""
    row = np.full(len(places), np.nan, np.float32)
    frame = 0

    def until(end: int) -> Iterator[Values]:
        nonlocal frame
        while frame < end:
            count = min(end - frame, ROWS_AT_ONCE)
            yield np.repeat(row[None], count, axis=0)
            frame += count

    for time_ns, values in messages:
        yield from until(min(int((time_ns - first_ns) * _NS * fps + 0.5), frames))
        if frame >= frames:
            return
        with np.errstate(over="ignore"):
            for curve, value in values:
                if curve in places:
                    row[places[curve]] = value
    yield from until(frames)
