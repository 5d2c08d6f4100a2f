"""Language in a copy of a dataset: exact frames, and nothing else is touched."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pyarrow", reason="the extra `parquet` is not installed")
pytest.importorskip("av", reason="the extra `render` is not installed")

import pyarrow as pa
import pyarrow.parquet as pq

from corpus_tools.lerobot.episode_frames import checked_episodes
from corpus_tools.lerobot.episode_reading import data_files, open_dataset
from corpus_tools.lerobot.grounded_answers import Answer, Shape
from corpus_tools.lerobot.language_rows import Language, event_rows, persistent_rows
from corpus_tools.lerobot.language_writing import EpisodeLanguage, write_language
from corpus_tools.lerobot.study_input import study_input
from g3.errors import FormatError
from tests.lerobot_datasets import (
    CAMERA,
    LANGUAGE,
    ROW,
    WRIST,
    new_dataset,
    old_dataset,
    said,
    write_lines,
)
from tests.shared_cases import case

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


def test_version_2_gets_tasks_and_a_file_of_language(tmp_path: Path):
    """Its readers refuse columns that they don't know, so frames are the same byte for byte."""
    source = open_dataset(old_dataset(tmp_path / "set"))
    language = dict(PEOPLE)
    speech = Language("interjection", 0.42, "Wait!", {"who": "p"}, reply="Yes.")
    language[0] = replace(language[0], said=(*language[0].said, speech))
    write_language(source, tmp_path / "copy", language, attachments={})
    copy = open_dataset(tmp_path / "copy")
    assert [e.tasks for e in copy.episodes()][2] == ("Wait.",)
    found = dict(persistent_rows(copy))
    assert [row["content"] for row in found[0] if row["style"] == "subtask"] == [
        "reach for it", "take it",
    ]  # fmt: skip
    assert 1 not in found
    ((index, frame, rows),) = event_rows(copy)
    assert (index, frame, [row["content"] for row in rows]) == (0, 4, [None, "Wait!"])
    assert rows[0]["tool_calls"][0]["function"]["arguments"] == {"text": "Yes."}
    assert "language_persistent" not in copy.info.features
    lines = (tmp_path / "copy/meta/tasks.jsonl").read_text().splitlines()
    assert json.loads(lines[-1]) == {"task_index": 2, "task": "Wait."}
    before, after = data_files(source), data_files(copy)
    assert [one.read_bytes() for one in after[:2]] == [one.read_bytes() for one in before[:2]]
    last = pq.read_table(after[2])
    assert set(last.column("task_index").to_pylist()) == {2}
    assert last.column_names == pq.read_table(before[2]).column_names
    # The copy is input of a study, and can be corrected in turn.
    cut = EpisodeLanguage((Language("subtask", 0.0, "grab"),), frozenset({"subtask", "plan"}))
    write_language(copy, tmp_path / "again", {0: cut}, attachments={})
    again = open_dataset(tmp_path / "again")
    of_first = dict(persistent_rows(again))[0]
    assert [row["content"] for row in of_first if row["style"] == "subtask"] == ["grab"]
    assert {"task_aug", "plan"} <= {row["style"] for row in of_first}
    assert [list(one) for one in event_rows(again)] == [[0, 4, rows]]


@pytest.mark.parametrize(
    ("more", "where"),
    [
        ({"content": ["reach"], "timestamp": 0}, "row 1, column content"),
        ({"content": "reach", "timestamp": "0"}, "row 1, column timestamp"),
        ({"content": "reach", "frame_index": -1}, "row 1, column frame_index"),
    ],
)
def test_a_damaged_file_of_language_names_its_row(
    tmp_path: Path, more: dict[str, object], where: str
):
    folder = old_dataset(tmp_path / "set")
    write_lines(folder / "meta/language.jsonl", [{"episode_index": 0, "style": "subtask", **more}])
    with pytest.raises(FormatError, match=where):
        list(persistent_rows(open_dataset(folder)))
    with pytest.raises(FormatError, match=where):
        study_input(open_dataset(folder), tmp_path)


def test_huggings_face_own_metadata_names_the_new_columns(tmp_path: Path):
    datasets = pytest.importorskip("datasets", reason="datasets is not installed")
    source = new_dataset(tmp_path / "set", language=False)
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


def subtasks(folder: Path, episode: int = 0) -> list[tuple[float, str]]:
    rows = dict(persistent_rows(open_dataset(folder)))[episode]
    return [(r["timestamp"], r["content"]) for r in rows if r["style"] == "subtask"]


def test_steps_on_one_frame_are_kept_apart_and_named(tmp_path: Path):
    source = open_dataset(new_dataset(tmp_path / "set"))
    steps = tuple(
        Language("subtask", start_s, text, {"answer": "a"})
        for start_s, text in ((0.0, "reach"), (0.51, "take"), (0.53, "lift"), (9.0, "late"))
    )
    people = {0: EpisodeLanguage(steps, frozenset({"subtask", "plan"}))}
    notes = write_language(source, tmp_path / "copy", people, attachments={})
    assert subtasks(tmp_path / "copy") == [
        (0.0, "reach"), (0.5, "take"), (pytest.approx(0.6), "lift"),
    ]  # fmt: skip
    assert len(notes) == 2
    assert any("'lift'" in note and "0.53 s" in note for note in notes)
    assert any("'late'" in note and "outside" in note for note in notes)
    # What people said is there as they said it, with the frame where it is written.
    lines = (tmp_path / "copy/meta/people.jsonl").read_text().splitlines()
    assert [(r["start_s"], r["content"], r["timestamp"]) for r in map(json.loads, lines)] == [
        (0.0, "reach", 0.0), (0.51, "take", 0.5), (0.53, "lift", pytest.approx(0.6)),
        (9.0, "late", None),
    ]  # fmt: skip


def test_language_of_episodes_that_are_not_there_is_named(tmp_path: Path):
    source = open_dataset(new_dataset(tmp_path / "set"))
    step = Language("subtask", 0.0, "reach", {"answer": "a"})
    people = {0: EpisodeLanguage((step,)), 77: EpisodeLanguage((step,))}
    (note,) = write_language(source, tmp_path / "copy", people, attachments={})
    assert "episode 77" in note
    lines = (tmp_path / "copy/meta/people.jsonl").read_text().splitlines()
    rows = [json.loads(line) for line in lines]
    assert [(row["episode_index"], row["timestamp"]) for row in rows] == [(0, 0.0), (77, None)]
    with pytest.raises(FormatError, match="no episode 77"):
        write_language(source, tmp_path / "other", {77: people[77]}, attachments={})


def test_earlier_people_stay_in_the_provenance(tmp_path: Path):
    def asked(source: Path, target: Path, who: str) -> None:
        said = EpisodeLanguage((Language("task_aug", 0.0, f"Said by {who}.", {"subject": who}),))
        write_language(open_dataset(source), target, {0: said}, attachments={})

    asked(new_dataset(tmp_path / "set"), tmp_path / "one", "a")
    asked(tmp_path / "one", tmp_path / "two", "b")
    lines = (tmp_path / "two/meta/people.jsonl").read_text().splitlines()
    assert [json.loads(line)["subject"] for line in lines] == ["a", "b"]
    rows = dict(persistent_rows(open_dataset(tmp_path / "two")))[0]
    assert [row["content"] for row in rows if row["style"] == "task_aug"] == [
        "Push the cube.", "Said by a.", "Said by b.",
    ]  # fmt: skip


@pytest.mark.parametrize(
    "kind",
    [
        pa.null(),
        pa.list_(pa.null()),
        pa.list_(pa.struct([(n, pa.null()) for n in ("role", "content", "style", "timestamp")])),
        pa.large_list(pa.null()),
    ],
    ids=str,
)
def test_a_column_of_nulls_gets_a_type(kind: pa.DataType, tmp_path: Path):
    """Such are written where a model answered questions only."""
    source = new_dataset(tmp_path / "set", language=False)
    (file,) = data_files(open_dataset(source))
    table = pq.read_table(file)
    values = [None] * len(table) if pa.types.is_null(kind) else [[]] * len(table)
    pq.write_table(table.append_column("language_persistent", pa.array(values, kind)), file)
    write_language(open_dataset(source), tmp_path / "copy", PEOPLE, attachments={})
    assert subtasks(tmp_path / "copy") == [(0.0, "reach for it"), (pytest.approx(0.3), "take it")]
    again = open_dataset(tmp_path / "copy")
    write_language(again, tmp_path / "second", PEOPLE, attachments={})
    assert subtasks(tmp_path / "second") == subtasks(tmp_path / "copy")


@pytest.mark.parametrize(
    "column",
    [
        pa.array(["text"] * 30),
        pa.array([[{"role": "user", "content": "no style or time"}]] * 30),
        pa.array([[said("subtask", 0.0, "x") | {"timestamp": "soon"}]] * 30),
        pa.array([[said("subtask", 0.0, "x") | {"timestamp": float("nan")}]] * 30),
    ],
    ids=["texts", "no times", "times that are texts", "no numbers"],
)
def test_language_of_another_form_is_refused_before_anybody_is_asked(
    column: pa.Array, tmp_path: Path
):
    source = new_dataset(tmp_path / "set", language=False)
    (file,) = data_files(open_dataset(source))
    pq.write_table(pq.read_table(file).append_column("language_persistent", column), file)
    with pytest.raises(FormatError, match="language_persistent") as error:
        study_input(open_dataset(source), tmp_path / "tables")
    assert file.name in str(error.value)


def test_tool_calls_stay_as_they_are(tmp_path: Path):
    """As JSON of Arrow, the type that LeRobot documents, and as the records that it writes."""
    call = {"type": "function", "function": {"name": "say", "arguments": {"text": "hi"}}}
    head = [("role", pa.string()), ("content", pa.string()), ("style", pa.string())]
    tail = [("timestamp", pa.float32()), ("camera", pa.string())]

    def kind(leaf: pa.DataType) -> pa.DataType:
        return pa.list_(pa.struct([*head, *tail, ("tool_calls", pa.list_(leaf))]))

    row = said("memory", 0.0, "near")
    as_json = pa.array([[row | {"tool_calls": [json.dumps(call)]}]] * 30, kind(pa.string()))
    columns = [pa.array([[row | {"tool_calls": [call]}]] * 30)]
    columns += [as_json.cast(kind(pa.json_()))] if hasattr(pa, "json_") else []
    for number, column in enumerate(columns):
        source = new_dataset(tmp_path / str(number), language=False)
        (file,) = data_files(open_dataset(source))
        pq.write_table(pq.read_table(file).append_column("language_persistent", column), file)
        study_input(open_dataset(source), tmp_path / "tables")
        target = tmp_path / f"{number}-copy"
        write_language(open_dataset(source), target, PEOPLE, attachments={})
        found = dict(persistent_rows(open_dataset(target)))
        for rows in found.values():
            (memory,) = (row for row in rows if row["style"] == "memory")
            (kept,) = memory["tool_calls"]
            assert (json.loads(kept) if isinstance(kept, str) else kept) == call
        assert [text for _, text in subtasks(target)] == ["reach for it", "take it"]


def test_tasks_of_a_dataset_without_any_are_written(tmp_path: Path):
    for make in (new_dataset, old_dataset):
        source = make(tmp_path / make.__name__)
        for name in ("tasks.parquet", "tasks.jsonl"):
            (source / "meta" / name).unlink(missing_ok=True)
        for file in source.glob("meta/episodes/*/*.parquet"):
            pq.write_table(pq.read_table(file).drop_columns(["tasks"]), file)
        lines = [{"episode_index": n, "length": m} for n, m in enumerate((12, 8, 10))]
        if make is old_dataset:
            write_lines(source / "meta/episodes.jsonl", lines)
        target = tmp_path / f"{make.__name__}-copy"
        write_language(open_dataset(source), target, PEOPLE, attachments={})
        tasks = [one.episode.tasks for one in checked_episodes(open_dataset(target))]
        assert tasks == [("Take the cube.",), (), ("Wait.",)]


@pytest.mark.parametrize(
    "name",
    ["04-lerobot-first/dataset", "05-lerobot-long-video/dataset",
     "06-lerobot-no-tasks-column/dataset", "07-lerobot-tasks-two-columns/dataset",
     "08-lerobot-types/float-index", "08-lerobot-types/none-task", "08-lerobot-types/string-task"],
)  # fmt: skip
def test_published_layouts_come_out_as_they_went_in(name: str, tmp_path: Path):
    source = open_dataset(case(name))
    language = {n: EpisodeLanguage((*STEPS,), task=f"Task {n}.") for n in range(2)}
    assert write_language(source, tmp_path / "copy", language, attachments={}) == []
    copy = open_dataset(tmp_path / "copy")
    before, after = (list(checked_episodes(d)) for d in (source, copy))
    assert [one.length_s for one in after] == [one.length_s for one in before]
    for old, new in zip(before, after, strict=True):
        index = old.episode.index
        assert new.episode.tasks == (
            old.episode.tasks or ((f"Task {index}.",) if index < 2 else ())
        )
    assert [text for _, text in subtasks(tmp_path / "copy")] == ["reach for it", "take it"]


def events_in(folder: Path) -> dict[tuple[int, int], list[tuple[str, str | None, str | None]]]:
    """The role, style and content of the events, by episode and frame."""
    return {
        (episode, frame): [(row["role"], row["style"], row["content"]) for row in rows]
        for episode, frame, rows in event_rows(open_dataset(folder))
    }


EVENTS = {
    0: EpisodeLanguage(
        (
            *STEPS,
            Language("interjection", 0.5, "Now lift it.", {"answer": 7}, reply="On it."),
            Language("vqa", 0.1, "Where is it?", camera=CAMERA,
                     answer=Answer("point", ("cube",), (Shape(((9.6, 3.2),)),))),
            Language("vqa", 0.12, "Is it red?", camera=CAMERA, answer=Answer("words", ("yes",))),
            Language("vqa", 0.1, "How many?", camera=WRIST, answer=Answer("count", ("cube", "2"))),
            Language("trace", 1.1, "hand", camera=CAMERA,
                     answer=Answer("path", ("hand",), (Shape(((0, 0), (5, 5), (64, 48))),))),
            Language("memory", 0.7, "I took it."),
        ),
        frozenset({"subtask", "plan", "memory"}),
    )
}  # fmt: skip


@pytest.mark.parametrize("language", [True, False], ids=["with language", "without"])
def test_events_are_on_their_exact_frames(tmp_path: Path, language: bool):
    source = open_dataset(new_dataset(tmp_path / "set", language=language))
    notes = write_language(source, tmp_path / "copy", EVENTS, attachments={})
    assert any("'Is it red?' isn't written: there is another one at 0.1 s" in n for n in notes)
    assert any("people's text replaces 1 of the dataset's" in n for n in notes) is language
    point = '{"label": "cube", "point": [10, 3], "point_format": "xy"}'
    path = '{"label": "hand", "point_format": "xy", "points": [[0, 0], [5, 5], [64, 48]]}'
    there = {(e, 1): [("user", "vqa", "where?")] for e in (1, 2)} if language else {}
    assert events_in(tmp_path / "copy") == there | {
        (0, 1): [
            ("assistant", "vqa", point),
            ("assistant", "vqa", '{"count": 2, "label": "cube"}'),
            ("user", "vqa", "Where is it?"),
            ("user", "vqa", "How many?"),
        ],
        (0, 5): [("assistant", None, None), ("user", "interjection", "Now lift it.")],
        (0, 11): [("assistant", "trace", path)],
    }
    rows = [row for *_, rows in event_rows(open_dataset(tmp_path / "copy")) for row in rows]
    assert all("timestamp" not in row for row in rows)
    assert {row["camera"] for row in rows if row["style"] in ("vqa", "trace")} == {CAMERA, WRIST}
    (call,) = [call for row in rows for call in row["tool_calls"] or ()]
    assert call == {
        "type": "function", "function": {"name": "say", "arguments": {"text": "On it."}},
    }  # fmt: skip
    persistent = dict(persistent_rows(open_dataset(tmp_path / "copy")))[0]
    plan = [(round(r["timestamp"], 6), r["content"]) for r in persistent if r["style"] == "plan"]
    assert plan == [(0.0, "1. reach for it\n2. take it"), (0.3, "1. take it"), (0.5, "1. take it")]
    memory = [(r["role"], r["content"]) for r in persistent if r["style"] == "memory"]
    assert memory == [("assistant", "I took it.")]
    info = json.loads((tmp_path / "copy/meta/info.json").read_text())
    assert [tool["function"]["name"] for tool in info["tools"]] == ["say"]
    lines = (tmp_path / "copy/meta/people.jsonl").read_text().splitlines()
    (kept,) = map(json.loads, lines)
    assert (kept["reply"], kept["answer"], kept["timestamp"]) == ("On it.", 7, 0.5)


@pytest.mark.parametrize(
    ("language", "why"),
    [
        (Language("vqa", 0.1, "Where?", camera="mine", answer=Answer("words", ("a",))), "camera"),
        (Language("vqa", 0.1, "Where?", answer=Answer("words", ("here",))), "names no camera"),
        (Language("vqa", 0.1, "Where?", camera=CAMERA), "no answer"),
        (Language("vqa", 0.1, "Where?", camera=CAMERA, answer=Answer("words", (" ",))), "answer"),
        (Language("vqa", 0.1, "How many?", camera=CAMERA, answer=Answer("count", ("a", "two"))),
         "no whole number"),
        (Language("vqa", 0.1, "Where?", camera=CAMERA,
                  answer=Answer("point", ("cube",), (Shape(((64.5, 3),)),))), "outside of the pic"),
        (Language("vqa", 0.1, "Where?", camera=CAMERA,
                  answer=Answer("boxes", (), (Shape(((0, 0), (9, 9))),))), "a box has no name"),
        (Language("trace", 0.1, "hand", camera=CAMERA, answer=Answer("path", ("hand",))),
         "nothing is drawn"),
        (Language("memory", 0.1, "I took it.", camera=CAMERA), "names a camera"),
        (Language("memory", 0.1, "…"), "no text"),
        (Language("vqa", 5.0, "Where?", camera=CAMERA, answer=Answer("words", ("a",))), "outside"),
        (Language("poem", 0.1, "Oh."), "no such style"),
    ],
)  # fmt: skip
def test_what_breaks_a_rule_is_named_and_not_written(tmp_path: Path, language: Language, why: str):
    source = open_dataset(new_dataset(tmp_path / "set", language=False))
    said = {0: EpisodeLanguage((language,))}
    (note,) = write_language(source, tmp_path / "copy", said, attachments={})
    assert why in note
    assert events_in(tmp_path / "copy") == {}
    assert dict(persistent_rows(open_dataset(tmp_path / "copy")))[0] == []


@pytest.mark.parametrize(
    "kind",
    [pa.null(), pa.list_(pa.null()), "text", "json", pa.list_(pa.struct(ROW))],
    ids=["null", "nulls", "text", "json", "no camera"],
)
def test_events_fit_the_column_that_is_there(tmp_path: Path, kind: pa.DataType | str):
    source = open_dataset(new_dataset(tmp_path / "set", language=False))
    (file,) = data_files(source)
    if isinstance(kind, str):
        call = pa.string() if kind == "text" else pa.json_()
        text = pa.string()
        row = [("role", text), ("content", text), ("style", text), ("camera", text)]
        kind = pa.list_(pa.struct([*row, ("tool_calls", pa.list_(call))]))
    table = pq.read_table(file)
    empty = pa.nulls(len(table), kind)
    pq.write_table(table.append_column("language_events", empty), file, row_group_size=7)
    assert len(write_language(source, tmp_path / "copy", EVENTS, attachments={})) == 1
    rows = {(e, f): rows for e, f, rows in event_rows(open_dataset(tmp_path / "copy"))}
    (call,) = rows[0, 5][0]["tool_calls"]
    call = json.loads(call) if isinstance(call, str) else call
    assert call["function"]["arguments"] == {"text": "On it."}
    assert rows[0, 5][1]["content"] == "Now lift it."
    assert any(row["camera"] == CAMERA for of_frame in rows.values() for row in of_frame)
