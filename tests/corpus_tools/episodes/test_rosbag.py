"""MCAP files and ROS bags, by their own writers, become tables and videos; bad ones are named."""

from __future__ import annotations

import base64
import csv
import json
import sqlite3
import tracemalloc
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from functools import partial
from itertools import islice
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import av
import lz4.frame
import numpy as np
import pytest
import yaml
import zstandard

pytest.importorskip("rosbags", reason="the extra `ros` is not installed")
pytest.importorskip("mcap_protobuf", reason="the extra `ros` is not installed")

from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.CompressedVideo_pb2 import CompressedVideo
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from mcap_protobuf.writer import Writer as ProtobufWriter
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore

from corpus_tools.cli.console import run
from corpus_tools.episodes import bag_reading
from corpus_tools.episodes.rosbag import open_recordings
from tests.lerobot_datasets import HEIGHT, WIDTH, curves_of, png, shade

TOPIC = "/camera/color/image_raw/compressed"
FRAMES = 8
START_NS = 1_700_000_000_000_000_000
STEP_NS = 50_000_000
"""20 frames a second."""
STORE2, STORE1 = get_typestore(Stores.ROS2_HUMBLE), get_typestore(Stores.ROS1_NOETIC)

Times = Sequence[int]
TIMES: Times = [START_NS + STEP_NS * i for i in range(FRAMES)]


def image2(number: int, content: bytes | None = None) -> bytes:
    types = STORE2.types
    stamp = types["builtin_interfaces/msg/Time"](sec=1, nanosec=number)
    header = types["std_msgs/msg/Header"](stamp=stamp, frame_id="camera")
    data = np.frombuffer(png(shade(0, number)) if content is None else content, np.uint8)
    message = types["sensor_msgs/msg/CompressedImage"](header=header, format="png", data=data)
    return bytes(STORE2.serialize_cdr(message, message.__msgtype__))


def bag2(folder: Path, plugin: Any = StoragePlugin.SQLITE3, compressed: str = "") -> Path:
    writer = Writer2(folder, version=9, storage_plugin=plugin)
    if compressed:
        writer.set_compression(CompressionMode[compressed], CompressionFormat.ZSTD)
    with writer:
        kind = "sensor_msgs/msg/CompressedImage"
        camera = writer.add_connection(TOPIC, kind, typestore=STORE2)
        state = writer.add_connection("/state", "std_msgs/msg/Float64", typestore=STORE2)
        number = STORE2.types["std_msgs/msg/Float64"](data=1.0)
        for i, time_ns in enumerate(TIMES):
            writer.write(camera, time_ns, image2(i))
            writer.write(state, time_ns, STORE2.serialize_cdr(number, "std_msgs/msg/Float64"))
    return folder


def bag2_mcap(folder: Path) -> Path:
    return bag2(folder, StoragePlugin.MCAP)


def database(folder: Path) -> Path:
    return next(bag2(folder).glob("*.db3"))


def bag1(file: Path, compressed: str = "") -> Path:
    types = STORE1.types
    writer = Writer1(file.with_suffix(".bag"))
    if compressed:
        writer.set_compression(Writer1.CompressionFormat[compressed])
    with writer:
        camera = writer.add_connection(TOPIC, "sensor_msgs/msg/CompressedImage", typestore=STORE1)
        for i, time_ns in enumerate(TIMES):
            stamp = types["builtin_interfaces/msg/Time"](sec=1, nanosec=i)
            header = types["std_msgs/msg/Header"](seq=i, stamp=stamp, frame_id="camera")
            data = np.frombuffer(png(shade(0, i)), np.uint8)
            message = types["sensor_msgs/msg/CompressedImage"](
                header=header, format="png", data=data
            )
            writer.write(camera, time_ns, STORE1.serialize_ros1(message, message.__msgtype__))
    return file.with_suffix(".bag")


def raw_bag(folder: Path) -> Path:
    types = STORE2.types
    kind = "sensor_msgs/msg/Image"
    with Writer2(folder, version=9) as writer:
        camera = writer.add_connection(TOPIC, kind, typestore=STORE2)
        for i, time_ns in enumerate(TIMES):
            stamp = types["builtin_interfaces/msg/Time"](sec=1, nanosec=i)
            header = types["std_msgs/msg/Header"](stamp=stamp, frame_id="camera")
            rows = np.zeros((HEIGHT, WIDTH * 3 + 8), np.uint8)
            rows[:, : WIDTH * 3] = shade(0, i)
            message = types[kind](
                header=header, height=HEIGHT, width=WIDTH, encoding="bgr8", is_bigendian=0,
                step=WIDTH * 3 + 8, data=rows.reshape(-1),
            )  # fmt: skip
            writer.write(camera, time_ns, STORE2.serialize_cdr(message, kind))
    return folder


def protobuf(file: Path, messages: Sequence[Any] | None = None, times: Times = TIMES) -> Path:
    file = file.with_suffix(".mcap")
    if messages is None:
        messages = [CompressedImage(data=png(shade(0, i)), format="png") for i in range(FRAMES)]
    with file.open("wb") as stream, ProtobufWriter(stream) as writer:
        for message, time_ns in zip(messages, times, strict=False):
            writer.write_message(TOPIC, message, time_ns, time_ns)
    return file


def _coded(codec: str, options: dict[str, str]) -> Iterator[bytes]:
    context: Any = av.CodecContext.create(codec, "w")
    context.width, context.height, context.pix_fmt = WIDTH, HEIGHT, "yuv420p"
    context.time_base, context.options = Fraction(1, 20), options
    for i in range(FRAMES):
        pixels = np.full((HEIGHT, WIDTH, 3), shade(0, i), np.uint8)
        frame = av.VideoFrame.from_ndarray(pixels, format="rgb24").reformat(format="yuv420p")
        frame.pts = i
        yield from map(bytes, context.encode(frame))
    yield from map(bytes, context.encode(None))


def video(file: Path) -> Path:
    options = {"tune": "zerolatency", "x264-params": "repeat-headers=1:annexb=1", "crf": "8"}
    every = [CompressedVideo(data=data, format="h264") for data in _coded("libx264", options)]
    return protobuf(file, every)


def video_from_its_middle(file: Path) -> Path:
    """A recording that began between two key frames: the first frames can't be decoded."""
    options = {"tune": "zerolatency", "x264-params": "repeat-headers=1:annexb=1", "crf": "8"}
    every = [CompressedVideo(data=data, format="h264") for data in _coded("libx264", options)]
    return protobuf(file, [*every[1:3], *every], [TIMES[0] - 2, TIMES[0] - 1, *TIMES])


def in_json(file: Path, compression: CompressionType = CompressionType.LZ4) -> Path:
    file = file.with_suffix(".mcap")
    with file.open("wb") as stream:
        writer = McapWriter(stream, compression=compression)
        writer.start()
        schema = writer.register_schema("foxglove.CompressedImage", "jsonschema", b"{}")
        channel = writer.register_channel(TOPIC, "json", schema)
        for i, time_ns in enumerate(TIMES):
            data = base64.b64encode(png(shade(0, i))).decode()
            content = json.dumps({"data": data, "format": "png"}).encode()
            writer.add_message(channel, time_ns, content, time_ns)
        writer.finish()
    return file


FILE_ZSTD = partial(bag2, compressed="FILE")
MESSAGE_ZSTD = partial(bag2, compressed="MESSAGE")
FILE_MCAP = partial(bag2, plugin=StoragePlugin.MCAP, compressed="FILE")
MESSAGE_MCAP = partial(bag2, plugin=StoragePlugin.MCAP, compressed="MESSAGE")
BAG1_LZ4, BAG1_BZ2 = partial(bag1, compressed="LZ4"), partial(bag1, compressed="BZ2")


def call(path: Path, *options: str) -> list[str]:
    out = str(path.parent / "tables")
    return ["import", "rosbag", str(path), "--out", out, "--force", *options]


def shown(folder: Path) -> list[tuple[dict[str, str], list[float]]]:
    """The rows of a table, with the shades of their films' frames."""
    found = []
    for row in csv.DictReader((folder / "episodes.csv").read_text().splitlines()):
        with av.open(str(folder / row["video"])) as container:
            frames = [f.to_ndarray(format="rgb24").mean() for f in container.decode(video=0)]
        found.append((row, frames))
    return found


@pytest.mark.parametrize(
    "write",
    [
        bag2, bag2_mcap, database, bag1, raw_bag, protobuf, video, video_from_its_middle, in_json,
        FILE_ZSTD, MESSAGE_ZSTD, FILE_MCAP, MESSAGE_MCAP, BAG1_LZ4, BAG1_BZ2,
    ],
)  # fmt: skip
def test_a_recording_is_an_episode(tmp_path: Path, write: Callable[[Path], Path]):
    path = write(tmp_path / "run")
    assert run(call(path)) == 0
    ((row, frames),) = shown(path.parent / "tables")
    assert (row["camera"], row["fps"], row["episode"]) == (TOPIC, "20.0", "0")
    assert int(row["start"]) == START_NS
    assert row["source"].startswith("run")
    expected = [shade(0, i) for i in range(FRAMES)]
    assert frames == pytest.approx(expected, abs=4)


def robot_bag(folder: Path) -> Path:
    """Two cameras, of which one begins later and has half the rate, and joints in two messages."""
    joints = STORE2.types["sensor_msgs/msg/JointState"]
    nothing = np.zeros(0)
    with Writer2(folder, version=9) as writer:
        image, joint = "sensor_msgs/msg/CompressedImage", "sensor_msgs/msg/JointState"
        front = writer.add_connection(TOPIC, image, typestore=STORE2)
        wrist = writer.add_connection("/wrist/compressed", image, typestore=STORE2)
        state = writer.add_connection("/joint_states", joint, typestore=STORE2)
        header = STORE2.types["std_msgs/msg/Header"](
            stamp=STORE2.types["builtin_interfaces/msg/Time"](sec=1, nanosec=0), frame_id=""
        )

        def write_joints(time_ns: int, names: list[str], position: list[float]) -> None:
            message = joints(
                header=header, name=names, position=np.array(position),
                velocity=np.array([time_ns / 1e9 % 1] * len(names)), effort=nothing,
            )  # fmt: skip
            writer.write(state, time_ns, STORE2.serialize_cdr(message, joint))

        write_joints(START_NS - STEP_NS, ["arm", "wrist"], [-1.0, -2.0])
        for i, time_ns in enumerate(TIMES):
            writer.write(front, time_ns, image2(i))
            if i >= 2 and i % 2 == 0:
                writer.write(wrist, time_ns, image2(i))
            if i == 3:
                write_joints(time_ns, ["gripper"], [0.5])
            if i == 5:
                write_joints(time_ns, ["wrist", "arm"], [8.0, 9.0])
    return folder


def test_cameras_in_step_with_curves(tmp_path: Path):
    assert run(call(robot_bag(tmp_path / "run"))) == 0
    ((row, _),) = shown(tmp_path / "tables")
    assert (row["camera"], row["camera_2"]) == (TOPIC, "/wrist/compressed")
    with av.open(str(tmp_path / "tables" / row["video_2"])) as container:
        frames = [f.to_ndarray(format="rgb24").mean() for f in container.decode(video=0)]
    assert frames == pytest.approx([shade(0, i) for i in (2, 2, 2, 2, 4, 4, 6, 6)], abs=4)
    header, values = curves_of(tmp_path / "tables" / row["curves"])
    places = {(c.group, c.name): n for n, c in enumerate(header.curves)}
    groups = [c.group for c in header.curves]
    assert groups == sorted(groups)
    position = "/joint_states position"
    arm, wrist, gripper = (values[:, places[position, n]] for n in ("arm", "wrist", "gripper"))
    assert arm.tolist() == [-1.0] * 5 + [9.0] * 3
    assert wrist.tolist() == [-2.0] * 5 + [8.0] * 3
    assert np.isnan(gripper[:3]).all()
    assert gripper[3:].tolist() == [0.5] * 5


def test_one_topic_in_two_forms(tmp_path: Path, capsys):
    file = tmp_path / "run.mcap"
    raw = RawImage(width=2, height=2, encoding="rgb8", step=6, data=bytes(12))
    with file.open("wb") as stream, ProtobufWriter(stream) as writer:
        for i, time_ns in enumerate(TIMES):
            image = CompressedImage(data=png(shade(0, i)), format="png")
            writer.write_message("/top/compressed", image, time_ns, time_ns)
            writer.write_message("/top", raw, time_ns, time_ns)
    assert run(call(file)) == 0
    ((row, _),) = shown(tmp_path / "tables")
    assert row["camera"] == "/top/compressed"
    assert "video_2" not in row
    assert "cameras that aren't shown: /top" in capsys.readouterr().err


NUMBERS = [
    ("Float64", {"data": 1.5}, [("/n", "data", 1.5)]),
    ("Float32MultiArray", {"data": [1, 2]}, [("/n", "1", 1.0), ("/n", "2", 2.0)]),
    ("Twist", {"linear": {"x": 3.0}}, [("/n", "linear.x", 3.0)]),
    ("PoseStamped", {"pose": {"orientation": {"w": 1}}}, [("/n", "orientation.w", 1.0)]),
    ("JointState", {"name": ["a"], "effort": [2]}, [("/n effort", "a", 2.0)]),
    ("JointState", {"name": ["a", "b"], "effort": [2]}, [("/n effort", "1", 2.0)]),
]
NO_NUMBERS = [
    ("Float64", {"data": None}), ("Float64", {}), ("Twist", {"linear": 3}), ("JointState", {}),
    ("Float32MultiArray", {"data": [0] * 65}), ("Pose", {"position": {"x": []}}),
]  # fmt: skip
BAD_NUMBERS = [
    ("Float64", {"data": {"a": 1}}), ("Float64", {"data": "!"}),
    ("JointState", {"name": 3, "position": [1]}), ("Float64MultiArray", {"data": [[1], [1, 2]]}),
]  # fmt: skip


def with_numbers(file: Path, kind: str, content: Any) -> Path:
    in_json(file)
    file = file.with_suffix(".mcap")
    with file.open("wb") as stream:
        writer = McapWriter(stream)
        writer.start()
        for topic, name in ((TOPIC, "foxglove.CompressedImage"), ("/n", f"std_msgs/msg/{kind}")):
            schema = writer.register_schema(name, "jsonschema", b"{}")
            channel = writer.register_channel(topic, "json", schema)
            data = base64.b64encode(png(shade(0, 0))).decode()
            said = {"data": data, "format": "png"} if topic == TOPIC else content
            for time_ns in TIMES:
                writer.add_message(channel, time_ns, json.dumps(said).encode(), time_ns)
        writer.finish()
    return file


@pytest.mark.parametrize(("kind", "content", "expected"), NUMBERS)
def test_numbers_of_messages(tmp_path: Path, kind: str, content: Any, expected: Any):
    assert run(call(with_numbers(tmp_path / "run", kind, content))) == 0
    ((row, _),) = shown(tmp_path / "tables")
    header, values = curves_of(tmp_path / "tables" / row["curves"])
    named = [(c.group, c.name) for c in header.curves]
    assert [(*name, value) for name, value in zip(named, values[-1], strict=True)] == expected


@pytest.mark.parametrize(("kind", "content"), [*NO_NUMBERS, *BAD_NUMBERS])
def test_messages_without_numbers(tmp_path: Path, capsys, kind: str, content: Any):
    assert run(call(with_numbers(tmp_path / "run", kind, content))) == 0
    ((row, _),) = shown(tmp_path / "tables")
    assert "curves" not in row
    is_bad = (kind, content) in BAD_NUMBERS
    assert ("without curves, the first because" in capsys.readouterr().err) == is_bad


def test_compression_that_is_not_read(tmp_path: Path, capsys):
    about = FILE_ZSTD(tmp_path / "run") / "metadata.yaml"
    about.write_text(
        about.read_text().replace("compression_format: zstd", "compression_format: lz4")
    )
    assert run(call(tmp_path / "run")) == 2
    assert "compressed by 'lz4', which isn't read" in capsys.readouterr().err


@pytest.mark.parametrize(
    "names", [[".."], ["."], 3, ["/etc/passwd"], ["a\0b"], ["gone.db3.zstd"], [[]], None]
)
def test_names_of_compressed_files_are_not_trusted(tmp_path: Path, capsys, names: Any):
    about = FILE_ZSTD(tmp_path / "run") / "metadata.yaml"
    content = yaml.safe_load(about.read_text())
    content["rosbag2_bagfile_information"]["relative_file_paths"] = names
    about.write_text(yaml.safe_dump(content))
    assert run(call(tmp_path / "run")) == 2
    assert str(tmp_path / "run") in capsys.readouterr().err


def test_files_are_not_uncompressed_beyond_a_limit(tmp_path: Path, capsys, monkeypatch):
    """Half of the free disk can't be filled here, nor a gibibyte of memory."""
    monkeypatch.setattr(bag_reading, "MOST_CHUNK", 100)
    monkeypatch.setattr("shutil.disk_usage", lambda folder: SimpleNamespace(free=4000))
    for number, write in enumerate((FILE_ZSTD, MESSAGE_ZSTD, BAG1_LZ4, BAG1_BZ2)):
        assert run(call(write(tmp_path / f"run-{number}"))) == 2
        assert "uncompressed, " in capsys.readouterr().err


def test_a_folder_of_recordings(tmp_path: Path):
    (tmp_path / "bags/b").mkdir(parents=True)
    for name in ("b/second", "a"):
        bag2(tmp_path / "bags" / name)
    protobuf(tmp_path / "bags/c")
    (tmp_path / "bags/b/circle").symlink_to(tmp_path / "bags")
    assert run(call(tmp_path / "bags")) == 0
    assert [row["source"] for row, _ in shown(tmp_path / "tables")] == ["a", "b/second", "c.mcap"]


def test_frames_stay_until_the_next_comes(tmp_path: Path):
    times = [START_NS + STEP_NS * i for i in (0, 1, 2, 6, 7, 7, 8, 9)]
    path = protobuf(tmp_path / "run", times=times)
    assert run(call(path, "--fps", "20")) == 0
    ((_, frames),) = shown(tmp_path / "tables")
    expected = [shade(0, i) for i in (0, 1, 2, 2, 2, 2, 3, 5, 6, 7)]
    assert frames == pytest.approx(expected, abs=4)


def test_memory_stays_flat_while_a_rate_is_measured(tmp_path: Path):
    width, height, count = 640, 480, 100
    size = 3 * width * height
    one = RawImage(width=width, height=height, encoding="rgb8", step=3 * width, data=bytes(size))
    times = [START_NS + STEP_NS * i for i in range(count)]
    path = protobuf(tmp_path / "run", [one] * count, times)
    tracemalloc.start()
    try:
        (episode,) = open_recordings(path).episodes([TOPIC], lambda error: None)
        assert len(list(islice(episode.views[TOPIC], 5))) == 5
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert episode.fps == 20
    assert peak < count * size / 3


def _half(path: Path) -> None:
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def _other(path: Path) -> None:
    path.write_bytes(b"nothing of that kind, and longer than a header" * 4)


def _flipped(path: Path) -> None:
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)


def _no_picture(path: Path) -> None:
    with sqlite3.connect(path) as connection:
        connection.execute("update messages set data = ?", (image2(0, b"no picture"),))
    connection.close()


def _short(path: Path) -> None:
    with sqlite3.connect(path) as connection:
        connection.execute("update messages set data = substr(data, 1, 9)")
    connection.close()


@pytest.mark.parametrize(
    ("write", "change"),
    [
        (in_json, _half), (in_json, _other), (in_json, _flipped),
        (bag1, _half), (bag1, _other), (database, _half), (database, _other),
        (database, _no_picture), (database, _short),
    ],
)  # fmt: skip
def test_other_peoples_recordings_are_not_trusted(tmp_path: Path, capsys, write, change):
    path = write(tmp_path / "run")
    change(path)
    assert run(call(path)) == 2
    assert str(path) in capsys.readouterr().err
    assert not (path.parent / "tables").exists()


def _bomb(compression: str) -> bytes:
    content = bytes(64 << 20)
    return zstandard.compress(content) if compression == "zstd" else lz4.frame.compress(content)


@pytest.mark.parametrize("compression", ["zstd", "lz4"])
def test_a_chunk_is_not_uncompressed_beyond_its_size(tmp_path: Path, capsys, compression: str):
    path = protobuf(tmp_path / "run")
    content = path.read_bytes()
    bomb, name = _bomb(compression), compression.encode()
    chunk = (0).to_bytes(8, "little") * 2 + (1000).to_bytes(8, "little") + bytes(4)
    chunk += len(name).to_bytes(4, "little") + name + len(bomb).to_bytes(8, "little") + bomb
    header_end = 8 + 9 + int.from_bytes(content[9:17], "little")
    record = b"\x06" + len(chunk).to_bytes(8, "little") + chunk
    end = b"\x0f" + (4).to_bytes(8, "little") + bytes(4) + b"\x02" + (20).to_bytes(8, "little")
    path.write_bytes(content[:header_end] + record + end + bytes(20) + content[:8])
    assert run(call(path, "--camera", TOPIC)) == 2
    assert "a chunk has other than its 1000 bytes" in capsys.readouterr().err


def test_messages_that_say_too_much(tmp_path: Path, capsys):
    cases = {
        "a jump": (protobuf(tmp_path / "a", times=[0, STEP_NS, 2**62]), "don't go on"),
        "back": (protobuf(tmp_path / "b", times=[10**12, 2 * 10**12, 0]), "don't go on"),
        "codec": (
            protobuf(tmp_path / "c", [CompressedVideo(data=b"x", format="rawvideo")]),
            "'rawvideo' isn't among",
        ),
        "no key frame": (
            protobuf(tmp_path / "d", [CompressedVideo(data=b"x" * 40, format="h264")]),
            "there are no pictures",
        ),
    }
    for path, what in cases.values():
        assert run(call(path)) == 2
        assert what in capsys.readouterr().err


def test_a_recording_without_a_camera(tmp_path: Path, capsys):
    with Writer2(tmp_path / "run", version=9) as writer:
        state = writer.add_connection("/state", "std_msgs/msg/Float64", typestore=STORE2)
        number = STORE2.types["std_msgs/msg/Float64"](data=1.0)
        writer.write(state, START_NS, STORE2.serialize_cdr(number, "std_msgs/msg/Float64"))
    assert run(call(tmp_path / "run")) == 2
    assert "record a topic with compressed images" in capsys.readouterr().err
    (tmp_path / "empty").mkdir()
    assert run(call(tmp_path / "empty")) == 2
    assert "there are no recordings" in capsys.readouterr().err
