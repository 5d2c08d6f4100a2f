"""Putting people's language into copies of recordings, as a topic of its own.

Each text is a message of the topic ``/language`` at the time when it begins. In ROS's recordings
it is a ``std_msgs/msg/String`` with JSON, in other MCAP files JSON itself: ``style``, ``start_s``,
``content`` and maybe ``camera`` and ``reply``. All other messages stay as they are.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import msgspec
from mcap.records import Attachment, Channel, Header, Message, Metadata, Schema
from mcap.writer import Writer

from corpus_tools.episodes.bag_reading import Recording, content_of, mcap_records, opened
from corpus_tools.episodes.copies import LanguageCopy, records
from corpus_tools.episodes.rosbag import Recordings
from corpus_tools.runtime.extras import import_extra
from g3.errors import FormatError

TOPIC = "/language"
STRING = "std_msgs/msg/String"
JSON_SCHEMA = {
    "type": "object",
    "properties": {
        "style": {"type": "string"},
        "start_s": {"type": "number"},
        "content": {"type": "string"},
        "camera": {"type": "string"},
        "reply": {"type": "string"},
    },
}
_NS = 1e9
_FIX = "convert it first: ros2 bag convert, or rosbags-convert for ROS 1; and import that"


def write_recordings(source: Recordings, copy: LanguageCopy) -> list[str]:
    """Write copies of the recordings with language, and return a note about the others."""
    folder = source.path if source.path not in source.files else source.path.parent
    there = {i for i in range(len(source.files)) if i in copy.starts}
    with copy.writing(source.path) as (scratch, files):
        copy.check_written(source.path, there)
        written = there & copy.language.keys()
        for index in sorted(written):
            path, start_ns = source.files[index], copy.starts[index]
            texts = [
                (start_ns + round(one["start_s"] * _NS), msgspec.json.encode(one))
                for one in records(copy.language[index].said)
            ]
            new = scratch / path.relative_to(folder)
            if new.suffix == ".db3":  # of which the copy is a bag's folder
                new = new.with_suffix("")
            new.parent.mkdir(parents=True, exist_ok=True)
            with opened(path) as recording, content_of(path):
                _write(recording, new, texts)
            every = sorted(new.rglob("*")) if new.is_dir() else [new]
            files |= {file.relative_to(scratch).as_posix(): file for file in every}
    others = len(source.files) - len(written)
    return [f"{others} recordings without language aren't copied"] if others else []


def _write(recording: Recording, new: Path, texts: list[tuple[int, bytes]]) -> None:
    is_ros1 = recording.path.suffix == ".bag"
    if is_ros1 or len(recording.files) > 1 or (recording.files and recording.path.is_dir()):
        what = "language is written into single MCAP files and into ROS 2 bags in SQLite alone"
        raise FormatError(what, where=str(recording.path), fix=_FIX)
    if recording.files and not recording.has_compressed_messages:
        _write_mcap(recording.files[0], new, texts)
    elif recording.files:
        what = "the messages of the MCAP file are compressed one by one"
        raise FormatError(what, where=str(recording.path), fix=_FIX)
    else:
        _write_bag(recording, new, texts)


def _string(text: bytes) -> bytes:
    """Return a ``std_msgs/msg/String`` as CDR."""
    return b"\0\1\0\0" + (len(text) + 1).to_bytes(4, "little") + text + b"\0"


def _free_topic(topics: set[str]) -> str:
    numbered = (f"{TOPIC}_{number}" for number in range(2, len(topics) + 3))
    return next(name for name in (TOPIC, *numbered) if name not in topics)


def _write_mcap(file: Path, new: Path, texts: list[tuple[int, bytes]]) -> None:
    """Copy an MCAP file, with the texts among the messages in the order of times."""
    every = mcap_records(file, with_messages=True)
    header = next(every, None)
    is_ros = isinstance(header, Header) and header.profile == "ros2"
    topics = {r.topic for r in mcap_records(file, with_messages=False) if isinstance(r, Channel)}
    schemas: dict[int, int] = {0: 0}
    channels: dict[int, int] = {}
    left = iter(texts)
    with new.open("wb") as stream:
        writer = Writer(stream)
        writer.start(header.profile if isinstance(header, Header) else "", library="corpus-tools")
        schema = (
            writer.register_schema(STRING, "ros2msg", b"string data\n")
            if is_ros
            else writer.register_schema("Language", "jsonschema", msgspec.json.encode(JSON_SCHEMA))
        )
        encoding = "cdr" if is_ros else "json"
        channel = writer.register_channel(_free_topic(topics), encoding, schema)
        add = partial(_add_text, writer, channel, is_ros=is_ros)
        following = next(left, None)
        for record in every:
            if isinstance(record, Schema) and record.id not in schemas:
                schemas[record.id] = writer.register_schema(
                    record.name, record.encoding, record.data
                )
            elif isinstance(record, Channel) and record.id not in channels:
                channels[record.id] = writer.register_channel(
                    record.topic, record.message_encoding, schemas[record.schema_id],
                    record.metadata,
                )  # fmt: skip
            elif isinstance(record, Message):
                while following is not None and following[0] <= record.log_time:
                    add(*following)
                    following = next(left, None)
                writer.add_message(
                    channels[record.channel_id], record.log_time, record.data,
                    record.publish_time, record.sequence,
                )  # fmt: skip
            elif isinstance(record, Attachment):
                writer.add_attachment(
                    record.create_time, record.log_time, record.name, record.media_type, record.data
                )
            elif isinstance(record, Metadata):
                writer.add_metadata(record.name, record.metadata)
        for one in (following, *left) if following is not None else ():
            add(*one)
        writer.finish()  # type: ignore[no-untyped-call]


def _add_text(writer: Writer, channel: int, time_ns: int, text: bytes, *, is_ros: bool) -> None:
    writer.add_message(channel, time_ns, _string(text) if is_ros else text, time_ns)


def _write_bag(recording: Recording, new: Path, texts: list[tuple[int, bytes]]) -> None:
    """Copy a ROS 2 bag, in SQLite and uncompressed."""
    purpose = "ROS bags are written"
    rosbag2 = import_extra("rosbags.rosbag2", "ros", purpose)
    types = import_extra("rosbags.typesys", "ros", purpose)
    store = types.get_typestore(types.Stores.ROS2_HUMBLE)
    with recording.reader() as reader, rosbag2.Writer(new, version=9) as writer:
        connections: dict[Any, Any] = {}
        for one in reader.connections:
            # Old bags have no definitions of their types; the reader knows the usual ones.
            definition = {"typestore": reader.typestore}
            if one.msgdef.data and one.digest:
                definition = {"msgdef": one.msgdef.data, "rihs01": one.digest}
            connections[one.id, id(one.owner)] = writer.add_connection(
                one.topic,
                one.msgtype,
                serialization_format=one.ext.serialization_format,
                offered_qos_profiles=one.ext.offered_qos_profiles,
                **definition,
            )
        topic = _free_topic({one.topic for one in reader.connections})
        said = writer.add_connection(topic, STRING, typestore=store)
        left = iter(texts)
        following = next(left, None)
        for connection, time_ns, content in reader.messages():
            while following is not None and following[0] <= time_ns:
                writer.write(said, following[0], _string(following[1]))
                following = next(left, None)
            data = recording.plain(content)
            writer.write(connections[connection.id, id(connection.owner)], time_ns, data)
        for time_ns, text in (following, *left) if following is not None else ():
            writer.write(said, time_ns, _string(text))
