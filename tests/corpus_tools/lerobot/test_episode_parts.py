"""People see an episode's frames and no others, as the metadata have them and the data prove."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("pyarrow", reason="the extra `parquet` is not installed")
pytest.importorskip("av", reason="the extra `render` is not installed")

import pyarrow as pa
import pyarrow.parquet as pq

from corpus_tools.cli.console import run
from corpus_tools.episodes.study_tables import StudyInput
from corpus_tools.lerobot.episode_reading import open_dataset
from corpus_tools.lerobot.study_input import study_input
from corpus_tools.video.probe import probe
from g3.errors import FormatError
from tests.lerobot_datasets import (
    CAMERA,
    FPS,
    WRIST,
    film,
    image_dataset,
    new_dataset,
    old_dataset,
    said,
    shade,
    write_lines,
)
from tests.shared_cases import case

EPISODES = "meta/episodes/chunk-000/file-000.parquet"
DATA = "data/chunk-000/file-000.parquet"


def rows(made: StudyInput, name: str) -> list[dict[str, str]]:
    return list(csv.DictReader(bytes(made.files[name]).decode().splitlines()))


def parts(made: StudyInput) -> list[tuple[float, float]]:
    """The parts of episodes; a whole file is from 0 to 0."""
    return [
        (float(row["start_s"] or 0), float(row["end_s"] or 0)) for row in rows(made, "episodes.csv")
    ]


def tables(folder: Path, **options: Any) -> StudyInput:
    return study_input(open_dataset(folder), folder.parent / "out", **options)


def edit(file: Path, change: Callable[[list[dict[str, Any]]], Any]) -> None:
    """Change the rows of a Parquet file; columns may come and go."""
    table = pq.read_table(file).to_pylist()
    change(table)
    pq.write_table(pa.Table.from_pylist(table), file)


def told(folder: Path, change: Callable[[dict[str, Any]], Any]) -> None:
    file = folder / "meta/info.json"
    info = json.loads(file.read_text())
    change(info)
    file.write_text(json.dumps(info))


def test_the_first_episode_of_a_file_is_no_more_than_that(tmp_path: Path):
    new_dataset(tmp_path / "set")
    assert parts(tables(tmp_path / "set", first=1)) == [(0.0, 1.2)]


@pytest.mark.parametrize("left", [0, 1, 2])
def test_one_episode_that_is_left_of_a_file(left: int, tmp_path: Path):
    folder = new_dataset(tmp_path / "set")
    edit(folder / EPISODES, lambda rows: rows.__setitem__(slice(None), [rows[left]]))
    assert parts(tables(folder)) == [[(0.0, 1.2), (1.2, 2.0), (2.0, 3.0)][left]]


def test_an_episode_with_a_file_of_its_own_is_not_cut(tmp_path: Path):
    assert parts(tables(new_dataset(tmp_path / "set", lengths=(12,)))) == [(0.0, 0.0)]


def test_a_video_that_goes_on_after_the_episode(tmp_path: Path):
    folder = old_dataset(tmp_path / "set")
    film(folder / f"videos/chunk-000/{CAMERA}/episode_000001.mp4", [90] * 23)
    made = tables(folder)
    assert parts(made) == [(0.0, 0.0), (0.0, 0.8), (0.0, 0.0)]
    assert any("go on after their frames" in note and "1" in note for note in made.notes)


def test_a_stated_end_after_the_frames(tmp_path: Path):
    """LeRobot's converter takes the length of a video for that of an episode."""
    folder = new_dataset(tmp_path / "set", lengths=(12, 8))

    def longer(rows: list[dict[str, Any]]) -> None:
        rows[1][f"videos/{CAMERA}/to_timestamp"] = 9.0

    edit(folder / EPISODES, longer)
    made = tables(folder)
    assert parts(made) == [(0.0, 1.2), (1.2, 2.0)]
    assert any("go on" in note for note in made.notes)


def test_a_video_without_the_episodes_frames_is_named(tmp_path: Path):
    folder = new_dataset(tmp_path / "set")
    film(folder / f"videos/{CAMERA}/chunk-000/file-000.mp4", [90] * 17)
    with pytest.raises(FormatError, match="2 things are wrong") as error:
        tables(folder)
    assert "episode 1: 3 of its 8 frames" in str(error.value)
    assert "episode 2: 10 of its 10 frames" in str(error.value)
    made = tables(folder, keep_going=True)
    assert parts(made) == [(0.0, 1.2)]
    assert len([note for note in made.notes if note.startswith("left out")]) == 2
    assert made.rows["subtasks.csv"] == 2


def test_a_video_that_is_cut_off_is_named(tmp_path: Path):
    folder = old_dataset(tmp_path / "set")
    file = folder / f"videos/chunk-000/{CAMERA}/episode_000001.mp4"
    file.write_bytes(file.read_bytes()[:-300])
    with pytest.raises(FormatError, match=r"episode_000001\.mp4"):
        tables(folder)


def test_a_video_of_more_frames_a_second_than_the_data(tmp_path: Path):
    """LeRobot takes the frame at each time of the data; people see all of them."""
    folder = old_dataset(tmp_path / "set", lengths=(12,))
    told(folder, lambda info: info.update(fps=5))
    data = folder / "data/chunk-000/episode_000000.parquet"
    table = pq.read_table(data)
    stamps = pa.array((np.arange(12) / 5).astype(np.float32))
    pq.write_table(
        table.set_column(table.column_names.index("timestamp"), "timestamp", stamps), data
    )
    film(folder / f"videos/chunk-000/{CAMERA}/episode_000000.mp4", [9] * 24)  # 10 a second
    assert parts(tables(folder)) == [(0.0, 0.0)]
    film(folder / f"videos/chunk-000/{CAMERA}/episode_000000.mp4", [9] * 12)
    with pytest.raises(FormatError, match="of its 12 frames are not in the video"):
        tables(folder)


def test_cameras_of_different_lengths(tmp_path: Path):
    folder = old_dataset(tmp_path / "set", lengths=(12,))
    told(folder, lambda i: i["features"].update({WRIST: i["features"][CAMERA]}))
    film(folder / f"videos/chunk-000/{WRIST}/episode_000000.mp4", [9] * 20)
    assert parts(tables(folder)) == [(0.0, 0.0)]
    assert parts(tables(folder, cameras=[WRIST])) == [(0.0, 1.2)]


@pytest.mark.parametrize("make", [new_dataset, old_dataset])
def test_an_episode_whose_length_the_data_contradict(make: Callable[..., Path], tmp_path: Path):
    folder = make(tmp_path / "set")
    if make is new_dataset:
        edit(folder / EPISODES, lambda rows: rows[1].update(length=9))
    else:
        file = folder / "meta/episodes.jsonl"
        lines = [json.loads(line) for line in file.read_text().splitlines()]
        lines[1]["length"] = 9
        write_lines(file, lines)
    with pytest.raises(FormatError, match="episode 1: its length is 9") as error:
        tables(folder)
    assert "has 8 frames" in error.value.what
    assert error.value.where.endswith("row 2")


def test_numbers_of_episodes_may_have_gaps_but_no_doubles(tmp_path: Path):
    folder = new_dataset(tmp_path / "set")
    numbers = pa.array([0] * 12 + [7] * 8 + [31] * 10, pa.int64())
    table = pq.read_table(folder / DATA)
    place = table.column_names.index("episode_index")
    pq.write_table(table.set_column(place, "episode_index", numbers), folder / DATA)

    def renumber(rows: list[dict[str, Any]]) -> None:
        for row, number in zip(rows, (0, 7, 31), strict=True):
            row["episode_index"] = number

    edit(folder / EPISODES, renumber)
    assert [row["episode"] for row in rows(tables(folder), "episodes.csv")] == ["0", "7", "31"]
    edit(folder / EPISODES, lambda rows: rows[2].update(episode_index=7))
    with pytest.raises(FormatError, match="episode 7 is also in") as error:
        tables(folder)
    assert "row 3, column episode_index" in error.value.where


def test_episodes_without_frames_are_left_out_and_named(tmp_path: Path):
    folder = new_dataset(tmp_path / "set")

    def add(rows: list[dict[str, Any]]) -> None:
        rows.append(dict.fromkeys(rows[0]) | {"episode_index": 3, "length": 0,
                    "data/chunk_index": 0, "data/file_index": 0})  # fmt: skip

    edit(folder / EPISODES, add)
    made = tables(folder)
    assert made.rows["episodes.csv"] == 3
    assert any("no frames" in note and "3" in note for note in made.notes)
    assert any("total_episodes" in note and "4" in note for note in made.notes)


@pytest.mark.parametrize(
    ("column", "value", "expected"),
    [
        ("episode_index", 1.0, True), ("length", 8.0, True), ("data/file_index", 0.0, True),
        (f"videos/{CAMERA}/chunk_index", 0.0, True), (f"videos/{CAMERA}/from_timestamp", 1.2, True),
        ("episode_index", 0.5, False), ("length", -8, False), ("data/chunk_index", None, False),
        ("length", 2**60, False), (f"videos/{CAMERA}/chunk_index", 0.5, False),
        (f"videos/{CAMERA}/from_timestamp", float("nan"), False),
        (f"videos/{CAMERA}/to_timestamp", None, False),
        (f"videos/{WRIST}/chunk_index", 0.5, True),  # nobody is shown this camera
    ],
)  # fmt: skip
def test_types_are_converted_or_refused(column: str, value: Any, expected: bool, tmp_path: Path):
    folder = new_dataset(tmp_path / "set")
    table = pq.read_table(folder / EPISODES)
    column_values = table.column(column).to_pylist()
    column_values[1] = value
    kind = pa.float64() if isinstance(value, float) else table.schema.field(column).type
    place = table.column_names.index(column)
    new = table.set_column(place, column, pa.array(column_values, kind))
    pq.write_table(new, folder / EPISODES)
    if expected:
        shown = tables(folder, cameras=[CAMERA])
        assert parts(shown) == [(0.0, 1.2), (1.2, 2.0), (2.0, 3.0)]
        return
    with pytest.raises(FormatError) as error:
        tables(folder)
    assert error.value.where.endswith(f"file-000.parquet, row 2, column {column}")


def test_times_of_frames_are_finite_and_increase(tmp_path: Path):
    folder = new_dataset(tmp_path / "set")
    table = pq.read_table(folder / DATA)
    place = table.column_names.index("timestamp")
    for row, time, what in ((14, np.nan, "no number"), (14, 0.1, "episode 1"), (0, -1.0, "0")):
        times = np.array(table.column("timestamp"), np.float32)
        times[row] = time
        new = table.set_column(place, "timestamp", pa.array(times))
        pq.write_table(new, folder / DATA, row_group_size=7)
        with pytest.raises(FormatError, match=what) as error:
            tables(folder)
        assert "timestamp" in str(error.value)
        if np.isnan(time):
            assert error.value.where.endswith("file-000.parquet, row 15, column timestamp")


@pytest.mark.parametrize(
    ("tasks", "expected"),
    [
        ([["Push."], ["Push."], ["Lift."]], ["Push.", "Push.", "Lift."]),
        (["Push.", "Push.", None], ["Push.", "Push."]),  # plain texts
        ([None, None, None], ["Push the cube.", "Push the cube."]),  # from the frames' task_index
        ([[None], [], ["Lift.", None]], ["Push the cube.", "Push the cube.", "Lift."]),
        ("none", ["Push the cube.", "Push the cube."]),  # no column at all
    ],
)
def test_tasks_may_be_missing(tasks: Any, expected: list[str], tmp_path: Path):
    folder = new_dataset(tmp_path / "set")
    table = pq.read_table(folder / EPISODES)
    place = table.column_names.index("tasks")
    new = table.remove_column(place)
    if tasks != "none":
        new = table.set_column(place, "tasks", pa.array(tasks))
    pq.write_table(new, folder / EPISODES)
    assert [row["command"] for row in rows(tables(folder), "tasks.csv")] == expected


@pytest.mark.parametrize(
    "columns",
    [
        {"task_index": [0, 1], "task": ["Go.", ""]},
        {"task_index": [0, 1], "__index_level_0__": ["Go.", ""]},
        {"task_index": [0.0, 1.0], "task": ["Go.", None], "__index_level_0__": ["Go.", None]},
        {"task_index": [0, 1], "__index_level_0__": [0, 1], "task": ["Go.", ""]},
        {"task": ["Go.", ""]},
        {"task_index": [1, 0], "name of the task": ["", "Go."]},
    ],
)
def test_tables_of_tasks(columns: dict[str, list[Any]], tmp_path: Path):
    folder = new_dataset(tmp_path / "set")
    edit(folder / EPISODES, lambda rows: [row.pop("tasks") for row in rows])
    pq.write_table(pa.table(columns), folder / "meta/tasks.parquet")
    assert [row["command"] for row in rows(tables(folder), "tasks.csv")] == ["Go.", "Go."]
    (folder / "meta/tasks.parquet").unlink()
    assert "tasks.csv" not in tables(folder).files


def test_subtasks_on_one_frame_are_both_shown(tmp_path: Path):
    folder = new_dataset(tmp_path / "set", language=False)
    table = pq.read_table(folder / DATA)
    language = [said("subtask", 0.0, "reach"), said("subtask", 0.5, "grasp"),
                said("subtask", 0.5, "lift"), said("subtask", 3.0, "late"),
                said("subtask", -0.5, "early")]  # fmt: skip
    pq.write_table(
        table.append_column("language_persistent", pa.array([language] * 30)), folder / DATA
    )
    made = tables(folder, first=1)
    found = [
        (row["command"], float(row["start_s"]), float(row["end_s"]))
        for row in rows(made, "subtasks.csv")
    ]
    assert found == [("reach", 0.0, 0.5), ("grasp", 0.5, 1.2), ("lift", 0.5, 1.2)]
    outside = [note for note in made.notes if "subtask" in note]
    assert len(outside) == 2
    assert any("'late' at 3 s" in note for note in outside)


@pytest.mark.parametrize("name", ["is_depth_map", "video.is_depth_map"])
@pytest.mark.parametrize("place", ["info", "video_info"])
def test_depth_cameras_are_not_chosen(name: str, place: str, tmp_path: Path):
    folder = new_dataset(tmp_path / "set")
    told(folder, lambda info: info["features"][CAMERA].update({place: {name: True}}))
    made = tables(folder)
    assert {row["camera"] for row in rows(made, "episodes.csv")} == {WRIST}
    made = tables(folder, cameras=[CAMERA])
    assert any("depth map" in note and CAMERA in note for note in made.notes)
    with pytest.raises(FormatError) as error:
        tables(folder, cameras=["top"])
    assert f"{CAMERA} (a depth map)" in error.value.fix
    told(folder, lambda info: info["features"][WRIST].update({place: {name: True}}))
    with pytest.raises(FormatError, match="all cameras are depth maps"):
        tables(folder)


@pytest.mark.parametrize("as_files", [False, True], ids=["in cells", "in files"])
def test_pictures_become_videos(as_files: bool, tmp_path: Path, capsys: Any):
    image_dataset(tmp_path / "set", as_files=as_files)
    out = tmp_path / "out"
    call = ["import", "lerobot", str(tmp_path / "set"), "--out", str(out)]
    assert run([*call, "--first", "2", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["rows"] == {"episodes.csv": 2, "tasks.csv": 2}
    table = list(csv.DictReader((out / "episodes.csv").read_text().splitlines()))
    for row, length in zip(table, (12, 8), strict=True):
        assert (row["start_s"], row["end_s"]) == ("", "")
        info = probe(out / row["video"])
        assert (len(info.frame_times), info.duration_s) == (length, pytest.approx(length / FPS))
        assert info.is_playable
    assert not list(tmp_path.glob(".lerobot-*"))
    first = grey_of(out / table[1]["video"])
    assert first == pytest.approx(shade(1, 0), abs=3)
    assert run(["annotate", "check", str(study(out))]) == 0


def study(tables: Path) -> Path:
    file = tables.parent / "study.yaml"
    tasks = {"describe": {"answers": 1, "practice": False}}
    content = {"name": "s", "title": "S", "videos": str(tables / "episodes.csv"), "tasks": tasks}
    file.write_text(json.dumps(content))
    return file


def grey_of(video: Path) -> float:
    import av  # noqa: PLC0415 - an extra

    with av.open(str(video)) as container:
        return float(next(container.decode(video=0)).to_ndarray(format="gray").mean())


def test_pictures_that_are_wrong_are_named(tmp_path: Path):
    folder = image_dataset(tmp_path / "set", as_files=True)
    picture = folder / f"images/{CAMERA}/episode_000001/frame_000003.png"
    content = picture.read_bytes()
    for bad in (
        b"",
        b"GIF89a",
        content[:40],
        content[:16] + b"\x7f\xff\xff\xff" * 2 + content[24:],
    ):
        picture.write_bytes(bad)
        with pytest.raises(FormatError, match="picture") as error:
            tables(folder, scratch=tmp_path / "films")
        assert "episode 1, frame 3" in error.value.where
    picture.unlink()
    with pytest.raises(FormatError, match="there is no picture"):
        tables(folder, scratch=tmp_path / "films")


def test_datasets_of_numbers_only_have_an_advice_of_their_own(tmp_path: Path):
    folder = new_dataset(tmp_path / "set")
    told(folder, lambda info: [info["features"].pop(camera) for camera in (CAMERA, WRIST)])
    with pytest.raises(FormatError, match="numbers only") as error:
        tables(folder)
    assert "ct annotate init" in error.value.fix


def test_paths_and_types_of_features_may_be_missing(tmp_path: Path):
    for make, version in ((new_dataset, "v3.0"), (old_dataset, "v2.0")):
        folder = make(tmp_path / version)
        told(folder, lambda info: [info.pop(n) for n in ("video_path", "data_path", "chunks_size")])
        told(folder, lambda info: info["features"]["action"].pop("dtype"))
        told(folder, lambda info, v=version: info.update(codebase_version=v, robot_type=None))
        (folder / "meta/stats.json").unlink(missing_ok=True)
        assert tables(folder).rows["episodes.csv"] == 3


@pytest.mark.parametrize(
    ("name", "options", "expected"),
    [
        ("04-lerobot-first/dataset", {"first": 1}, [(0.0, 23 / 30)]),
        ("05-lerobot-long-video/dataset", {}, [(0.0, 40 / 30), (0.0, 1.0)]),
        ("06-lerobot-no-tasks-column/dataset", {"first": 2}, [(0.0, 23 / 30), (23 / 30, 2.8)]),
        ("07-lerobot-tasks-two-columns/dataset", {"first": 1}, [(0.0, 23 / 30)]),
        ("08-lerobot-types/float-index", {"first": 1}, [(0.0, 23 / 30)]),
        ("08-lerobot-types/string-task", {}, [(0.0, 0.0), (0.0, 0.0)]),
    ],
)
def test_published_layouts(
    name: str, options: dict[str, int], expected: list[tuple[float, float]], tmp_path: Path
):
    made = study_input(open_dataset(case(name)), tmp_path / "out", **options)
    assert np.array(parts(made)) == pytest.approx(np.array(expected), abs=1e-5)
    assert {row["command"][:12] for row in rows(made, "tasks.csv")} <= {
        "Pick up cube",
        "Pick up the ",
    }
    assert made.rows["tasks.csv"] == len(expected)


def test_published_tasks_that_are_null_or_empty(tmp_path: Path):
    made = study_input(open_dataset(case("08-lerobot-types/none-task")), tmp_path / "out")
    assert [row["task"] for row in rows(made, "episodes.csv")] == ["", "", "", "Pick up the cube."]
    assert [row["command"] for row in rows(made, "tasks.csv")] == ["Pick up the cube."]
