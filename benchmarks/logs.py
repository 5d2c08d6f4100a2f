"""Writing logs against Foxglove's protobuf messages by mcap's own support.

``python -m benchmarks.logs`` writes the transforms of a bundled log. Processor time. The peer is
``mcap-protobuf-support``.
"""

from __future__ import annotations

import io
import json
import time
from collections.abc import Callable
from importlib.util import find_spec
from typing import Any

import msgspec
from mcap.reader import make_reader
from mcap.writer import Writer

from benchmarks.timing import best_of, row
from corpus_tools.logs.channels import TF
from corpus_tools.logs.foxglove import FrameTransforms
from corpus_tools.runtime.shipped import bundled

LOG = bundled()["warehouse"] / "logs" / "dock_pick_up_tires.mcap"
REPEATS = 100


def main() -> None:
    content = LOG.read_bytes()
    decode, encode = msgspec.json.Decoder(FrameTransforms).decode, msgspec.json.Encoder().encode
    transforms = [
        (message.log_time, decode(message.data))
        for _, _, message in make_reader(io.BytesIO(content)).iter_messages(topics=[TF])
    ] * REPEATS
    builtin = [(t, msgspec.to_builtins(message)) for t, message in transforms]
    actions: dict[str, Callable[[], None]] = {
        "ours": lambda: _write_json([(t, encode(m)) for t, m in transforms]),
        "json.dumps": lambda: _write_json([(t, json.dumps(m).encode()) for t, m in builtin]),
    }
    if find_spec("mcap_protobuf"):
        published = _published(transforms)
        actions["mcap-protobuf-support"] = lambda: _write_protobuf(published)
    taken = best_of(actions, clock=time.process_time)
    ours = taken.pop("ours")[0]
    ratios = (f"{ours / seconds:.2f} of {name}" for name, (seconds, _) in taken.items())
    row("writing a log", f"{len(transforms) / ours:,.0f} messages/s", "; ".join(ratios))


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

    result = []
    for t, message in messages:
        frames = [msgspec.to_builtins(one) | {"timestamp": None} for one in message.transforms]
        published = Published(transforms=frames)
        for frame in published.transforms:
            frame.timestamp.FromNanoseconds(t)
        result.append((t, published))
    return result


def _write_protobuf(messages: list[tuple[int, Any]]) -> None:
    from mcap_protobuf.writer import Writer as ProtobufWriter  # noqa: PLC0415 - may be missing

    with ProtobufWriter(io.BytesIO()) as writer:
        for t, message in messages:
            writer.write_message(topic=TF, message=message, log_time=t, publish_time=t)


if __name__ == "__main__":
    main()
