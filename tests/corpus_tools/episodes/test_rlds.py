"""RLDS datasets become tables and videos without TensorFlow; bad ones are named."""

from __future__ import annotations

import csv
import gzip
import json
import struct
from pathlib import Path

import av
import pytest

pytest.importorskip("google_crc32c", reason="the extra `rlds` is not installed")

from corpus_tools.cli.console import run
from corpus_tools.episodes.copies import LanguageCopy
from corpus_tools.episodes.rlds import open_steps
from corpus_tools.episodes.rlds_writing import write_rlds
from corpus_tools.lerobot.language_rows import Language
from corpus_tools.lerobot.language_writing import EpisodeLanguage
from tests.lerobot_datasets import curves_of, shade
from tests.rlds_datasets import (
    LENGTHS,
    TASKS,
    dataset,
    example,
    features,
    masked,
    record,
    steps,
)

FIRST = "toy-train.tfrecord-00000-of-00002"
SECOND = "toy-train.tfrecord-00001-of-00002"


def rows(folder: Path, name: str = "episodes.csv") -> list[dict[str, str]]:
    return list(csv.DictReader((folder / name).read_text().splitlines()))


def call(path: Path, *options: str) -> list[str]:
    return ["import", "rlds", str(path), "--out", str(path.parent / "tables"), "--force", *options]


@pytest.mark.parametrize("is_sequence", [False, True])
def test_a_record_is_an_episode(tmp_path: Path, capsys, is_sequence: bool):
    folder = dataset(tmp_path / "toy", is_sequence=is_sequence)
    assert run(call(folder)) == 0
    assert "10 frames a second" in capsys.readouterr().err
    found = rows(tmp_path / "tables")
    assert [row["episode"] for row in found] == ["0", "1", "2"]
    assert [row["task"] for row in found] == list(TASKS)
    assert found[2]["source"] == "toy-val.tfrecord-00000-of-00001, record 0"
    assert {row["camera"] for row in found} == {"observation/image"}
    for number, row in enumerate(found):
        with av.open(str(tmp_path / "tables" / row["video"])) as container:
            frames = [f.to_ndarray(format="rgb24") for f in container.decode(video=0)]
        assert len(frames) == LENGTHS[number]
        assert abs(frames[-1].mean() - shade(number, len(frames) - 1)) < 4
    commands = [row["command"] for row in rows(tmp_path / "tables", "tasks.csv")]
    assert commands == [TASKS[0], TASKS[2]]


def test_cameras_side_by_side_with_curves(tmp_path: Path, capsys):
    folder = dataset(tmp_path / "toy")
    wanted = ["observation/image", "observation/depth"]
    assert run(call(folder, *(one for name in wanted for one in ("--camera", name)))) == 0
    for number, row in enumerate(rows(tmp_path / "tables")):
        assert [row["camera"], row["camera_2"]] == wanted
        for name in (row["video"], row["video_2"]):
            with av.open(str(tmp_path / "tables" / name)) as container:
                assert len([*container.decode(video=0)]) == LENGTHS[number]
        header, values = curves_of(tmp_path / "tables" / row["curves"])
        assert [(c.group, c.name) for c in header.curves] == [
            ("action", str(n)) for n in range(1, 8)
        ]
        assert (header.rate, len(values)) == (10.0, LENGTHS[number])
        assert (values == 0.5).all()
    assert run(call(folder, "--no-curves")) == 0
    assert "curves" not in rows(tmp_path / "tables")[0]
    assert "video_2" not in rows(tmp_path / "tables")[0]


def test_numbers_that_are_too_few(tmp_path: Path, capsys):
    folder = dataset(tmp_path / "toy")
    values = steps(0, LENGTHS[0], TASKS[0])
    (folder / FIRST).write_bytes(record(example(values | {"steps/action": [0.5] * 8})))
    assert run(call(folder)) == 0
    assert "1 episodes without curves, the first because: " in capsys.readouterr().err
    assert [bool(row["curves"]) for row in rows(tmp_path / "tables")] == [False, True, True]


@pytest.mark.parametrize(
    "tensor",
    [
        {"shape": {"dimensions": ["7", "-1"]}}, {"shape": {"dimensions": 3}}, {"shape": [7]},
        {"shape": {"dimensions": ["9999"] * 4}}, {"shape": {"dimensions": ["65"]}},
        {"dtype": "bfloat16?"}, {"encoding": "zlib"}, {"dtype": None},
    ],
)  # fmt: skip
def test_shapes_that_are_none(tmp_path: Path, tensor):
    folder = dataset(tmp_path / "toy")
    usual = {"shape": {"dimensions": ["7"]}, "dtype": "float32", "encoding": "none"}
    content = features(action={"tensor": usual | tensor})
    (folder / "features.json").write_text(json.dumps(content))
    assert run(call(folder)) == 0
    assert "curves" not in rows(tmp_path / "tables")[0]


def test_a_version_below_and_another_rate(tmp_path: Path, capsys):
    dataset(tmp_path / "toy/1.0.0")
    assert run(call(tmp_path / "toy", "--fps", "5", "--camera", "observation/depth")) == 0
    told = capsys.readouterr().err
    assert "frames a second" not in told
    assert "depth map" in told
    assert rows(tmp_path / "tables")[0]["fps"] == "5.0"
    assert rows(tmp_path / "tables")[0]["dataset"] == str(tmp_path / "toy/1.0.0")


def test_some_shards_of_a_large_dataset(tmp_path: Path, capsys):
    folder = dataset(tmp_path / "toy")
    (folder / SECOND).unlink()
    assert run(call(folder)) == 2
    assert SECOND in capsys.readouterr().err
    assert run(call(folder, "--first", "1")) == 0
    assert run(call(folder, "--keep-going")) == 0
    assert [row["episode"] for row in rows(tmp_path / "tables")] == ["0", "2"]


@pytest.mark.parametrize("is_sequence", [False, True])
def test_corrected_tasks_take_the_place_of_wrong_ones(tmp_path: Path, is_sequence: bool):
    source = open_steps(dataset(tmp_path / "toy", is_sequence=is_sequence))
    memory = Language("memory", 0.1, "I came near.")
    language = {
        0: EpisodeLanguage((), corrected={TASKS[0]: "Lift the cube."}),
        2: EpisodeLanguage((memory,), corrected={"Another.": "Lift the cube."}),
    }
    (note,) = write_rlds(source, LanguageCopy(tmp_path / "copy", language, {}))
    assert note == "1 texts of the style memory are in no record: RLDS has no such style"
    copy = open_steps(tmp_path / "copy")
    tasks = [one.tasks for one in copy.episodes(["observation/image"], lambda error: None)]
    assert tasks == [("Lift the cube.",), (), (TASKS[2],)]


def _cut(content: bytes) -> bytes:
    return content[: len(content) // 2]


def _changed(content: bytes) -> bytes:
    return content[:200] + bytes([content[200] ^ 1]) + content[201:]


def _huge(content: bytes) -> bytes:
    length = struct.pack("<Q", 2**62)
    return length + masked(length) + content


def _no_example(content: bytes) -> bytes:
    return record(b"\xff" * 40)


def _bad_picture(content: bytes) -> bytes:
    values = steps(0, 3, "x") | {"steps/observation/image": [b"\x89PNG but no picture"] * 3}
    return record(example(values))


def _number_as_picture(content: bytes) -> bytes:
    return record(example(steps(0, 3, "x") | {"steps/observation/image": [1, 2, 3]}))


def _bad_text(content: bytes) -> bytes:
    return record(example(steps(0, 3, "x") | {"steps/language_instruction": [b"\xff"] * 3}))


def _two(content: bytes) -> bytes:
    return content + content


@pytest.mark.parametrize(
    ("change", "what"),
    [
        (_cut, "record 0: the file is cut off"),
        (lambda content: content[:5], "record 0: the file is cut off"),
        (lambda content: b"", "the shard has 0 records"),
        (_changed, "record 0: the checksum of the content is wrong"),
        (_huge, f"the record has {2**62} bytes"),
        (gzip.compress, "the file is compressed"),
        (lambda content: b"nothing of that kind", "damaged, or no TFRecord"),
        (_no_example, "record 0: the record is no example"),
        (_bad_picture, "step 0: the picture can't be read"),
        (_number_as_picture, "step 0: this is no picture"),
        (_bad_text, "no UTF-8"),
        (_two, "the shard has 2 records"),
    ],
)
def test_other_peoples_records_are_not_trusted(tmp_path: Path, capsys, change, what):
    folder = dataset(tmp_path / "toy")
    file = folder / FIRST
    file.write_bytes(change(file.read_bytes()))
    assert run(call(folder)) == 2
    told = capsys.readouterr().err
    assert what in told
    assert FIRST in told
    assert not (tmp_path / "tables").exists()
    assert run(call(folder, "--keep-going")) == 0
    assert [row["episode"] for row in rows(tmp_path / "tables")][-2:] == ["1", "2"]


@pytest.mark.parametrize(
    ("change", "what"),
    [
        ({"fileFormat": "array_record"}, "only tfrecord is read"),
        ({"name": "../../etc/passwd"}, "is no name of a file"),
        ({"splits": [{"name": "train", "shardLengths": ["-1"]}]}, "shardLengths has '-1'"),
        ({"splits": [{"name": "train", "filepathTemplate": "/etc/passwd", "shardLengths": [1]}]},
         "is no name of a file"),
        ({"splits": 3}, "the file can't be read"),
        ({"splits": []}, "there are no episodes"),
    ],
)  # fmt: skip
def test_metadata_are_not_trusted(tmp_path: Path, capsys, change, what):
    folder = dataset(tmp_path / "toy")
    info = folder / "dataset_info.json"
    info.write_text(json.dumps(json.loads(info.read_text()) | change))
    assert run(call(folder)) == 2
    assert what in capsys.readouterr().err


def test_folders_that_are_none(tmp_path: Path, capsys):
    (tmp_path / "empty").mkdir()
    assert run(call(tmp_path / "empty")) == 2
    assert "there is no dataset_info.json" in capsys.readouterr().err
    dataset(tmp_path / "toy/1.0.0")
    dataset(tmp_path / "toy/2.0.0")
    assert run(call(tmp_path / "toy")) == 2
    assert "several datasets" in capsys.readouterr().err
    endless = '{"sequence": ' * 5000 + "{}" + "}" * 5000
    for content in ("{", "[]", '{"featuresDict": {"features": {"x": 3}}}', "{}", endless):
        (tmp_path / "toy/1.0.0/features.json").write_text(content)
        assert run(call(tmp_path / "toy/1.0.0")) == 2
        assert "features.json" in capsys.readouterr().err
