"""HDF5 files as robomimic and LIBERO write them become tables and videos; bad ones are named."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest

pytest.importorskip("h5py", reason="the extra `hdf5` is not installed")

import h5py

from corpus_tools.cli.console import run
from tests.lerobot_datasets import curves_of

LENGTHS = {"demo_0": 6, "demo_2": 4, "demo_10": 5}
ENV = {"env_name": "Lift", "type": 1, "env_kwargs": {"control_freq": 20}}


def dataset(file: Path, **attributes: Any) -> Path:
    """A file as robomimic's own scripts write one: a grey for each episode and frame."""
    with h5py.File(file, "w") as hdf5:
        data = hdf5.create_group("data")
        data.attrs["total"] = sum(LENGTHS.values())
        data.attrs["env_args"] = json.dumps(ENV)
        data.attrs.update(attributes)
        for number, (name, frames) in enumerate(LENGTHS.items()):
            demo = data.create_group(name)
            demo.attrs["num_samples"] = frames
            demo["actions"] = np.arange(frames * 7.0).reshape(frames, 7)
            pictures = np.zeros((frames, 48, 64, 3), np.uint8)
            pictures[:, :24] = 40 + 60 * number  # the upper half
            options = {"compression": "gzip", "chunks": (1, 48, 64, 3)}
            demo.create_dataset("obs/agentview_image", data=pictures, **options)
            demo["obs/agentview_depth"] = np.ones((frames, 48, 64, 1), np.float32)
            demo["obs/robot0_eef_pos"] = np.zeros((frames, 3))
    return file


def imported(path: Path, *options: str) -> list[dict[str, str]]:
    out = path.parent / "tables"
    assert run(["import", "robomimic", str(path), "--out", str(out), "--force", *options]) == 0
    return list(csv.DictReader((out / "episodes.csv").read_text().splitlines()))


def halves(file: Path) -> tuple[int, int, int]:
    """The number of a film's frames, and the shades of the upper and lower half of the first."""
    with av.open(str(file)) as container:
        frames = [f.to_ndarray(format="rgb24") for f in container.decode(video=0)]
    return len(frames), round(frames[0][:20].mean()), round(frames[0][28:].mean())


def test_episodes_in_the_order_of_their_numbers(tmp_path: Path):
    rows = imported(dataset(tmp_path / "lift.hdf5"))
    assert [row["source"] for row in rows] == [f"lift.hdf5/{name}" for name in LENGTHS]
    assert [row["fps"] for row in rows] == ["20.0"] * 3
    assert {row["camera"] for row in rows} == {"agentview_image"}
    films = [halves(tmp_path / "tables" / row["video"]) for row in rows]
    assert [film[0] for film in films] == list(LENGTHS.values())
    for film, shade in zip(films, (40, 100, 160), strict=True):
        assert abs(film[1] - shade) < 4
        assert film[2] < 4
    assert not (tmp_path / "tables/tasks.csv").exists()


def test_cameras_side_by_side_with_curves(tmp_path: Path, capsys):
    file = dataset(tmp_path / "lift.hdf5")
    with h5py.File(file, "a") as hdf5:
        for name, frames in LENGTHS.items():
            obs = hdf5[f"data/{name}/obs"]
            obs["wrist_image"] = np.full((frames + (name == "demo_2"), 32, 32, 3), 90, np.uint8)
            obs["gripper"] = np.full(frames, np.inf)
            obs["features"] = np.zeros((frames, 65))
            obs["mask"] = np.zeros((frames, 48, 64, 1), np.int32)
        del hdf5["data/demo_10/obs/wrist_image"]
    found = imported(file)
    assert [(r["camera"], r["camera_2"]) for r in found[:2]] == [
        ("agentview_image", "wrist_image")
    ] * 2
    told = capsys.readouterr().err
    assert "1 episodes without wrist_image, the first because: " in told
    assert not found[2]["video_2"]
    assert not found[2]["camera_2"]
    # As many frames as the first camera has.
    assert halves(tmp_path / "tables" / found[1]["video_2"])[0] == LENGTHS["demo_2"]
    header, values = curves_of(tmp_path / "tables" / found[0]["curves"])
    groups = {c.group: None for c in header.curves}
    assert list(groups) == ["actions", "obs/gripper", "obs/robot0_eef_pos"]
    assert values[:, :7].tolist() == np.arange(42.0).reshape(6, 7).tolist()
    assert np.isnan(values[:, 7]).all()
    call = ["import", "robomimic", str(file), "--out", str(tmp_path / "x"), "--camera"]
    assert run([*call, "agentview_image", "--camera", "wrist_image"]) == 2
    assert "there is no wrist_image" in capsys.readouterr().err


def test_what_libero_adds(tmp_path: Path):
    (tmp_path / "suite").mkdir()
    problem = {"language_instruction": '"pick up the bowl"'}
    attributes = {"problem_info": json.dumps(problem), "macros_image_convention": "opengl"}
    for name in ("b", "a"):
        dataset(tmp_path / f"suite/{name}_demo.hdf5", **attributes)
    rows = imported(tmp_path / "suite", "--first", "4", "--fps", "10")
    assert [row["source"] for row in rows[2:]] == ["a_demo.hdf5/demo_10", "b_demo.hdf5/demo_0"]
    assert [row["episode"] for row in rows] == list("0123")
    assert {row["task"] for row in rows} == {"pick up the bowl"}
    frames, upper, lower = halves(tmp_path / "tables" / rows[0]["video"])
    assert (frames, upper < 4, abs(lower - 40) < 4) == (6, True, True)
    tasks = csv.DictReader((tmp_path / "tables/tasks.csv").read_text().splitlines())
    assert [row["command"] for row in tasks] == ["pick up the bowl"] * 4


def test_a_task_for_each_episode_and_a_depth_camera(tmp_path: Path, capsys):
    file = dataset(tmp_path / "kitchen.hdf5")
    with h5py.File(file, "a") as hdf5:
        for name in LENGTHS:
            meta = json.dumps({"lang": f"do {name}"})
            hdf5[f"data/{name}"].attrs["ep_meta"] = meta
    rows = imported(file, "--camera", "agentview_depth")
    assert [row["task"] for row in rows] == [f"do {name}" for name in LENGTHS]
    assert "depth map" in capsys.readouterr().err


def _without_pictures(hdf5: Any) -> None:
    for name in LENGTHS:
        del hdf5[f"data/{name}/obs"]


def _linked(hdf5: Any) -> None:
    del hdf5["data/demo_2/obs/agentview_image"]
    hdf5["data/demo_2/obs/agentview_image"] = h5py.ExternalLink("/etc/passwd", "/")


def _outside(hdf5: Any) -> None:
    del hdf5["data/demo_2/obs/agentview_image"]
    file = str(Path("secret").resolve())
    hdf5.create_dataset(
        "data/demo_2/obs/agentview_image", (2, 48, 64, 3), "u1", external=[(file, 0, 18432)]
    )


def _numbers_outside(hdf5: Any) -> None:
    del hdf5["data/demo_2/actions"]
    hdf5["data/demo_2/actions"] = h5py.ExternalLink("/etc/passwd", "/")


def _numbers_too_large(hdf5: Any) -> None:
    del hdf5["data/demo_2/actions"]
    chunks = (1 << 25, 7)
    hdf5.create_dataset(
        "data/demo_2/actions", (4, 7), "f8", maxshape=(None, 7), chunks=chunks, compression="gzip"
    )


@pytest.mark.parametrize("change", [_numbers_outside, _numbers_too_large])
def test_numbers_are_not_trusted(tmp_path: Path, capsys, change):
    file = dataset(tmp_path / "lift.hdf5")
    with h5py.File(file, "a") as hdf5:
        change(hdf5)
    found = imported(file)
    told = capsys.readouterr().err
    if change is _numbers_outside:
        assert "1 episodes without curves, the first because: " in told
        assert not found[1]["curves"]
    else:
        header, _ = curves_of(tmp_path / "tables" / found[1]["curves"])
        assert {c.group for c in header.curves} == {"obs/robot0_eef_pos"}


def _virtual(hdf5: Any) -> None:
    del hdf5["data/demo_2/obs/agentview_image"]
    layout = h5py.VirtualLayout((2, 48, 64, 3), "u1")
    layout[:] = h5py.VirtualSource("/etc/passwd", "x", (2, 48, 64, 3))
    hdf5.create_virtual_dataset("data/demo_2/obs/agentview_image", layout)


def _huge(hdf5: Any) -> None:
    del hdf5["data/demo_2/obs/agentview_image"]
    hdf5.create_dataset(
        "data/demo_2/obs/agentview_image", (2, 100_000, 100_000, 3), "u1",
        chunks=(1, 20_000, 20_000, 1), compression="gzip",
    )  # fmt: skip


def _floats(hdf5: Any) -> None:
    del hdf5["data/demo_2/obs/agentview_image"]
    hdf5["data/demo_2/obs/agentview_image"] = np.zeros((2, 48, 64, 3))


def _bad_arguments(hdf5: Any) -> None:
    hdf5["data"].attrs["env_args"] = "{"


@pytest.mark.parametrize(
    ("change", "what"),
    [
        (_without_pictures, "--camera_names"),
        (_linked, "agentview_image is a link"),
        (_outside, "is in another file"),
        (_virtual, "is in another file"),
        (_huge, "too large"),
        (_floats, "float64"),
        (_bad_arguments, "env_args: this is no JSON"),
    ],
)
def test_other_peoples_files_are_not_trusted(tmp_path: Path, capsys, change, what):
    file = dataset(tmp_path / "lift.hdf5")
    with h5py.File(file, "a") as hdf5:
        change(hdf5)
    call = ["import", "robomimic", str(file), "--out", str(tmp_path / "tables")]
    assert run(call) == 2
    assert what in capsys.readouterr().err
    assert not (tmp_path / "tables").exists()
    if change in (_linked, _outside, _virtual, _huge, _floats):
        assert len(imported(file, "--keep-going")) == 2
        assert "demo_2" in capsys.readouterr().err


def test_damaged_files(tmp_path: Path, capsys):
    file = dataset(tmp_path / "lift.hdf5")
    content = file.read_bytes()
    call = ["import", "robomimic", str(file), "--out", str(tmp_path / "tables")]
    for damaged in (b"", b"no HDF5", content[: len(content) // 2]):
        file.write_bytes(damaged)
        assert run(call) == 2
        assert f"{file}: the file can't be read as HDF5" in capsys.readouterr().err
    with h5py.File(dataset(file), "r") as hdf5:
        place = hdf5["data/demo_2/obs/agentview_image"].id.get_chunk_info(1)
    content = bytearray(file.read_bytes())
    content[place.byte_offset : place.byte_offset + place.size] = bytes(place.size)
    file.write_bytes(content)
    assert run(call) == 2
    assert "demo_2/obs/agentview_image, frame 1: the file can't be read" in capsys.readouterr().err
    assert run(["import", "robomimic", str(tmp_path / "no"), "--out", str(tmp_path / "out")]) == 2
