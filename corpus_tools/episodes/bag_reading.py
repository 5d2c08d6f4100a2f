"""Messages of recordings: MCAP files, ROS 2 bags (MCAP or SQLite) and ROS 1 bags.

Chunks, messages and files may be compressed. Each is uncompressed to a limit, not to what headers
say: an MCAP chunk to its stated size, a file to half of what is free on the disk.
"""

from __future__ import annotations

import base64
import shutil
import tempfile
from bz2 import BZ2Decompressor
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path, PurePath
from typing import Any, BinaryIO

import lz4.frame
import msgspec
import yaml
import zstandard
from mcap.reader import SeekingReader
from mcap.records import Channel, Chunk, Message, Schema
from mcap.stream_reader import StreamReader, breakup_chunk

from corpus_tools.runtime.extras import import_extra
from g3.errors import CorpusError, FormatError
from g3.storage import regular_file

ENDINGS = (".mcap", ".bag", ".db3")
BAG = "metadata.yaml"
"""The file that makes a folder a ROS 2 bag."""
MOST_CHUNK = 1 << 30
MOST_METADATA = 16 << 20
AT_ONCE = 1 << 20
_INFORMATION = "rosbag2_bagfile_information"
FIX = "copy the recording once more, or recover it: mcap recover FILE, ros2 bag reindex FOLDER"
_FIX_COMPRESSED = "write it uncompressed, or compressed by zstd: ros2 bag convert"


@dataclass(frozen=True, slots=True)
class Published:
    """A message of a topic; its content is decoded when it is needed."""

    topic: str
    time_ns: int
    content: Callable[[], Any]


@dataclass(frozen=True, slots=True)
class Recording:
    """A file or a bag, whose files are uncompressed.

    Parameters
    ----------
    path
        The given file or folder, for errors.
    files
        MCAP files that are read one after the other; without any, ROS's `bag` is read.
    """

    path: Path
    files: tuple[Path, ...]
    bag: Path
    has_compressed_messages: bool = False

    def types(self) -> dict[str, str]:
        """Return the types of messages of each topic; their last names."""
        with content_of(self.path):
            if self.files:
                return {topic: k for file in self.files for topic, k in _mcap_types(file).items()}
            with self.reader() as reader:
                return {c.topic: _last_name(c.msgtype) for c in reader.connections}

    def messages(self, topics: Collection[str]) -> Iterator[Published]:
        """Yield the messages of some topics, nearly in the order of their times."""
        with content_of(self.path):
            for file in self.files:
                yield from _mcap_messages(file, topics, self.plain)
            if not self.files:
                yield from self._bag_messages(topics)

    def plain(self, content: bytes) -> bytes:
        """Return the content of a message, uncompressed if need be."""
        if not self.has_compressed_messages:
            return content
        return _at_most(zstandard.ZstdDecompressor().stream_reader(content).read)

    def _bag_messages(self, topics: Collection[str]) -> Iterator[Published]:
        with self.reader() as reader:
            wanted = [c for c in reader.connections if c.topic in topics]
            if not wanted:
                return
            # The reader forgets its types when it is closed, and messages are decoded later on.
            types = reader.typestore
            decode = types.deserialize_cdr if reader.is2 else types.deserialize_ros1
            for connection, time_ns, content in reader.messages(connections=wanted):
                of_message = partial(_decoded, decode, connection.msgtype, self.plain, content)
                yield Published(connection.topic, time_ns, of_message)

    @contextmanager
    def reader(self) -> Iterator[Any]:
        """Open the bag with a reader of rosbags."""
        highlevel = import_extra("rosbags.highlevel", "ros", "ROS bags are read")
        types = import_extra("rosbags.typesys", "ros", "ROS bags are read")
        usual = types.get_typestore(types.Stores.ROS2_HUMBLE)
        with ExitStack() as stack:
            reader = stack.enter_context(highlevel.AnyReader([self.bag], default_typestore=usual))
            for one in () if reader.is2 else reader.readers:
                one.chunks = {at: _bounded(chunk) for at, chunk in one.chunks.items()}
            yield reader


def _decoded(
    decode: Callable[[bytes, str], Any],
    kind: str,
    plain: Callable[[bytes], bytes],
    content: bytes,
) -> Any:
    return decode(plain(content), kind)


def _bounded(chunk: Any) -> Any:
    """Return a chunk of a ROS 1 bag that is uncompressed to `MOST_CHUNK` bytes and no further."""
    reader = import_extra("rosbags.rosbag1.reader", "ros", "ROS bags are read")
    limited = {
        reader.decompressors["bz2"]: lambda data: _at_most(
            partial(BZ2Decompressor().decompress, data)
        ),
        reader.decompressors["lz4"]: lambda data: _at_most(
            partial(lz4.frame.LZ4FrameDecompressor().decompress, data)
        ),
    }
    return chunk._replace(decompressor=limited.get(chunk.decompressor, chunk.decompressor))


def _at_most(read: Callable[[int], bytes]) -> bytes:
    """Return all that is read; a ValueError if it has more than `MOST_CHUNK` bytes."""
    content = read(MOST_CHUNK + 1)
    if len(content) > MOST_CHUNK:
        raise ValueError(f"uncompressed, a part has more than {MOST_CHUNK} bytes")
    return content


def recordings_in(path: Path) -> Iterator[Path]:
    """Yield the recordings in a folder, or the path itself if it is a recording."""
    if path.suffix in ENDINGS and path.is_file():
        yield path
    elif (path / BAG).is_file():
        of_mcap = sorted(path.glob("*.mcap"))
        yield of_mcap[0] if len(of_mcap) == 1 else path
    elif path.is_dir():
        for child in sorted(path.iterdir()):
            is_linked_folder = child.is_symlink() and child.is_dir()  # maybe in a circle
            if not (child.name.startswith(".") or is_linked_folder):
                yield from recordings_in(child)


@contextmanager
def content_of(file: Path) -> Iterator[None]:
    """Turn any error that damaged content causes into a FormatError that names the recording."""
    try:
        yield
    except CorpusError:
        raise
    # A byte out of place makes the parsers fail in any way there is.
    except Exception as error:
        lines = str(error).splitlines() or [type(error).__name__]
        what = f"the recording is cut off or damaged: {lines[0]:.200}"
        raise FormatError(what, where=str(file), fix=FIX) from error


@contextmanager
def opened(path: Path) -> Iterator[Recording]:
    """Open a recording; compressed files are uncompressed into a folder that goes afterwards."""
    folder = path if path.is_dir() else path.parent
    about = _metadata(folder) if (folder / BAG).is_file() else {}
    mode = str(about.get("compression_mode") or "none").lower()
    if path.is_file() and mode != "message":
        mode = "none"  # an uncompressed file beside those of the bag
    form = str(about.get("compression_format") or "")
    if mode not in ("none", "file", "message") or (mode != "none" and form != "zstd"):
        what = f"the bag is compressed by {form or mode!r:.40}, which isn't read"
        raise FormatError(what, where=str(path), fix=_FIX_COMPRESSED)
    if path.is_file():
        files = (path,) if path.suffix == ".mcap" else ()
        yield Recording(path, files, path, mode == "message")
        return
    with ExitStack() as stack:
        bag, parts = folder, _parts(about, folder)
        if mode != "none":
            bag = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="ct-bag-")))
            with content_of(path):
                parts = [_uncompressed(file, bag, mode) for file in parts]
                _write_metadata(about, bag, parts)
        is_mcap = bool(parts) and all(file.suffix == ".mcap" for file in parts)
        yield Recording(path, tuple(parts) if is_mcap else (), bag, mode == "message")


def _parts(about: Mapping[str, Any], folder: Path) -> list[Path]:
    names = about.get("relative_file_paths")
    return [folder / PurePath(str(n)).name for n in names] if isinstance(names, list) else []


def _write_metadata(about: Mapping[str, Any], bag: Path, parts: Sequence[Path]) -> None:
    """Write a bag's metadata with other files, which aren't compressed."""
    changed = {
        **about,
        "compression_mode": "",
        "compression_format": "",
        "relative_file_paths": [file.name for file in parts],
    }
    (bag / BAG).write_text(yaml.safe_dump({_INFORMATION: changed}))


def _metadata(folder: Path) -> Mapping[str, Any]:
    """Return what a bag's metadata say; nothing if they can't be read, which its reader names."""
    try:
        content = regular_file.read_bytes(folder / BAG, most=MOST_METADATA)
        about = yaml.load(content, yaml.CSafeLoader)[_INFORMATION]
    except (OSError, ValueError, LookupError, TypeError, RecursionError, yaml.YAMLError):
        return {}
    return about if isinstance(about, Mapping) else {}


def _uncompressed(file: Path, folder: Path, mode: str) -> Path:
    """Write a file of a bag into a folder, without its compression."""
    if mode == "message":  # of which each is uncompressed when it is needed
        if file.suffix == ".mcap":
            return file
        target = folder / file.name
        target.symlink_to(file)
        return target
    target = folder / file.stem
    most = shutil.disk_usage(folder).free // 2
    with content_of(file), regular_file.opened(file) as stream, target.open("wb") as new:
        _copy(zstandard.ZstdDecompressor().stream_reader(stream), new, most)
    return target


def _copy(source: Any, target: BinaryIO, most: int) -> None:
    size = 0
    while piece := source.read(AT_ONCE):
        size += len(piece)
        if size > most:
            raise ValueError(f"uncompressed, it has more than {most} bytes, half of the free disk")
        target.write(piece)


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
        every = list(mcap_records(file, with_messages=False))
        schemas = {r.id: r.name for r in every if isinstance(r, Schema)}
        channels = [r for r in every if isinstance(r, Channel)]
    return {c.topic: _last_name(schemas.get(c.schema_id, "")) for c in channels}


def mcap_records(file: Path, *, with_messages: bool) -> Iterator[Any]:
    """Yield the records of an MCAP file, those of chunks too."""
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


def _mcap_messages(
    file: Path, topics: Collection[str], plain: Callable[[bytes], bytes]
) -> Iterator[Published]:
    schemas: dict[int, Schema] = {}
    decoders: dict[int, tuple[str, Callable[[bytes], Any]]] = {}
    for record in mcap_records(file, with_messages=True):
        if isinstance(record, Schema):
            schemas[record.id] = record
        elif isinstance(record, Channel) and record.topic in topics:
            if record.id not in decoders:
                decode = _decoder(record, schemas.get(record.schema_id), file)
                decoders[record.id] = record.topic, decode
        elif isinstance(record, Message) and record.channel_id in decoders:
            topic, decode = decoders[record.channel_id]
            content = partial(_of_message, decode, plain, record.data)
            yield Published(topic, record.log_time, content)


def _of_message(
    decode: Callable[[bytes], Any], plain: Callable[[bytes], bytes], content: bytes
) -> Any:
    return decode(plain(content))


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
        if name not in self._fields:
            raise AttributeError(name)
        value = self._fields[name]
        is_bytes = name == "data" and isinstance(value, str)
        return base64.b64decode(value, validate=True) if is_bytes else value


@contextmanager
def message_of(where: str) -> Iterator[None]:
    """Turn any error that a message's content causes into a FormatError."""
    try:
        yield
    except CorpusError:
        raise
    except Exception as error:  # as for a recording
        what = f"the message can't be read: {error or type(error).__name__}"
        raise FormatError(f"{what:.300}", where=where, fix=FIX) from error
