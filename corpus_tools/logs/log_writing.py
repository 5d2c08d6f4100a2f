"""Writing logs: MCAP files that viewers show and :mod:`corpus_tools.logs.log_reading` reads.

Viewers get scenes: boxes and outlines of objects with their labels, places, the forks.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from mcap.writer import CompressionType, Writer

from corpus_tools.logs import channels
from corpus_tools.logs.channels import VERSION, RobotRecord, context_record, steps_record
from corpus_tools.logs.foxglove import (
    INFO,
    LINE_LIST,
    LINE_LOOP,
    Color,
    CubePrimitive,
    FrameTransform,
    FrameTransforms,
    KeyValuePair,
    LinePrimitive,
    Log,
    Pose,
    Quaternion,
    SceneEntity,
    SceneUpdate,
    TextPrimitive,
    Time,
    Vector3,
    time_of,
)
from corpus_tools.world.state.dimensions import (
    FORK_LENGTH,
    FORK_THICKNESS,
    FORK_WIDTH,
    FORK_Y,
    HEEL_X,
)
from corpus_tools.world.state.recording import NS_PER_S, Recording, Step, heading
from corpus_tools.world.state.replay import NOTHING, carried
from corpus_tools.world.state.shapes import shape_of
from corpus_tools.world.state.thing_kinds import PAINTS, kind_of
from g3.geometry.plane import BoolArray, rotate
from g3.groundings import Context, FloatArray, PhysicalObject, Place
from g3.storage.atomic_file import write_bytes

CHUNK_BYTES = 1 << 20

_Message = tuple[int, str, msgspec.Struct]
"""Time in nanoseconds, topic and message."""


def write_log(recording: Recording, path: Path, *, name: str, metadata: Mapping[str, str]) -> None:
    """Write a recording to an MCAP file.

    The same arguments give the same bytes. At the start the file holds the world, the
    steps and every pose. Then, at every moment, the robot's state and the poses of what
    moved, with all poses again every second.

    Parameters
    ----------
    path
        Path of the file; an existing file is replaced.
    name
        Name of the scenario.
    metadata
        Anything to keep with it, such as versions and seeds.
    """
    write_bytes(path, to_bytes(recording, name=name, metadata=metadata))


def to_bytes(recording: Recording, *, name: str, metadata: Mapping[str, str]) -> bytes:
    """Return the content of a log's file."""
    stream = io.BytesIO()
    writer = Writer(
        stream, chunk_size=CHUNK_BYTES, compression=CompressionType.ZSTD, enable_data_crcs=True
    )
    writer.start(library=channels.LIBRARY)
    writer.add_metadata(channels.LIBRARY, {"version": str(VERSION), "name": name})
    writer.add_metadata(channels.METADATA, dict(sorted(metadata.items())))
    channel = {topic: _register(writer, topic) for topic in channels.CHANNELS}
    sequence = dict.fromkeys(channels.CHANNELS, 0)
    encoder = msgspec.json.Encoder()
    for t_ns, topic, message in _messages(recording):
        data = encoder.encode(message)
        writer.add_message(channel[topic], t_ns, data, t_ns, sequence[topic])
        sequence[topic] += 1
    writer.finish()  # type: ignore[no-untyped-call]
    return stream.getvalue()


def _register(writer: Writer, topic: str) -> int:
    channel = channels.CHANNELS[topic]
    schema = msgspec.json.encode(channels.json_schema(channel.message, channel.schema))
    number = writer.register_schema(channel.schema, "jsonschema", schema)
    return int(writer.register_channel(topic, "json", number))


def _messages(recording: Recording) -> Iterator[_Message]:
    begin_ns = int(recording.t_ns[0])
    begin = time_of(begin_ns)
    yield begin_ns, channels.CONTEXT, context_record(recording.start, begin)
    yield begin_ns, channels.STEPS, steps_record(recording.steps, begin)
    step_messages = _said(recording.steps, begin_ns)
    next_said = next(step_messages, None)
    carries = [
        "" if i == NOTHING else recording.start.objects[i].id for i in carried(recording).tolist()
    ]
    shown = None
    transforms = _transforms(recording)
    robots = _robots(recording, carries)
    for t_ns, on_forks in zip(recording.t_ns.tolist(), carries, strict=True):
        while next_said is not None and next_said[0] <= t_ns:
            yield next_said
            next_said = next(step_messages, None)
        moved, robot = next(transforms), next(robots)
        if moved:
            yield t_ns, channels.TF, FrameTransforms(moved)
        if on_forks != shown:
            drawn = entities(recording.start, on_forks, robot.timestamp)
            yield t_ns, channels.SCENE, SceneUpdate((), drawn)
            shown = on_forks
        yield t_ns, channels.ROBOT, robot
    if next_said is not None:
        yield next_said
        yield from step_messages


def _transforms(recording: Recording) -> Iterator[tuple[FrameTransform, ...]]:
    """Yield at every moment the frames that moved since the one before; every second all."""
    site, forks = frames(recording.start)
    agent = recording.start.agent_id
    names = [item.id for item in recording.start.objects]
    # Bits are compared, so that a log distinguishes -0.0 from 0.0.
    poses = np.concatenate((recording.position, recording.orientation), axis=2)
    moved = np.asarray(_changed(poses).any(axis=2))
    lifted = _changed(recording.fork_height_m)
    second = recording.t_ns // NS_PER_S
    whole = np.diff(second, prepend=second[0] - 1) > 0
    moved[whole], lifted[whole] = True, True
    unturned = Quaternion(0.0, 0.0, 0.0, 1.0)
    for t_ns, which, of_all, up, height in zip(
        recording.t_ns.tolist(),
        moved,
        poses,
        lifted.tolist(),
        recording.fork_height_m.tolist(),
        strict=True,
    ):
        timestamp = time_of(t_ns)
        transforms = [
            FrameTransform(timestamp, site, names[i], Vector3(x, y, z), Quaternion(qx, qy, qz, qw))
            for i, (x, y, z, qw, qx, qy, qz) in zip(
                np.flatnonzero(which).tolist(), of_all[which].tolist(), strict=True
            )
        ]
        if up:
            lift = Vector3(0.0, 0.0, height)
            transforms.append(FrameTransform(timestamp, agent, forks, lift, unturned))
        yield tuple(transforms)


def _changed(values: FloatArray) -> BoolArray:
    bits = np.ascontiguousarray(values).view(np.uint64)
    changed = np.ones(bits.shape, dtype=np.bool_)
    changed[1:] = bits[1:] != bits[:-1]
    return changed


def _robots(recording: Recording, carries: list[str]) -> Iterator[RobotRecord]:
    robot = [item.id for item in recording.start.objects].index(recording.start.agent_id)
    position, orientation = recording.position[:, robot], recording.orientation[:, robot]
    speed = _speed(recording.t_s, position, heading(orientation))
    for t_ns, xyz, (w, x, y, z), v, height, on_forks in zip(
        recording.t_ns.tolist(),
        position.tolist(),
        orientation.tolist(),
        speed.tolist(),
        recording.fork_height_m.tolist(),
        carries,
        strict=True,
    ):
        pose = Pose(Vector3(*xyz), Quaternion(x, y, z, w))
        yield RobotRecord(time_of(t_ns), pose, v, height, on_forks)


def _speed(t: FloatArray, position: FloatArray, yaw: FloatArray) -> FloatArray:
    """Return the speed ahead in metres per second, shape (n,)."""
    if len(t) == 1:
        return np.zeros(1)
    vx, vy = np.gradient(position[:, 0], t), np.gradient(position[:, 1], t)
    speed: FloatArray = vx * np.cos(yaw) + vy * np.sin(yaw)
    return speed


def _said(steps: tuple[Step, ...], begin_ns: int) -> Iterator[_Message]:
    """Yield lines on the robot's actions, in the order of their times."""
    lines: list[tuple[int, str]] = []
    for step in steps:
        text = " ".join((step.action, *(f"{name}={value}" for name, value in step.arguments)))
        for seconds, what in ((step.start_s, "begins"), (step.end_s, "is done")):
            lines.append((max(round(seconds * NS_PER_S), begin_ns), f"{text}: {what}"))
    for t_ns, line in sorted(lines, key=lambda item: item[0]):
        yield t_ns, channels.ACTIONS, Log(time_of(t_ns), INFO, line, "robot", "", 0)


COLOURS = {
    "forklift": (0.95, 0.62, 0.07),
    "tire-pallet": (0.25, 0.25, 0.28),
    "box-pallet": (0.72, 0.53, 0.33),
    "crate": (0.62, 0.44, 0.24),
    "trailer": (0.45, 0.52, 0.60),
    "truck": (0.75, 0.18, 0.18),
    "shelf": (0.20, 0.38, 0.65),
    "barrel": (0.10, 0.45, 0.50),
    "person": (0.35, 0.65, 0.30),
    "cone": (1.0, 0.42, 0.05),
}
"""Red, green and blue of kinds of objects."""
GREY = (0.6, 0.6, 0.62)
PLACE_COLOUR = Color(0.15, 0.55, 0.85, 0.9)
CARRIED_COLOUR = Color(0.2, 0.85, 0.3, 1.0)
LABEL_COLOUR = Color(1.0, 1.0, 1.0, 1.0)
OPACITY = 0.7
LABEL_M = 0.35
OUTLINE_M = 0.04

_UNTURNED = Quaternion(0.0, 0.0, 0.0, 1.0)
_HERE = Pose(Vector3(0.0, 0.0, 0.0), _UNTURNED)
_FOREVER = Time(0, 0)
_EMPTY = SceneEntity(_FOREVER, "", "", _FOREVER, True, (), (), (), (), (), (), (), (), ())


def frames(context: Context) -> tuple[str, str]:
    """Return the names of the site's frame and the forks', which no object has."""
    ids = {item.id for item in context.objects}

    def free(name: str) -> str:
        return name if name not in ids else free(f"{name}_")

    return free("world"), free(f"{context.agent_id}/forks")


def entities(context: Context, carries: str, timestamp: Time) -> tuple[SceneEntity, ...]:
    """Return all drawn entities; the outline of the load, whose id is `carries`, is lit up."""
    site, forks = frames(context)
    return (
        *(_place(place, i, site, timestamp) for i, place in enumerate(context.places)),
        *(_object(item, item.id == carries, timestamp) for item in context.objects),
        _forks(forks, timestamp),
    )


def _object(item: PhysicalObject, carried: bool, timestamp: Time) -> SceneEntity:
    paints = [PAINTS[colour] for colour in item.colours]
    red, green, blue = paints[0] if paints else COLOURS.get(kind_of(item.labels).name, GREY)
    shape, pose = shape_of(item), item.trajectory
    xy = rotate(item.prism.xy - pose.xyz[0, :2], np.full(len(item.prism.xy), -pose.yaw[0]))
    outline = CARRIED_COLOUR if carried else Color(red / 2, green / 2, blue / 2, 1.0)
    x, y, _ = shape.middle.tolist()
    return _entity(
        item.id,
        item.id,
        timestamp,
        metadata=(KeyValuePair("labels", " ".join(item.labels)),),
        cubes=(_cube(shape.middle, shape.size, Color(red, green, blue, OPACITY)),),
        lines=_outlines(xy, float(shape.low[2]), float(shape.high[2]), outline),
        texts=(_label(" ".join(item.labels), x, y, float(shape.high[2]) + LABEL_M),),
    )


def _place(place: Place, number: int, site: str, timestamp: Time) -> SceneEntity:
    prism = place.prism
    x, y = ((prism.xy.min(axis=0) + prism.xy.max(axis=0)) / 2).tolist()
    return _entity(
        site,
        f"place {number}",
        timestamp,
        metadata=(KeyValuePair("name", place.name),),
        lines=_outlines(prism.xy, prism.z_min, prism.z_max, PLACE_COLOUR),
        texts=(_label(place.name, x, y, prism.z_min + LABEL_M),) if place.name else (),
    )


def _forks(frame: str, timestamp: Time) -> SceneEntity:
    size = np.array([FORK_LENGTH, FORK_WIDTH, FORK_THICKNESS])
    colour = Color(*GREY, 1.0)
    return _entity(
        frame,
        frame,
        timestamp,
        cubes=tuple(
            _cube(np.array([HEEL_X + FORK_LENGTH / 2, y, -FORK_THICKNESS / 2]), size, colour)
            for y in (-FORK_Y, FORK_Y)
        ),
    )


def _entity(frame: str, name: str, timestamp: Time, **drawn: Any) -> SceneEntity:
    """Return an entity that stays in its frame until replaced, with all required fields."""
    return msgspec.structs.replace(_EMPTY, timestamp=timestamp, frame_id=frame, id=name, **drawn)


def _cube(middle: FloatArray, size: FloatArray, colour: Color) -> CubePrimitive:
    return CubePrimitive(
        Pose(Vector3(*middle.tolist()), _UNTURNED), Vector3(*size.tolist()), colour
    )


def _outlines(
    xy: FloatArray, z_min: float, z_max: float, colour: Color
) -> tuple[LinePrimitive, ...]:
    """Return the edges of a prism."""
    low, high = ([Vector3(x, y, z) for x, y in xy.tolist()] for z in (z_min, z_max))
    upright = [corner for pair in zip(low, high, strict=True) for corner in pair]
    return tuple(
        LinePrimitive(kind, _HERE, OUTLINE_M, False, tuple(points), colour, (), ())
        for kind, points in ((LINE_LOOP, low), (LINE_LOOP, high), (LINE_LIST, upright))
    )


def _label(text: str, x: float, y: float, z: float) -> TextPrimitive:
    return TextPrimitive(
        Pose(Vector3(x, y, z), _UNTURNED), True, LABEL_M, False, LABEL_COLOUR, text
    )
