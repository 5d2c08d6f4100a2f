"""LeRobot datasets become tables for studies; no video is copied."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

import pytest

pytest.importorskip("pyarrow", reason="the extra `parquet` is not installed")
pytest.importorskip("av", reason="the extra `render` is not installed")

import pyarrow as pa
import pyarrow.parquet as pq

from corpus_tools.cli.console import run
from corpus_tools.lerobot.episode_reading import data_files, open_dataset
from corpus_tools.lerobot.grounded_answers import Answer, Shape
from corpus_tools.lerobot.language_rows import Language, event_rows
from corpus_tools.lerobot.language_writing import EpisodeLanguage, write_language
from corpus_tools.lerobot.study_input import study_input
from g3.errors import FormatError
from tests.lerobot_datasets import CAMERA, WRIST, new_dataset, old_dataset


def rows(folder: Path, name: str) -> list[dict[str, str]]:
    return list(csv.DictReader((folder / name).read_text().splitlines()))


def test_episodes_of_version_3_are_parts_of_files(tmp_path: Path, capsys):
    new_dataset(tmp_path / "set")
    out = tmp_path / "tables"
    assert run(["import", "lerobot", str(tmp_path / "set"), "--out", str(out), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    every = {"episodes.csv": 3, "tasks.csv": 2, "subtasks.csv": 3, "moments.csv": 1}
    assert told["rows"] == every
    found = rows(out, "episodes.csv")
    assert [row["id"] for row in found] == [f"episode-00000{n}" for n in range(3)]
    assert [(float(row["start_s"]), float(row["end_s"])) for row in found] == [
        (0.0, 1.2), (1.2, 2.0), (2.0, 3.0),
    ]  # fmt: skip
    file = (out / found[0]["video"]).resolve()
    assert file == (tmp_path / f"set/videos/{CAMERA}/chunk-000/file-000.mp4").resolve()
    assert {row["dataset"] for row in found} == {str((tmp_path / "set").resolve())}
    assert [row["command"] for row in rows(out, "tasks.csv")] == ["Push the cube."] * 2
    subtasks = rows(out, "subtasks.csv")
    assert [(r["command"], float(r["start_s"]), float(r["end_s"])) for r in subtasks] == [
        ("reach", 0.0, 0.5), ("grasp", 0.5, 1.2), ("push", 1.2, 2.0),
    ]  # fmt: skip
    assert [float(row["timestamp"]) for row in subtasks] == [0.0, 0.5, 0.0]
    assert sorted(file.name for file in out.iterdir()) == [
        "curves", "episodes.csv", "moments.csv", "subtasks.csv", "tasks.csv",
    ]  # fmt: skip


def test_episodes_of_version_2_are_files(tmp_path: Path):
    old_dataset(tmp_path / "set")
    assert run(["import", "lerobot", str(tmp_path / "set"), "--out", str(tmp_path / "out")]) == 0
    found = rows(tmp_path / "out", "episodes.csv")
    assert [(row["start_s"], row["end_s"]) for row in found] == [("", "")] * 3
    assert found[2]["video"].endswith("episode_000002.mp4")
    assert not (tmp_path / "out" / "subtasks.csv").exists()


def test_a_camera_and_some_episodes(tmp_path: Path):
    dataset = open_dataset(new_dataset(tmp_path / "set"))
    made = study_input(dataset, tmp_path / "out", cameras=[WRIST], first=2)
    every = {"episodes.csv": 2, "tasks.csv": 2, "subtasks.csv": 3, "moments.csv": 1}
    assert made.rows == every
    assert WRIST.encode() in made.files["episodes.csv"]
    every = study_input(dataset, tmp_path / "out").files["episodes.csv"]
    assert isinstance(every, bytes)
    (row, *_) = csv.DictReader(every.decode().splitlines())
    assert (row["camera"], row["camera_2"], row["end_s_2"]) == (CAMERA, WRIST, "1.2")
    assert f"/{WRIST}/" in row["video_2"]
    (row, *_) = csv.DictReader(
        study_input(dataset, tmp_path / "out", cameras=[WRIST, CAMERA])
        .files["subtasks.csv"].decode().splitlines()
    )  # fmt: skip
    assert (row["camera"], row["camera_2"], row["end_s_2"]) == (WRIST, CAMERA, "0.5")
    with pytest.raises(FormatError, match="no camera 'side'") as error:
        study_input(dataset, tmp_path / "out", cameras=["side"])
    assert CAMERA in error.value.fix


def test_errors_say_what_to_do(tmp_path: Path, capsys):
    (tmp_path / "empty").mkdir()
    call = ["import", "lerobot", str(tmp_path / "empty"), "--out", str(tmp_path / "out")]
    assert run(call) == 2
    assert "no LeRobot dataset" in capsys.readouterr().err
    folder = new_dataset(tmp_path / "set")
    info = folder / "meta/info.json"
    told = json.loads(info.read_text())
    for changed, what in (
        ({"codebase_version": "v4.0"}, "version is v4.0"),
        ({"fps": 0}, "fps is 0"),
        ({"features": {}}, "no videos"),
    ):
        info.write_text(json.dumps(told | changed))
        with pytest.raises(FormatError, match=what):
            study_input(open_dataset(folder), tmp_path / "out")
    info.write_text(json.dumps(told))
    (folder / f"videos/{CAMERA}/chunk-000/file-000.mp4").unlink()
    with pytest.raises(FormatError, match="there is no such file"):
        study_input(open_dataset(folder), tmp_path / "out")
    (folder / "meta/episodes/chunk-000/file-000.parquet").write_bytes(b"PAR1 broken PAR1")
    with pytest.raises(FormatError, match="the file can't be read"):
        list(open_dataset(folder).episodes())


def test_texts_at_moments_have_a_table(tmp_path: Path):
    """Memory lasts, events are shown from their frame on; answers by drawings need the picture."""
    point = Answer("point", ("cube",), (Shape(((9, 3),)),))
    said = (
        Language("memory", 0.2, "I came near."),
        Language("memory", 0.5, "I took it."),
        Language("interjection", 0.4, "Lift it."),
        Language("vqa", 0.3, "How many?", camera=CAMERA, answer=Answer("count", ("cube", "2"))),
        Language("vqa", 0.7, "Where?", camera=CAMERA, answer=point),
        Language("vqa", 0.8, "How many?", camera=WRIST, answer=Answer("words", ("One.",))),
    )
    source = open_dataset(new_dataset(tmp_path / "set", language=False))
    write_language(source, tmp_path / "copy", {1: EpisodeLanguage(said)}, attachments={})
    made = study_input(open_dataset(tmp_path / "copy"), tmp_path / "tables")
    assert made.rows["moments.csv"] == 4
    rows = list(csv.DictReader(io.StringIO(bytes(made.files["moments.csv"]).decode())))
    found = [(r["id"], r["start_s"], r["end_s"], r["command"], r["style"]) for r in rows]
    assert found == [
        ("episode-000001-memory-01", "1.4", "1.7", "I came near.", "memory"),
        ("episode-000001-memory-02", "1.7", "2.0", "I took it.", "memory"),
        ("episode-000001-vqa-01", "1.5", "2.0", "How many? – 2 cube", "vqa"),
        ("episode-000001-interjection-01", "1.6", "2.0", "Lift it.", "interjection"),
    ]
    assert [round(float(row["timestamp"]), 6) for row in rows] == [0.2, 0.5, 0.3, 0.4]
    assert any("1 answers that are drawn" in note for note in made.notes)


def test_events_of_others_may_have_fewer_fields(tmp_path: Path):
    """A column without cameras is read, and so is an answer that looks like endless JSON."""
    source = open_dataset(new_dataset(tmp_path / "set", language=False))
    (file,) = data_files(source)
    table = pq.read_table(file)
    names = ("role", "content", "style")
    kind = pa.list_(pa.struct([(name, pa.string()) for name in names]))
    rows = [("user", "What is it?", "vqa"), ("assistant", "[" * 100_000, "vqa")]
    said = [dict(zip(names, row, strict=True)) for row in rows]
    cells = pa.array([said, *[[]] * (len(table) - 1)], kind)
    pq.write_table(table.append_column("language_events", cells), file)
    made = study_input(source, tmp_path / "tables")
    assert made.rows["moments.csv"] == 1
    language = {0: EpisodeLanguage((Language("interjection", 0.0, "Lift it."),))}
    assert write_language(source, tmp_path / "copy", language, attachments={}) == []
    first = next(rows for _, _, rows in event_rows(open_dataset(tmp_path / "copy")))
    assert [row["style"] for row in first] == ["interjection", "vqa", "vqa"]
