"""Language in a copy of a dataset: exact frames, and nothing else is touched."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pyarrow", reason="the extra `parquet` is not installed")
pytest.importorskip("av", reason="the extra `render` is not installed")

import pyarrow as pa
import pyarrow.parquet as pq

from corpus_tools.lerobot.episode_reading import data_files, open_dataset
from corpus_tools.lerobot.language_rows import Language, persistent_rows
from corpus_tools.lerobot.language_writing import EpisodeLanguage, write_language
from g3.errors import FormatError
from tests.lerobot_datasets import LANGUAGE, new_dataset, old_dataset, said

STEPS = (Language("subtask", 0.0, "reach for it"), Language("subtask", 0.32, "take it"))
PEOPLE = {
    0: EpisodeLanguage(
        (*STEPS, Language("task_aug", 0.0, "Take the cube.")),
        frozenset({"subtask", "plan"}),
        "Take the cube.",
    ),
    2: EpisodeLanguage((Language("task_aug", 0.0, "Wait."),), task="Wait."),
}
CHANGED = {"language_persistent", "language_events"}


def content(column: pa.ChunkedArray) -> list[bytes | None]:
    """All buffers of a column, in one piece."""
    whole = column.combine_chunks()
    whole = pa.concat_arrays([whole, whole.slice(0, 0)]) if whole.offset else whole
    return [None if buffer is None else buffer.to_pybytes() for buffer in whole.buffers()]


@pytest.mark.parametrize("language", [True, False], ids=["with language", "without"])
def test_other_columns_are_the_same_byte_for_byte(tmp_path: Path, language: bool):
    source = open_dataset(new_dataset(tmp_path / "set", language=language))
    write_language(source, tmp_path / "copy", PEOPLE, attachments={})
    (before,), (after,) = (
        [pq.ParquetFile(f) for f in data_files(open_dataset(folder))]
        for folder in (tmp_path / "set", tmp_path / "copy")
    )
    assert after.num_row_groups == before.num_row_groups
    old, new = before.read(), after.read()
    assert set(new.column_names) == set(old.column_names) | CHANGED
    assert new.schema.metadata[b"mine"] == b"kept"
    for name in set(old.column_names) - CHANGED - {"task_index"}:
        assert new.schema.field(name).equals(old.schema.field(name), check_metadata=True)
        assert content(new.column(name)) == content(old.column(name)), name
    if language:
        assert new.column("language_events").equals(old.column("language_events"))
    else:
        assert new.column("language_events").to_pylist() == [[]] * len(new)
    kept = np.array(old.column("episode_index")) != 2
    for table in (old, new):
        assert np.array(table.column("task_index"))[kept].tolist() == [0] * kept.sum()


def test_the_rest_of_the_dataset_stays(tmp_path: Path):
    source = new_dataset(tmp_path / "set")
    extra = {"meta/people.jsonl": b"{}\n"}
    write_language(open_dataset(source), tmp_path / "copy", PEOPLE, attachments=extra)
    names = {f.relative_to(source).as_posix() for f in source.rglob("*") if f.is_file()}
    copied = {
        f.relative_to(tmp_path / "copy").as_posix()
        for f in (tmp_path / "copy").rglob("*")
        if f.is_file()
    }
    assert copied == names | set(extra)
    for name in names:
        one, other = source / name, tmp_path / "copy" / name
        if name.startswith("videos"):
            assert one.samefile(other)  # linked: no space is taken
        elif name == "meta/stats.json":
            assert one.read_bytes() == other.read_bytes()
            assert not one.samefile(other)
    told, was = (
        json.loads((f / "meta/info.json").read_text()) for f in (tmp_path / "copy", source)
    )
    assert told == was | {"total_tasks": 3}
    assert list(tmp_path.glob(".*")) == [] or all(
        p.name.endswith(".lock") for p in tmp_path.glob(".*")
    )


def test_language_is_on_exact_frames_of_every_row(tmp_path: Path):
    source = open_dataset(new_dataset(tmp_path / "set"))
    write_language(source, tmp_path / "copy", PEOPLE, attachments={})
    copy = open_dataset(tmp_path / "copy")
    table = pq.read_table(data_files(copy)[0]).to_pydict()
    found = dict(persistent_rows(copy))
    assert found[0] == [
        said("plan", 0.0, "1. reach for it\n2. take it"),
        said("subtask", 0.0, "reach for it"),
        said("task_aug", 0.0, "Push the cube."),  # the dataset's own task comes first
        said("task_aug", 0.0, "Take the cube."),
        said("plan", 0.3, "1. take it"),
        said("subtask", 0.3, "take it"),
        said("memory", 0.5, "it was near"),  # other styles stay
    ]
    assert found[1] == LANGUAGE[1]
    assert found[2] == [said("task_aug", 0.0, "Wait.")]
    for episode, rows in zip(table["episode_index"], table["language_persistent"], strict=True):
        assert rows == found[episode]
    times = {np.float32(time) for time in table["timestamp"]}
    assert {np.float32(row["timestamp"]) for row in found[0]} <= times


def test_episodes_without_a_task_get_one(tmp_path: Path):
    source = open_dataset(new_dataset(tmp_path / "set"))
    write_language(source, tmp_path / "copy", PEOPLE, attachments={})
    tasks = [episode.tasks for episode in open_dataset(tmp_path / "copy").episodes()]
    assert tasks == [("Push the cube.",), ("Push the cube.",), ("Wait.",)]
    known = pq.read_table(tmp_path / "copy/meta/tasks.parquet").to_pylist()
    assert known[-1] == {"task_index": 2, "__index_level_0__": "Wait."}
    table = pq.read_table(data_files(open_dataset(tmp_path / "copy"))[0]).to_pydict()
    assert {
        task for e, task in zip(table["episode_index"], table["task_index"], strict=True) if e == 2
    } == {2}


def test_version_2_gets_language_and_tasks(tmp_path: Path):
    source = old_dataset(tmp_path / "set")
    write_language(open_dataset(source), tmp_path / "copy", PEOPLE, attachments={})
    copy = open_dataset(tmp_path / "copy")
    assert [e.tasks for e in copy.episodes()][2] == ("Wait.",)
    found = dict(persistent_rows(copy))
    assert [row["content"] for row in found[0] if row["style"] == "subtask"] == [
        "reach for it", "take it",
    ]  # fmt: skip
    assert found[1] == []
    lines = (tmp_path / "copy/meta/tasks.jsonl").read_text().splitlines()
    assert json.loads(lines[-1]) == {"task_index": 2, "task": "Wait."}
    last = pq.read_table(data_files(copy)[2])
    assert set(last.column("task_index").to_pylist()) == {2}


def test_huggings_face_own_metadata_names_the_new_columns(tmp_path: Path):
    datasets = pytest.importorskip("datasets", reason="datasets is not installed")
    source = old_dataset(tmp_path / "set")
    for file in data_files(open_dataset(source)):
        datasets.disable_progress_bars()
        datasets.Dataset(pq.read_table(file)).to_parquet(file)
    write_language(open_dataset(source), tmp_path / "copy", PEOPLE, attachments={})
    first = data_files(open_dataset(tmp_path / "copy"))[0]
    read = datasets.Dataset.from_parquet(str(first), cache_dir=str(tmp_path / "cache"))
    assert read[0]["language_persistent"][0]["content"] == "1. reach for it\n2. take it"


def test_the_copy_lies_elsewhere_and_replaces_only_datasets(tmp_path: Path):
    source = open_dataset(new_dataset(tmp_path / "set"))
    for target in (tmp_path / "set", tmp_path / "set" / "copy"):
        with pytest.raises(FormatError, match="in the dataset itself"):
            write_language(source, target, PEOPLE, attachments={}, force=True)
    write_language(source, tmp_path / "copy", PEOPLE, attachments={})
    with pytest.raises(FormatError, match="there already"):
        write_language(source, tmp_path / "copy", PEOPLE, attachments={})
    # What people say later is written from the same dataset again.
    write_language(source, tmp_path / "copy", {}, attachments={}, force=True)
    assert dict(persistent_rows(open_dataset(tmp_path / "copy"))) == LANGUAGE
