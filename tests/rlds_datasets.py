"""Small RLDS datasets, written byte by byte as TensorFlow Datasets lays them out.

TensorFlow isn't among the development tools. Checksums, records and messages are made here by code
of its own, so that reading is not compared with itself.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from tests.lerobot_datasets import HEIGHT, WIDTH, png, shade

TASKS = ("Push the cube.", "", "Lift it.")
LENGTHS = (5, 3, 4)
Values = Sequence[bytes] | Sequence[int] | Sequence[float]


def crc32c(content: bytes) -> int:
    crc = 0xFFFFFFFF
    for byte in content:
        crc ^= byte
        for _ in range(8):
            crc = (crc >> 1) ^ (0x82F63B78 if crc & 1 else 0)
    return crc ^ 0xFFFFFFFF


def masked(content: bytes) -> bytes:
    crc = crc32c(content)
    return struct.pack("<I", ((crc >> 15 | crc << 17) + 0xA282EAD8) & 0xFFFFFFFF)


def record(content: bytes) -> bytes:
    length = struct.pack("<Q", len(content))
    return length + masked(length) + content + masked(content)


def varint(number: int) -> bytes:
    pieces = []
    while number >= 0x80:
        pieces.append(number & 0x7F | 0x80)
        number >>= 7
    return bytes([*pieces, number])


def field(number: int, content: bytes) -> bytes:
    """A field with a length, as messages, texts and packed numbers are."""
    return varint(number << 3 | 2) + varint(len(content)) + content


def feature(values: Values) -> bytes:
    if all(isinstance(value, bytes) for value in values):
        return field(1, b"".join(field(1, value) for value in values))
    if all(isinstance(value, int) for value in values):
        return field(3, field(1, b"".join(varint(value) for value in values)))
    return field(2, field(1, struct.pack(f"<{len(values)}f", *values)))


def example(features: Mapping[str, Values]) -> bytes:
    """A ``tf.train.Example``."""
    entries = (field(1, field(1, n.encode()) + field(2, feature(v))) for n, v in features.items())
    return field(1, b"".join(entries))


def sequence_example(features: Mapping[str, Values]) -> bytes:
    """A ``tf.train.SequenceExample`` with a feature for each step."""
    lists = []
    for name, values in features.items():
        steps = b"".join(field(1, feature([value])) for value in values)
        lists.append(field(1, field(1, name.encode()) + field(2, steps)))
    return field(2, b"".join(lists))


def steps(episode: int, length: int, task: str) -> dict[str, Values]:
    pictures = [png(shade(episode, i)) for i in range(length)]
    return {
        "steps/observation/image": pictures,
        "steps/observation/depth": pictures,
        "steps/action": [0.5] * (7 * length),
        "steps/is_first": [int(i == 0) for i in range(length)],
        "steps/language_instruction": [task.encode()] * length,
    }


def text() -> dict[str, Any]:
    return {"pythonClassName": "tensorflow_datasets.core.features.text_feature.Text", "text": {}}


def _tensor(dtype: str, *shape: str) -> dict[str, Any]:
    dimensions = {"dimensions": list(shape)} if shape else {}
    return {"tensor": {"shape": dimensions, "dtype": dtype, "encoding": "none"}}


def _image(dtype: str, channels: str) -> dict[str, Any]:
    shape = {"dimensions": [str(HEIGHT), str(WIDTH), channels]}
    return {"image": {"shape": shape, "dtype": dtype, "encodingFormat": "png"}}


def features(**more: Any) -> dict[str, Any]:
    """The content of ``features.json``."""
    observation = {"depth": _image("uint16", "1"), "image": _image("uint8", "3")}
    of_step = {
        "action": _tensor("float32", "7"),
        "is_first": _tensor("bool"),
        "language_instruction": text(),
        "observation": {"featuresDict": {"features": observation}},
        **more,
    }
    whole = {
        "episode_metadata": {"featuresDict": {"features": {"file_path": text()}}},
        "steps": {"sequence": {"feature": {"featuresDict": {"features": of_step}}, "length": "-1"}},
    }
    return {"featuresDict": {"features": whole}}


def dataset(folder: Path, *, is_sequence: bool = False) -> Path:
    """A dataset of three episodes of unequal lengths: two shards of ``train``, one of ``val``."""
    folder.mkdir(parents=True)
    encode = sequence_example if is_sequence else example
    contents = [
        encode(steps(n, length, task))
        for n, (length, task) in enumerate(zip(LENGTHS, TASKS, strict=True))
    ]
    shards = {
        "train.tfrecord-00000-of-00002": contents[:1],
        "train.tfrecord-00001-of-00002": contents[1:2],
        "val.tfrecord-00000-of-00001": contents[2:],
    }
    for name, several in shards.items():
        (folder / f"toy-{name}").write_bytes(b"".join(map(record, several)))
    splits = [
        {"name": "train", "numBytes": "1", "shardLengths": ["1", "1"]},
        {"name": "val", "numBytes": "1", "shardLengths": ["1"]},
    ]
    template = "{DATASET}-{SPLIT}.{FILEFORMAT}-{SHARD_X_OF_Y}"
    info = {
        "fileFormat": "tfrecord",
        "name": "toy",
        "splits": [split | {"filepathTemplate": template} for split in splits],
        "version": "1.0.0",
    }
    (folder / "dataset_info.json").write_text(json.dumps(info))
    (folder / "features.json").write_text(json.dumps(features()))
    return folder
