"""Writing and reading logs, against Foxglove's protobuf messages through mcap's own support.

Times are of the processor: none of it waits for anything but other programs.
"""

from __future__ import annotations

import io
import json
import tempfile
import time
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from mcap.reader import make_reader
from mcap.writer import Writer

from benchmarks.timing import best_of, compare, heading, show
from corpus_tools.logs.channels import TF
from corpus_tools.logs.foxglove import FrameTransforms
from corpus_tools.logs.log_reading import read_log
from corpus_tools.logs.log_writing import to_bytes, write_log
from corpus_tools.world.state.recording import NS_PER_S, Recording, upright
from g3.groundings import Context, PhysicalObject, Prism, Trajectory

SECONDS, RATE_HZ, OBJECTS, MOVING = 400, 25, 8, 2


def made_up() -> Recording:
    """A recording as long as the paper's, in which the robot and a load move all the time."""
    square = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
    objects = tuple(
        PhysicalObject(
            f"object-{i}",
            ("forklift",) if i == 0 else ("tire", "pallet"),
            Prism(square + np.array([3.0 * i, 0.0]), 0.0, 0.7),
            Trajectory(np.zeros(1), np.array([[3.0 * i, 0.0, 0.0]]), np.zeros(1)),
        )
        for i in range(OBJECTS)
    )
    t_ns = np.arange(SECONDS * RATE_HZ) * (NS_PER_S // RATE_HZ)
    angle = t_ns / NS_PER_S / 10
    position = np.zeros((len(t_ns), OBJECTS, 3))
    position[:, :, 0] = 3.0 * np.arange(OBJECTS)
    yaw = np.zeros((len(t_ns), OBJECTS))
    for i in range(MOVING):
        position[:, i, :2] = np.column_stack((np.cos(angle), np.sin(angle))) * (4 + i)
        yaw[:, i] = angle + np.pi / 2
    start = Context("made up", objects, (), "object-0")
    return Recording(start, t_ns, position, upright(yaw), 0.4 + 0.3 * np.sin(angle))


def run() -> None:
    recording = made_up()
    content = to_bytes(recording, name="made up", metadata={})
    summary = make_reader(io.BytesIO(content)).get_summary()
    if summary is None or summary.statistics is None:
        raise ValueError("the log has no summary")
    count = summary.statistics.message_count
    heading(f"Logs: {SECONDS} s at {RATE_HZ} Hz, {OBJECTS} objects, {count} messages")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log.mcap"
        times = best_of(
            {
                "write": lambda: write_log(recording, path, name="made up", metadata={}),
                "read": lambda: read_log(path),
            },
            clock=time.process_time,
        )
    show("write", count / times["write"][0], "messages/s", f"{len(content) / 1e6:.2f} MB")
    show("read", count / times["read"][0], "messages/s")
    _compare(content)


def _compare(content: bytes) -> None:
    """Encode and write the same transforms, from messages that each encoder takes."""
    decode = msgspec.json.Decoder(FrameTransforms).decode
    transforms = [
        (message.log_time, decode(message.data))
        for _, _, message in make_reader(io.BytesIO(content)).iter_messages(topics=[TF])
    ]
    builtin = [(t, msgspec.to_builtins(message)) for t, message in transforms]
    encode = msgspec.json.Encoder().encode
    actions = {
        "ours": lambda: _write_json([(t, encode(m)) for t, m in transforms]),
        "json.dumps": lambda: _write_json([(t, json.dumps(m).encode()) for t, m in builtin]),
    }
    try:
        import foxglove_schemas_protobuf  # noqa: F401, PLC0415 - may be missing
        import mcap_protobuf  # noqa: F401, PLC0415 - may be missing
    except ImportError:
        print("  (no comparison with protobuf: mcap-protobuf-support is not installed)")
    else:
        published = _published(transforms)
        actions["mcap-protobuf-support"] = lambda: _write_protobuf(published)
    taken = best_of(actions, clock=time.process_time)
    times = {name: seconds for name, (seconds, _) in taken.items()}
    for name, seconds in times.items():
        show(f"write the transforms alone, {name}", len(transforms) / seconds, "messages/s")
        if name != "ours":
            compare("writing logs", name, times["ours"] / seconds, "compressing with zstd")


def _write_json(messages: list[tuple[int, bytes]]) -> None:
    writer = Writer(io.BytesIO())
    writer.start()
    channel = writer.register_channel(TF, "json", 0)
    for t, data in messages:
        writer.add_message(channel, t, data, t)
    writer.finish()  # type: ignore[no-untyped-call]


def _published(messages: list[tuple[int, FrameTransforms]]) -> list[tuple[int, Any]]:
    from foxglove_schemas_protobuf.FrameTransforms_pb2 import (  # noqa: PLC0415 - may be missing
        FrameTransforms as Published,
    )

    def published(t: int, message: FrameTransforms) -> Any:
        result = Published()
        for ours in message.transforms:
            frame = result.transforms.add(
                parent_frame_id=ours.parent_frame_id, child_frame_id=ours.child_frame_id
            )
            frame.timestamp.FromNanoseconds(t)
            for name in ("translation", "rotation"):
                for axis, value in msgspec.structs.asdict(getattr(ours, name)).items():
                    setattr(getattr(frame, name), axis, value)
        return result

    return [(t, published(t, message)) for t, message in messages]


def _write_protobuf(messages: list[tuple[int, Any]]) -> None:
    from mcap_protobuf.writer import Writer as ProtobufWriter  # noqa: PLC0415 - may be missing

    with ProtobufWriter(io.BytesIO()) as writer:
        for t, message in messages:
            writer.write_message(topic=TF, message=message, log_time=t, publish_time=t)


if __name__ == "__main__":
    run()
