"""Corrected tasks and columns of the episodes' index in a copy; the rest stays byte for byte."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

pytest.importorskip("pyarrow", reason="the extra `parquet` is not installed")

import pyarrow as pa
import pyarrow.parquet as pq

from corpus_tools.lerobot.episode_index import IndexColumn
from corpus_tools.lerobot.episode_reading import open_dataset
from corpus_tools.lerobot.language_rows import Language, persistent_rows
from corpus_tools.lerobot.language_writing import EpisodeLanguage, write_language
from corpus_tools.lerobot.task_tables import task_table
from g3.errors import FormatError
from tests.lerobot_datasets import new_dataset, old_dataset

OLD = "Push the cube."
LIFT = EpisodeLanguage((), corrected={OLD: "Lift the cube."})


def copied(
    source: Path, said: dict[int, EpisodeLanguage], columns: tuple[IndexColumn, ...] = ()
) -> tuple[Path, list[str]]:
    copy = source.with_name("copy")
    return copy, write_language(
        open_dataset(source), copy, said, attachments={}, columns=columns, force=True
    )


def files(folder: Path) -> dict[str, bytes]:
    return {
        f.relative_to(folder).as_posix(): f.read_bytes() for f in folder.rglob("*") if f.is_file()
    }


def tasks(folder: Path) -> list[tuple[str, ...]]:
    return [episode.tasks for episode in open_dataset(folder).episodes()]


def frame_tasks(folder: Path) -> dict[int, set[str]]:
    """The tasks of the frames of each episode, as LeRobot looks them up."""
    texts = task_table(open_dataset(folder)).texts
    found: dict[int, set[str]] = {}
    for file in sorted((folder / "data").rglob("*.parquet")):
        table = pq.read_table(file).select(["episode_index", "task_index"])
        for row in table.to_pylist():
            found.setdefault(row["episode_index"], set()).add(texts[row["task_index"]])
    return found


def test_a_correction_changes_one_episode_of_several_with_its_task(tmp_path: Path):
    source = new_dataset(tmp_path / "set", language=False)
    copy, notes = copied(source, {0: LIFT})
    assert notes == []
    assert tasks(copy) == [("Lift the cube.",), (OLD,), ()]
    assert frame_tasks(copy) == {0: {"Lift the cube."}, 1: {OLD}, 2: {""}}
    assert task_table(open_dataset(copy)).texts == {0: OLD, 1: "", 2: "Lift the cube."}
    assert json.loads((copy / "meta/info.json").read_text())["total_tasks"] == 3
    before, after = (pq.read_table(f / "data/chunk-000/file-000.parquet") for f in (source, copy))
    assert before.schema.equals(after.schema, check_metadata=True)  # no language was added
    assert before.drop_columns(["task_index"]).equals(after.drop_columns(["task_index"]))


def test_files_of_other_episodes_are_the_same_bytes(tmp_path: Path):
    source = old_dataset(tmp_path / "set")
    copy, _ = copied(source, {1: LIFT})
    before, after = files(source), files(copy)
    assert before.keys() == after.keys()
    assert {name for name in before if before[name] != after[name]} == {
        "meta/info.json", "meta/tasks.jsonl", "meta/episodes.jsonl",
        "data/chunk-000/episode_000001.parquet",
    }  # fmt: skip
    lines = [(f / "meta/episodes.jsonl").read_bytes().split(b"\n") for f in (source, copy)]
    assert [a == b for a, b in zip(*lines, strict=True)] == [True, False, True, True]
    assert (copy / "meta/tasks.jsonl").read_bytes().startswith(before["meta/tasks.jsonl"])
    assert frame_tasks(copy) == {0: {OLD}, 1: {"Lift the cube."}, 2: {""}}


def test_a_text_that_the_dataset_has_gets_its_number(tmp_path: Path):
    source = old_dataset(tmp_path / "set")
    one, _ = copied(source, {0: LIFT})
    again = one.rename(tmp_path / "again")
    copy, _ = copied(again, {1: LIFT, 0: EpisodeLanguage((), corrected={"Lift the cube.": OLD})})
    assert task_table(open_dataset(copy)).texts == {0: OLD, 1: "", 2: "Lift the cube."}
    assert frame_tasks(copy) == {0: {OLD}, 1: {"Lift the cube."}, 2: {""}}
    assert (copy / "meta/tasks.jsonl").read_bytes() == (again / "meta/tasks.jsonl").read_bytes()


def test_one_of_two_tasks_of_an_episode_is_corrected(tmp_path: Path):
    source = old_dataset(tmp_path / "set")
    tasks_file = source / "meta/tasks.jsonl"
    tasks_file.write_text(tasks_file.read_text() + '{"task_index": 2, "task": "Wave."}\n')
    index = source / "meta/episodes.jsonl"
    index.write_text(index.read_text().replace(f'["{OLD}"]', f'["{OLD}", "Wave."]', 1))
    data = source / "data/chunk-000/episode_000000.parquet"
    table = pq.read_table(data)
    numbers = pa.array([0] * 5 + [2] * (len(table) - 5), pa.int64())
    place = table.column_names.index("task_index")
    pq.write_table(table.set_column(place, "task_index", numbers), data)
    copy, _ = copied(source, {0: LIFT})
    assert tasks(copy)[0] == ("Lift the cube.", "Wave.")
    numbers = pq.read_table(copy / "data/chunk-000/episode_000000.parquet")["task_index"]
    assert numbers.to_pylist() == [3] * 5 + [2] * 7


def test_wordings_of_a_wrong_task_go_and_peoples_stay(tmp_path: Path):
    """LeRobot draws a task from its wordings, of which the task itself is the first."""
    source = new_dataset(tmp_path / "set")
    model = {0: EpisodeLanguage((Language("task_aug", 0.0, "Shove the cube."),))}
    write_language(open_dataset(source), tmp_path / "model", model, attachments={})
    person = Language("task_aug", 0.0, "Raise it.", {"study": "s"})
    people = {0: EpisodeLanguage((person,)), 1: EpisodeLanguage((person,))}
    write_language(open_dataset(tmp_path / "model"), tmp_path / "both", people, attachments={})
    said = Language("task_aug", 0.0, "Take it up.", {"study": "t"})
    copy, notes = copied(tmp_path / "both", {0: EpisodeLanguage((said,), corrected=LIFT.corrected)})
    assert notes == ["episode 0: 'Shove the cube.' rewords a wrong task: left out"]
    wordings = {
        index: [row["content"] for row in rows if row["style"] == "task_aug"]
        for index, rows in persistent_rows(open_dataset(copy))
    }
    assert wordings == {
        0: ["Lift the cube.", "Raise it.", "Take it up."], 1: [OLD, "Raise it."], 2: [],
    }  # fmt: skip
    sources = [json.loads(line) for line in (copy / "meta/people.jsonl").read_text().splitlines()]
    assert [row["content"] for row in sources] == ["Raise it.", "Raise it.", "Take it up."]


def test_a_task_that_the_dataset_no_longer_has_is_named(tmp_path: Path):
    copy, notes = copied(
        new_dataset(tmp_path / "set"), {0: EpisodeLanguage((), corrected={"Wave.": "Nod."})}
    )
    assert notes == ["episode 0: the task 'Wave.' is no longer its own"]
    assert files(copy).keys() == files(tmp_path / "set").keys()
    assert tasks(copy)[0] == (OLD,)


COLUMNS = (
    IndexColumn("marks/success", "text", {0: "failure", 2: None}),
    IndexColumn("marks/quality", "number", {0: 1.5, 2: 4.0}),
    IndexColumn("marks/reasons", "texts", {0: ["It drops"], 2: []}),
    IndexColumn("marks/people", "count", {0: 3, 2: 1}),
)


def test_columns_of_the_index(tmp_path: Path):
    source = new_dataset(tmp_path / "set")
    copy, _ = copied(source, {}, COLUMNS)
    before, after = files(source), files(copy)
    name = "meta/episodes/chunk-000/file-000.parquet"
    assert {file for file in after if before.get(file) != after[file]} == {name}
    tables = [pq.read_table(folder / name) for folder in (source, copy)]
    assert tables[0].equals(tables[1].select(tables[0].column_names))
    assert tables[1].select([one.name for one in COLUMNS]).to_pylist() == [
        {"marks/success": "failure", "marks/quality": 1.5, "marks/reasons": ["It drops"],
         "marks/people": 3},
        dict.fromkeys(one.name for one in COLUMNS),
        {"marks/success": None, "marks/quality": 4.0, "marks/reasons": [], "marks/people": 1},
    ]  # fmt: skip
    # Later marks replace earlier ones, and the others stay.
    shutil.move(copy, tmp_path / "first")
    again, _ = copied(
        tmp_path / "first", {1: LIFT}, (IndexColumn("marks/success", "text", {1: "partly"}),)
    )
    assert pq.read_table(again / name)["marks/success"].to_pylist() == ["failure", "partly", None]
    assert pq.read_table(again / name)["tasks"].to_pylist()[1] == ["Lift the cube."]
    assert pq.read_table(again / name)["marks/people"].to_pylist() == [3, None, 1]


def test_columns_of_an_old_index(tmp_path: Path):
    source = old_dataset(tmp_path / "set")
    copy, _ = copied(source, {}, COLUMNS)
    rows = [json.loads(line) for line in (copy / "meta/episodes.jsonl").read_text().splitlines()]
    assert rows[0] == {
        "episode_index": 0, "tasks": [OLD], "length": 12, "marks/success": "failure",
        "marks/quality": 1.5, "marks/reasons": ["It drops"], "marks/people": 3,
    }  # fmt: skip
    assert rows[1].keys() == {"episode_index", "tasks", "length"}
    assert tasks(copy) == tasks(source)


def test_columns_of_no_episode_are_refused(tmp_path: Path):
    with pytest.raises(FormatError, match="no episode 9"):
        copied(new_dataset(tmp_path / "set"), {}, (IndexColumn("x", "count", {9: 1}),))
