"""TFRecord files and the examples in them, without TensorFlow.

A record has its length, a checksum of the length, its content, and a checksum of that (CRC-32C,
masked). Content is a ``tf.train.Example`` or ``tf.train.SequenceExample``; as both have their
features in the same field, an example is read as a sequence example without feature lists.
"""

from __future__ import annotations

import functools
import os
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

from corpus_tools.episodes.films import RESTORE
from corpus_tools.runtime.extras import import_extra
from g3.errors import FormatError
from g3.storage import regular_file

MOST_BYTES = 1 << 30
"""Bytes of a record."""
EXTRA = "rlds"
_LENGTH, _CHECKSUM = struct.Struct("<Q"), struct.Struct("<I")
_HEAD = _LENGTH.size + _CHECKSUM.size
_GZIP = b"\x1f\x8b"


def check_installed() -> None:
    """Raise a FormatError unless google-crc32c and protobuf are installed."""
    masked_checksum(b"")
    _sequence_example()


def records(file: Path) -> Iterator[bytes]:
    """Yield the content of the records of a file."""
    try:
        stream = regular_file.opened(file)
    except OSError as error:
        fix = "download all shards of the dataset"
        raise FormatError(
            f"the file can't be read: {error.strerror}", where=str(file), fix=fix
        ) from (error)
    with stream:
        size, number = os.fstat(stream.fileno()).st_size, 0
        while stream.tell() < size:
            yield _record(stream, size, f"{file}, record {number}")
            number += 1


def _record(stream: BinaryIO, size: int, where: str) -> bytes:
    head = stream.read(_HEAD)
    if head.startswith(_GZIP) and not _fits(head):
        fix = "uncompress the files: gunzip -S ''"
        raise FormatError("the file is compressed (gzip)", where=where, fix=fix)
    if len(head) < _HEAD:
        raise FormatError("the file is cut off", where=where, fix=RESTORE)
    if not _fits(head):
        what = "the checksum of the length is wrong: the file is damaged, or no TFRecord"
        raise FormatError(what, where=where, fix=RESTORE)
    (length,) = _LENGTH.unpack_from(head)
    if stream.tell() + length + _CHECKSUM.size > size:
        what = f"the file is cut off: the record has {length} bytes"
        raise FormatError(what, where=where, fix=RESTORE)
    if length > MOST_BYTES:
        what = f"the record has {length} bytes, and at most {MOST_BYTES} are read"
        raise FormatError(what, where=where, fix="cut the episode into shorter ones")
    content = stream.read(length)
    if _CHECKSUM.pack(masked_checksum(content)) != stream.read(_CHECKSUM.size):
        raise FormatError("the checksum of the content is wrong", where=where, fix=RESTORE)
    return content


def _fits(head: bytes) -> bool:
    length = head[: _LENGTH.size]
    return _CHECKSUM.pack(masked_checksum(length)) == head[_LENGTH.size :]


def framed(content: bytes) -> bytes:
    """Return a record with its length and checksums."""
    length = _LENGTH.pack(len(content))
    checks = [_CHECKSUM.pack(masked_checksum(part)) for part in (length, content)]
    return b"".join((length, checks[0], content, checks[1]))


def masked_checksum(content: bytes) -> int:
    """Return the CRC-32C of bytes, rotated and shifted as in TFRecord files."""
    crc32c = import_extra("google_crc32c", EXTRA, "TFRecord files are read")
    checksum = int(crc32c.value(content))
    return (((checksum >> 15) | (checksum << 17)) + 0xA282EAD8) & 0xFFFFFFFF


def example_of(content: bytes, where: str) -> Any:
    """Decode an example, as a message of protobuf with ``context`` and ``feature_lists``."""
    example = _sequence_example()()
    try:
        example.ParseFromString(content)
    except Exception as error:  # of a class that depends on protobuf's implementation
        raise FormatError(f"the record is no example: {error}", where=where, fix=RESTORE) from error
    return example


def values_of(example: Any, name: str) -> list[Any]:
    """Return the values of a feature, those of a feature list one after the other."""
    features = [example.context.feature[name]] if name in example.context.feature else []
    lists = example.feature_lists.feature_list
    features += lists[name].feature if name in lists else []
    values: list[Any] = []
    for feature in features:
        kind = feature.WhichOneof("kind")
        values += getattr(feature, kind).value if kind else []
    return values


@functools.cache
def _sequence_example() -> Any:
    """Return the class of messages, from TensorFlow's ``example.proto`` and ``feature.proto``."""
    purpose = "TFRecord files are read"
    descriptor_pb2 = import_extra("google.protobuf.descriptor_pb2", EXTRA, purpose)
    pool = import_extra("google.protobuf.descriptor_pool", EXTRA, purpose).DescriptorPool()
    factory = import_extra("google.protobuf.message_factory", EXTRA, purpose)
    kinds = descriptor_pb2.FieldDescriptorProto
    file = descriptor_pb2.FileDescriptorProto(
        name="g3/example.proto", package="g3", syntax="proto3"
    )

    def message(owner: Any, name: str) -> Any:
        return owner.add(name=name)

    def field(owner: Any, name: str, number: int, kind: str, *, is_repeated: bool = False) -> Any:
        label = kinds.LABEL_REPEATED if is_repeated else kinds.LABEL_OPTIONAL
        one = owner.field.add(name=name, number=number, label=label)
        if kind.startswith("."):
            one.type, one.type_name = kinds.TYPE_MESSAGE, kind
        else:
            one.type = getattr(kinds, f"TYPE_{kind.upper()}")
        return one

    def mapping(owner: Any, name: str, entry: str, kind: str) -> None:
        nested = message(owner.nested_type, entry)
        nested.options.map_entry = True
        field(nested, "key", 1, "string")
        field(nested, "value", 2, kind)
        field(owner, name, 1, f".g3.{owner.name}.{entry}", is_repeated=True)

    types = file.message_type
    for name, kind in (("BytesList", "bytes"), ("FloatList", "float"), ("Int64List", "int64")):
        field(message(types, name), "value", 1, kind, is_repeated=True)
    feature = message(types, "Feature")
    feature.oneof_decl.add(name="kind")
    for number, kind in enumerate(("Bytes", "Float", "Int64"), start=1):
        field(feature, f"{kind.lower()}_list", number, f".g3.{kind}List").oneof_index = 0
    mapping(message(types, "Features"), "feature", "FeatureEntry", ".g3.Feature")
    field(message(types, "FeatureList"), "feature", 1, ".g3.Feature", is_repeated=True)
    mapping(message(types, "FeatureLists"), "feature_list", "FeatureListEntry", ".g3.FeatureList")
    example = message(types, "SequenceExample")
    field(example, "context", 1, ".g3.Features")
    field(example, "feature_lists", 2, ".g3.FeatureLists")
    pool.Add(file)
    return factory.GetMessageClass(pool.FindMessageTypeByName("g3.SequenceExample"))
