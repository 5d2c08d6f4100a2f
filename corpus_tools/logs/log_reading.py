"""Reading of logs into the domain types, and their summaries.

Errors name problems and their places.
"""

from __future__ import annotations

import io
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import msgspec
import numpy as np
import numpy.typing as npt
from mcap.records import Channel, Message, Metadata
from mcap.stream_reader import StreamReader

from corpus_tools.logs import channels
from corpus_tools.logs.foxglove import FrameTransforms
from corpus_tools.world.state.recording import NS_PER_S, Recording, Step
from g3.errors import FormatError
from g3.groundings import Context, FloatArray
from g3.short_repr import short_repr
from g3.storage import regular_file

T = TypeVar("T", bound=msgspec.Struct)

_MAGIC = b"\x89MCAP0\r\n"
_FIX = "restore the file, or render the scenario again"
_NOT_A_LOG = "give a file that `ct render-videos` or write_log made"


@short_repr
@dataclass(frozen=True, slots=True, eq=False)
class Log:
    """Content of a log's file."""

    recording: Recording
    name: str
    """Name of the scenario."""
    metadata: Mapping[str, str]
    """Metadata that the writer kept with it."""


@dataclass(frozen=True, slots=True)
class _File:
    """Metadata by name, and times and contents of messages by topic."""

    metadata: dict[str, dict[str, str]]
    messages: dict[str, list[tuple[int, bytes]]]


def read_log(path: Path) -> Log:
    """Read a log.

    Returns
    -------
    Log
        Its recording has the very numbers that were written.
    """
    try:
        content = regular_file.read_bytes(path)
    except OSError as error:
        raise FormatError(
            f"the file can't be read: {error.strerror}", where=str(path), fix="give a log's file"
        ) from error
    file = _read_mcap(content, path)
    about = file.metadata.get(channels.LIBRARY)
    if about is None:
        raise FormatError("this is no log of a world", where=str(path), fix=_NOT_A_LOG)
    if about.get("version") != str(channels.VERSION):
        raise FormatError(
            f"the format's version is {about.get('version')}, this program reads "
            f"{channels.VERSION}",
            where=str(path),
            fix="render the scenario again, or use the program's version that wrote it",
        )
    try:
        recording = _recording(file, path)
    except ValueError as error:
        raise FormatError(str(error), where=str(path), fix=_FIX) from error
    return Log(recording, about.get("name", ""), file.metadata.get(channels.METADATA, {}))


def _read_mcap(content: bytes, path: Path) -> _File:
    if not content.startswith(_MAGIC):
        what = "the file is cut off, damaged or no MCAP file"
        raise FormatError(what, where=str(path), fix=_NOT_A_LOG)
    file = _File({}, {topic: [] for topic in channels.CHANNELS})
    topics: dict[int, str] = {}
    stream = io.BytesIO(content)
    reader = StreamReader(stream, validate_crcs=True, record_size_limit=len(content))
    try:
        for record in reader.records:
            if isinstance(record, Message):
                messages = file.messages.get(topics[record.channel_id])
                if messages is not None:
                    messages.append((record.log_time, record.data))
            elif isinstance(record, Channel):
                topics[record.id] = record.topic
            elif isinstance(record, Metadata):
                file.metadata[record.name] = record.metadata
    # A byte out of place makes the parser fail in any way there is.
    except Exception as error:
        raise FormatError(
            f"the file is cut off, damaged or no MCAP file ({str(error) or type(error).__name__})",
            where=f"{path}: byte {stream.tell()}",
            fix=_FIX,
        ) from error
    return file


def _recording(file: _File, path: Path) -> Recording:
    start = channels.context_of(_only(file, channels.CONTEXT, channels.ContextRecord, path))
    steps = channels.steps_of(_only(file, channels.STEPS, channels.StepsRecord, path))
    robots = _decoded(file, channels.ROBOT, channels.RobotRecord, path)
    t_ns = np.array([t for t, _ in robots], dtype=np.int64)
    position, orientation = _poses(_decoded(file, channels.TF, FrameTransforms, path), start, t_ns)
    return Recording(
        start=start,
        t_ns=t_ns,
        position=position,
        orientation=orientation,
        fork_height_m=np.array([robot.fork_height_m for _, robot in robots]),
        steps=steps,
    )


def _poses(
    messages: list[tuple[int, FrameTransforms]], start: Context, t_ns: npt.NDArray[np.int64]
) -> tuple[FloatArray, FloatArray]:
    """Return positions (n, b, 3), orientations (n, b, 4): each object's latest at each moment."""
    index = {item.id: i for i, item in enumerate(start.objects)}
    moment = {t: k for k, t in enumerate(t_ns.tolist())}
    values: list[tuple[float, ...]] = []
    # Row of `values` with the latest pose, by moment and object.
    latest = np.full((len(t_ns), len(index)), -1, dtype=np.int64)
    for t, message in messages:
        k = moment.get(t)
        if k is None:
            raise ValueError(
                f"{channels.TF} has poses at {t / NS_PER_S:g} s, where {channels.ROBOT} has none"
            )
        for transform in message.transforms:
            i = index.get(transform.child_frame_id)
            if i is not None:
                latest[k, i] = len(values)
                at, turn = transform.translation, transform.rotation
                values.append((at.x, at.y, at.z, turn.w, turn.x, turn.y, turn.z))
    latest = np.maximum.accumulate(latest, axis=0)
    if (latest < 0).any():
        raise ValueError(f"{channels.TF} doesn't begin with the poses of all objects")
    poses = np.array(values).reshape(-1, 7)[latest]
    return poses[..., :3].copy(), poses[..., 3:].copy()


def _only(file: _File, topic: str, message: type[T], path: Path) -> T:
    content = _decoded(file, topic, message, path)
    if len(content) != 1:
        raise ValueError(f"{topic} has {len(content)} messages, not one")
    return content[0][1]


def _decoded(file: _File, topic: str, message: type[T], path: Path) -> list[tuple[int, T]]:
    decode = msgspec.json.Decoder(message).decode
    t = 0
    try:
        messages: list[tuple[int, Any]] = []
        for t, data in file.messages[topic]:
            messages.append((t, decode(data)))
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        match = re.fullmatch(r"(?s)(.*?)(?: - at `\$\.?(.*)`)?", str(error))
        what, field = (match[1], match[2]) if match else (str(error), None)
        where = f"{path}: {topic} at {t / NS_PER_S:g} s"
        raise FormatError(
            what[:1].lower() + what[1:], where=f"{where}: {field}" if field else where, fix=_FIX
        ) from error
    return messages


@dataclass(frozen=True, slots=True)
class ObjectSummary:
    """An object, and the length of its way in metres."""

    id: str
    labels: tuple[str, ...]
    travelled_m: float


@dataclass(frozen=True, slots=True)
class Summary:
    """Summary of a log's content."""

    scenario: str
    duration_s: float
    moments: int
    robot: str
    objects: tuple[ObjectSummary, ...]
    places: tuple[str, ...]
    steps: tuple[Step, ...]
    metadata: Mapping[str, str]


def summary(log: Log) -> Summary:
    """Sum a log up; places without a name are left out."""
    recording = log.recording
    way = np.linalg.norm(np.diff(recording.position, axis=0), axis=2).sum(axis=0).tolist()
    return Summary(
        scenario=log.name,
        duration_s=float(recording.t_s[-1] - recording.t_s[0]),
        moments=len(recording.t_ns),
        robot=recording.start.agent_id,
        objects=tuple(
            ObjectSummary(item.id, item.labels, metres)
            for item, metres in zip(recording.start.objects, way, strict=True)
        ),
        places=tuple(place.name for place in recording.start.places if place.name),
        steps=recording.steps,
        metadata=log.metadata,
    )


def as_table(held: Summary) -> str:
    """Return the summary as a table for people."""
    lines = [
        f"scenario  {held.scenario}",
        f"duration  {held.duration_s:.2f} s, {held.moments} moments",
        f"robot     {held.robot}",
        f"places    {', '.join(held.places) or 'none'}",
        *(f"{name}: {value}" for name, value in held.metadata.items()),
        "",
        f"{len(held.objects)} objects",
        *(
            f"  {item.id}  {' '.join(item.labels)}"
            + (f", travels {item.travelled_m:.2f} m" if item.travelled_m else "")
            for item in held.objects
        ),
        "",
        f"{len(held.steps)} steps",
        *(
            f"  {step.start_s:7.2f} to {step.end_s:7.2f} s  {step.action} "
            + " ".join(value for _, value in step.arguments)
            for step in held.steps
        ),
    ]
    return "\n".join(lines)
