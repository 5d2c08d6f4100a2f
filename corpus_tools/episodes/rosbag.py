"""Episodes of robots' recordings: MCAP files, ROS 2 bags (MCAP or SQLite) and ROS 1 bags.

A recording is an episode. Its cameras are the topics with compressed images, compressed video or
raw images, in ROS's messages or Foxglove's. Frames come as they are published; a video has them at
a constant rate, each from its time on.
"""

from __future__ import annotations

import base64
from collections.abc import Callable, Generator, Iterator, Mapping
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import lz4.frame
import msgspec
import numpy as np
import zstandard
from mcap.reader import SeekingReader
from mcap.records import Channel, Chunk, Message, Schema
from mcap.stream_reader import StreamReader, breakup_chunk

from corpus_tools.episodes.films import Picture, decoded
from corpus_tools.episodes.study_tables import OnError, RecordedEpisode
from corpus_tools.runtime.extras import import_extra
from corpus_tools.video.picture_file import MOST_PIXELS
from g3.errors import CorpusError, FormatError
from g3.storage import regular_file

ENDINGS = (".mcap", ".bag", ".db3")
BAG = "metadata.yaml"
"""The file that makes a folder a ROS 2 bag."""
COMPRESSED, VIDEO, RAW = "CompressedImage", "CompressedVideo", "Image"
CAMERA_TYPES = {COMPRESSED: COMPRESSED, VIDEO: VIDEO, RAW: RAW, "RawImage": RAW}
"""Kinds of messages with pictures, by the last names of their types."""
FPS, FASTEST, SLOWEST = 10.0, 120.0, 1.0
"""Frames a second of a video with one frame, and the limits for others."""
FRAMES_TO_MEASURE = 200
MOST_GAP_S = 600.0
MOST_BACK_S = 1.0
"""Seconds by which a message may be older than the one before it."""
MOST_CHUNK = 1 << 30
_CODECS = {"h264": "h264", "h265": "hevc", "hevc": "hevc", "vp9": "vp9", "av1": "av1"}
_COLOURS = {
    "rgb8": (0, 1, 2), "bgr8": (2, 1, 0), "rgba8": (0, 1, 2), "bgra8": (2, 1, 0),
    "mono8": (0, 0, 0), "8UC1": (0, 0, 0), "8UC3": (2, 1, 0),
}  # fmt: skip
"""The channels of red, green and blue in each encoding."""
_CHANNELS = {"rgb8": 3, "bgr8": 3, "8UC3": 3, "rgba8": 4, "bgra8": 4, "mono8": 1, "8UC1": 1}
_FIX = "copy the recording once more, or recover it: mcap recover FILE, ros2 bag reindex FOLDER"
_NS = 1e-9


@dataclass(frozen=True, slots=True)
class _Published:
    """A message of a topic; its content is decoded when it is needed."""

    time_ns: int
    content: Callable[[], Any]


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
    """

    path: Path
    files: tuple[Path, ...]
    kinds: Mapping[str, str]
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

    def episodes(self, camera: str, on_error: OnError) -> Iterator[RecordedEpisode]:
        """Yield a recording after the other."""
        for index, file in enumerate(self.files):
            try:
                yield self._episode(index, file, camera)
            except CorpusError as error:
                on_error(error)

    def _episode(self, index: int, file: Path, camera: str) -> RecordedEpisode:
        where = f"{file}, {camera}"
        # The beginning is read twice: so many pictures at once may be too large for the memory.
        with closing(self._shown(file, camera, where)) as shown:
            times = np.array([time_ns for time_ns, _ in islice(shown, FRAMES_TO_MEASURE)])
        if not len(times):
            raise FormatError("there are no pictures", where=where, fix="leave the recording out")
        fps = self.fps or _rate(times)
        pictures = _at_constant_rate(self._shown(file, camera, where), fps, where)
        source = file.name if file == self.path else file.relative_to(self.path).as_posix()
        return RecordedEpisode(index, source, (), fps, pictures, str(times[0]))

    def _shown(self, file: Path, camera: str, where: str) -> Generator[Shown]:
        return _shown(_published(file, camera), self.kinds[camera], where)


def open_recordings(path: Path, *, fps: float | None = None) -> Recordings:
    """Find the recordings, and the cameras of the first.

    Parameters
    ----------
    path
        A file, a ROS 2 bag's folder, or a folder of such.
    fps
        Frames a second of the videos; by default as many as the camera has.

    Raises
    ------
    FormatError
        If there is none, the first can't be read, or a package isn't installed that it needs.
    """
    path = path.resolve()
    files = tuple(_recordings(path))
    if not files:
        fix = f"name a file that ends in {', '.join(ENDINGS)}, a bag's folder, or a folder of these"
        raise FormatError("there are no recordings", where=str(path), fix=fix)
    with _content_of(files[0]):
        types = _mcap_types(files[0]) if _is_mcap(files[0]) else _bag_types(files[0])
    kinds = {t: CAMERA_TYPES[k] for t, k in sorted(types.items()) if k in CAMERA_TYPES}
    return Recordings(path, files, kinds, fps)


def _recordings(path: Path) -> Iterator[Path]:
    if path.suffix in ENDINGS and path.is_file():
        yield path
    elif (path / BAG).is_file():
        of_mcap = sorted(path.glob("*.mcap"))
        yield of_mcap[0] if len(of_mcap) == 1 else path
    elif path.is_dir():
        for child in sorted(path.iterdir()):
            is_linked_folder = child.is_symlink() and child.is_dir()  # maybe in a circle
            if not (child.name.startswith(".") or is_linked_folder):
                yield from _recordings(child)


def _is_mcap(file: Path) -> bool:
    return file.suffix == ".mcap"


@contextmanager
def _content_of(file: Path) -> Iterator[None]:
    """Turn any error that damaged content causes into a FormatError that names the recording."""
    try:
        yield
    except CorpusError:
        raise
    # A byte out of place makes the parsers fail in any way there is.
    except Exception as error:
        lines = str(error).splitlines() or [type(error).__name__]
        what = f"the recording is cut off or damaged: {lines[0]:.200}"
        raise FormatError(what, where=str(file), fix=_FIX) from error


def _published(file: Path, topic: str) -> Iterator[_Published]:
    with _content_of(file):
        yield from _mcap_messages(file, topic) if _is_mcap(file) else _bag_messages(file, topic)


def _last_name(kind: str) -> str:
    return kind.replace("/", ".").rpartition(".")[2]


def _mcap_types(file: Path) -> dict[str, str]:
    """Return the types of messages of each topic, by the summary if there is one."""
    with regular_file.opened(file) as stream:
        summary = SeekingReader(stream, record_size_limit=file.stat().st_size).get_summary()
    if summary is not None and summary.channels:
        schemas = {number: schema.name for number, schema in summary.schemas.items()}
        channels = list(summary.channels.values())
    else:
        every = list(_mcap_records(file, with_messages=False))
        schemas = {r.id: r.name for r in every if isinstance(r, Schema)}
        channels = [r for r in every if isinstance(r, Channel)]
    return {c.topic: _last_name(schemas.get(c.schema_id, "")) for c in channels}


def _mcap_records(file: Path, *, with_messages: bool) -> Iterator[Any]:
    with regular_file.opened(file) as stream:
        size = file.stat().st_size
        reader = StreamReader(stream, emit_chunks=True, validate_crcs=True, record_size_limit=size)
        for record in reader.records:
            every = _of_chunk(record) if isinstance(record, Chunk) else [record]
            for one in every:
                if with_messages or not isinstance(one, Message):
                    yield one


def _of_chunk(chunk: Chunk) -> list[Any]:
    """Return the records of a chunk, which is uncompressed to its stated size and no further."""
    most = chunk.uncompressed_size + 1
    if most > MOST_CHUNK:
        raise ValueError(f"a chunk has {most - 1} bytes, and at most {MOST_CHUNK} are read")
    if chunk.compression == "zstd":
        data = zstandard.ZstdDecompressor().stream_reader(chunk.data).read(most)
    elif chunk.compression == "lz4":
        data = lz4.frame.LZ4FrameDecompressor().decompress(chunk.data, max_length=most)
    elif chunk.compression:
        raise ValueError(f"a chunk is compressed by {chunk.compression!r:.40}")
    else:
        data = chunk.data
    if len(data) != chunk.uncompressed_size:
        raise ValueError(f"a chunk has other than its {chunk.uncompressed_size} bytes")
    return breakup_chunk(replace(chunk, compression="", data=data), validate_crc=True)


def _mcap_messages(file: Path, topic: str) -> Iterator[_Published]:
    schemas: dict[int, Schema] = {}
    decoders: dict[int, Callable[[bytes], Any]] = {}
    for record in _mcap_records(file, with_messages=True):
        if isinstance(record, Schema):
            schemas[record.id] = record
        elif isinstance(record, Channel) and record.topic == topic:
            if record.id not in decoders:
                decoders[record.id] = _decoder(record, schemas.get(record.schema_id), file)
        elif isinstance(record, Message) and record.channel_id in decoders:
            decode = decoders[record.channel_id]
            yield _Published(record.log_time, partial(decode, record.data))


def _decoder(channel: Channel, schema: Schema | None, file: Path) -> Callable[[bytes], Any]:
    encoding = channel.message_encoding
    if encoding == "json":
        return lambda content: _Json(msgspec.json.decode(content, type=dict[str, Any]))
    if encoding == "protobuf" and schema is not None:
        purpose = "messages in protobuf are read"
        module = import_extra("mcap_protobuf.decoder", "ros", purpose)
        decode: Callable[[bytes], Any] = module.DecoderFactory().decoder_for(encoding, schema)
        return decode
    if encoding == "cdr" and schema is not None and schema.encoding in ("ros2msg", "ros2idl"):
        types = import_extra("rosbags.typesys", "ros", "messages of ROS are read")
        store = types.get_typestore(types.Stores.EMPTY)
        read = (
            types.get_types_from_msg if schema.encoding == "ros2msg" else types.get_types_from_idl
        )
        arguments = (schema.name,) if schema.encoding == "ros2msg" else ()
        store.register(read(schema.data.decode(), *arguments))
        return lambda content: store.deserialize_cdr(content, schema.name)
    raise FormatError(
        f"messages of {channel.topic} are encoded as {encoding!r:.40}, which isn't read",
        where=str(file),
        fix="record them as cdr (ROS 2), protobuf or json",
    )


class _Json:
    """A message in JSON, whose fields are attributes, and whose bytes are in base 64."""

    def __init__(self, fields: Mapping[str, Any]) -> None:
        self._fields = fields

    def __getattr__(self, name: str) -> Any:
        value = self._fields[name]
        return base64.b64decode(value, validate=True) if name == "data" else value


@contextmanager
def _bag(path: Path) -> Iterator[Any]:
    highlevel = import_extra("rosbags.highlevel", "ros", "ROS bags are read")
    types = import_extra("rosbags.typesys", "ros", "ROS bags are read")
    if path.is_dir() and any(path.glob("*.zstd")):
        fix = "write it uncompressed: ros2 bag convert"
        raise FormatError("the bag's files are compressed", where=str(path), fix=fix)
    usual = types.get_typestore(types.Stores.ROS2_HUMBLE)
    with ExitStack() as stack:
        yield stack.enter_context(highlevel.AnyReader([path], default_typestore=usual))


def _bag_types(path: Path) -> dict[str, str]:
    with _bag(path) as reader:
        return {c.topic: _last_name(c.msgtype) for c in reader.connections}


def _bag_messages(path: Path, topic: str) -> Iterator[_Published]:
    with _bag(path) as reader:
        wanted = [c for c in reader.connections if c.topic == topic]
        if not wanted:
            return
        # The reader forgets its types when it is closed, and messages are decoded later on.
        types = reader.typestore
        decode = types.deserialize_cdr if reader.is2 else types.deserialize_ros1
        for connection, time_ns, content in reader.messages(connections=wanted):
            yield _Published(time_ns, partial(decode, content, connection.msgtype))


Shown = tuple[int, Callable[[], Picture]]
"""A time in nanoseconds, and a picture that is decoded when it is needed."""


def _shown(messages: Iterator[_Published], kind: str, where: str) -> Generator[Shown]:
    """Yield the pictures of a topic with their times."""
    if kind == VIDEO:
        yield from _of_video(messages, where)
        return
    for number, message in enumerate(messages):
        yield message.time_ns, _of_image(message, kind, f"{where}, picture {number}")


def _of_image(message: _Published, kind: str, where: str) -> Callable[[], Picture]:
    def picture() -> Picture:
        with _message_of(where):
            content = message.content()
            if kind == RAW:
                return Picture(_raw_pixels(content), where)
            return decoded(bytes(content.data), where)

    return picture


@contextmanager
def _message_of(where: str) -> Iterator[None]:
    try:
        yield
    except CorpusError:
        raise
    except Exception as error:  # as above
        what = f"the message can't be read: {error or type(error).__name__}"
        raise FormatError(f"{what:.300}", where=where, fix=_FIX) from error


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


def _of_video(messages: Iterator[_Published], where: str) -> Iterator[Shown]:
    """Yield the frames of a video, one message each; those before the first key frame are lost."""
    import av  # noqa: PLC0415 - large, and not always installed

    context: Any = None
    times: list[int] = []
    has_begun = False
    for number, message in enumerate(messages):
        place = f"{where}, picture {number}"
        times.append(message.time_ns)
        with _message_of(place):
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
    with _message_of(where):
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


def _at_constant_rate(shown: Iterator[Shown], fps: float, where: str) -> Iterator[Picture]:
    """Yield a picture for each frame: the last that was taken up to then, to half a frame."""
    first_ns = last_ns = 0
    before: Callable[[], Picture] | None = None
    frame = 0
    for time_ns, picture in shown:
        if before is None:
            first_ns = last_ns = time_ns
        gap_s = (time_ns - last_ns) * _NS
        if gap_s > MOST_GAP_S or gap_s < -MOST_BACK_S:
            what = f"after {(last_ns - first_ns) * _NS:g} s comes {(time_ns - first_ns) * _NS:g} s"
            fix = "cut the recording there, or sort it: mcap sort FILE"
            raise FormatError(f"the times of pictures don't go on: {what}", where=where, fix=fix)
        last_ns = max(last_ns, time_ns)
        following = int((last_ns - first_ns) * _NS * fps + 0.5)
        if before is not None and following > frame:
            yield from [before()] * (following - frame)
            frame = following
        before = picture
    if before is not None:
        yield before()
