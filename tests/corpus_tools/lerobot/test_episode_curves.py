"""State and action of episodes become files of curves; odd ones are named and left out."""

from __future__ import annotations

import csv
import json
import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("pyarrow", reason="the extra `parquet` is not installed")
pytest.importorskip("av", reason="the extra `render` is not installed")

import pyarrow as pa
import pyarrow.parquet as pq
from safetensors.numpy import load_file

from corpus_tools.cli.console import run
from corpus_tools.lerobot.episode_curves import write_episode_curves
from corpus_tools.lerobot.episode_frames import checked_episodes
from corpus_tools.lerobot.episode_reading import open_dataset
from corpus_tools.tables.curve_file import read_header
from tests.lerobot_datasets import new_dataset, old_dataset

DATA = "data/chunk-000/file-000.parquet"


def changed(folder: Path, column: str, values: Any) -> None:
    table = pq.read_table(folder / DATA)
    place = table.column_names.index(column)
    pq.write_table(table.set_column(place, column, values), folder / DATA, row_group_size=7)


def imported(folder: Path, *options: str) -> list[dict[str, str]]:
    out = folder.parent / "out"
    assert run(["import", "lerobot", str(folder), "--out", str(out), "--force", *options]) == 0
    return list(csv.DictReader((out / "episodes.csv").read_text().splitlines()))


@pytest.mark.parametrize("make", [new_dataset, old_dataset])
def test_all_numbers_with_their_names(make, tmp_path: Path):
    folder = make(tmp_path / "set")
    rows = imported(folder)
    files = [tmp_path / "out" / row["curves"] for row in rows]
    header = read_header(files[0])
    assert [(curve.group, curve.name) for curve in header.curves] == [
        (group, name) for group in ("observation.state", "action") for name in "abc"
    ]
    assert [read_header(file).samples for file in files] == [12, 8, 10]
    for index, file in enumerate(files):
        rng = np.random.default_rng(index)  # as the dataset is made
        action, state = (rng.normal(size=(len(load_file(file)["0"]), 3)) for _ in range(2))
        np.testing.assert_allclose(load_file(file)["0"], np.hstack((state, action)), rtol=1e-6)
    subtasks = tmp_path / "out" / "subtasks.csv"
    if subtasks.exists():
        starts = [
            row["curves_start_s"] for row in csv.DictReader(subtasks.read_text().splitlines())
        ]
        assert starts == ["", "0.5", ""]
    assert "curves" not in imported(folder, "--no-curves")[0]


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (None, "123"), (["x", "y"], "123"), (["x", "y", 3], "123"), ("abc", "123"), ([[]], "123"),
        ({"motors": ["x", "y", "z"]}, "xyz"), ({"z": 2, "x": 0, "y": 1}, "xyz"),
        ({"a": {"b": ["x", "y", "z"]}}, "123"), (["x", " ", "z"], "123"),
    ],
)  # fmt: skip
def test_names_in_all_forms(names: Any, expected: str, tmp_path: Path):
    folder = new_dataset(tmp_path / "set")
    info = json.loads((folder / "meta/info.json").read_text())
    info["features"]["action"]["names"] = names
    (folder / "meta/info.json").write_text(json.dumps(info))
    header = read_header(tmp_path / "out" / imported(folder)[0]["curves"])
    assert [curve.name for curve in header.curves if curve.group == "action"] == list(expected)


def test_types_and_gaps(tmp_path: Path):
    folder = new_dataset(tmp_path / "set")
    changed(folder, "observation.state", pa.array(range(30), pa.int64()))
    action = [[1.0, float("nan"), float("inf")]] * 30
    changed(folder, "action", pa.array(action, pa.large_list(pa.float64())))
    values = load_file(tmp_path / "out" / imported(folder)[1]["curves"])["0"]
    np.testing.assert_array_equal(values[0], [12, 1, np.nan, np.nan])


@pytest.mark.parametrize(
    ("values", "what"),
    [
        (pa.array(["a"] * 30), "its type is string"),
        (pa.array([[[1.0]]] * 30), "its type is list"),
        (pa.array([[0.0] * 65] * 30), "a frame has 65 numbers"),
    ],
)
def test_what_is_no_curve_is_noted(values, what: str, tmp_path: Path, capsys):
    folder = new_dataset(tmp_path / "set")
    changed(folder, "action", values)
    header = read_header(tmp_path / "out" / imported(folder)[0]["curves"])
    assert {curve.group for curve in header.curves} == {"observation.state"}
    assert what in capsys.readouterr().err


def test_frames_with_other_numbers_are_an_error(tmp_path: Path, capsys):
    folder = new_dataset(tmp_path / "set")
    action = [[1.0] * (2 + n % 3) for n in range(30)]
    changed(folder, "action", pa.array(action))
    call = ["import", "lerobot", str(folder), "--out", str(tmp_path / "out")]
    assert run(call) == 2
    message = capsys.readouterr().err
    assert DATA in message
    assert "column action: not all frames have 3 numbers" in message
    assert run([*call, "--keep-going"]) == 0
    assert "without curves" in capsys.readouterr().err


def test_frames_at_other_times_are_shown_at_the_rate(tmp_path: Path):
    folder = new_dataset(tmp_path / "set", lengths=(4,))
    changed(folder, "timestamp", pa.array([0.0, 0.1, 0.4, 0.5], pa.float32()))
    changed(folder, "action", pa.array([[float(n)] for n in range(4)]))
    dataset = open_dataset(folder)
    errors: list[Any] = []
    files, _ = write_episode_curves(
        dataset, list(checked_episodes(dataset)), tmp_path / "curves",
        on_error=errors.append, on_progress=lambda *_: None,
    )  # fmt: skip
    assert load_file(files[0])["0"][:, -1].tolist() == [0, 1, 1, 1, 2, 3]
    changed(folder, "timestamp", pa.array([0.0, 0.1, 0.4, 1e9], pa.float32()))
    dataset = open_dataset(folder)
    files, _ = write_episode_curves(
        dataset, list(checked_episodes(dataset)), tmp_path / "curves",
        on_error=errors.append, on_progress=lambda *_: None,
    )  # fmt: skip
    assert not files
    assert "4 frames in 1e+09 s" in str(errors[0])


def test_memory_stays_flat(tmp_path: Path):
    folder = new_dataset(tmp_path / "set", lengths=(4,))
    table = pq.read_table(folder / DATA)
    peaks = []
    for n in (50_000, 400_000):
        state = pa.FixedSizeListArray.from_arrays(pa.array(np.zeros(8 * n, np.float32)), 8)
        columns = {"observation.state": state, "episode_index": pa.array(np.zeros(n, np.int64))}
        columns["timestamp"] = pa.array((np.arange(n) / 10).astype(np.float64))
        pq.write_table(pa.table(columns), folder / DATA)
        rows = pq.read_table(folder / "meta/episodes/chunk-000/file-000.parquet").to_pylist()
        pq.write_table(
            pa.Table.from_pylist([row | {"length": n} for row in rows]),
            folder / "meta/episodes/chunk-000/file-000.parquet",
        )
        dataset = open_dataset(folder)
        episodes = list(checked_episodes(dataset, ()))
        tracemalloc.start()
        files, _ = write_episode_curves(
            dataset, episodes, tmp_path / "curves",
            on_error=lambda _: None, on_progress=lambda *_: None,
        )  # fmt: skip
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
        assert read_header(files[0]).samples == n
    assert table.num_rows
    assert peaks[1] < peaks[0] + 40 * 350_000  # times of frames, and no numbers
