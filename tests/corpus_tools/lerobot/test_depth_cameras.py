"""Depth cameras are shown in false colours, and only if somebody asks for them."""

from __future__ import annotations

import csv
import json
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("pyarrow", reason="the extra `parquet` is not installed")
pytest.importorskip("av", reason="the extra `render` is not installed")

import av
import cv2
import pyarrow as pa
import pyarrow.parquet as pq

from corpus_tools.cli.console import run
from tests.lerobot_datasets import CAMERA, FPS, HEIGHT, WIDTH, WRIST, image_dataset, new_dataset

LENGTHS = (12, 8, 10)
NEAR_M, FAR_M = 0.5, 2.0


def distances(frame: int = 0) -> np.ndarray[Any, np.dtype[np.float32]]:
    """Near on the left, far on the right, unknown at the top."""
    row = np.linspace(NEAR_M, FAR_M, WIDTH, dtype=np.float32)
    metres = np.repeat(row[None], HEIGHT, 0)
    metres[:4] = 0
    return metres


def depth_video(path: Path, frames: int) -> None:
    """A video as LeRobot 0.6 encodes depth maps: 12 bits, on its logarithmic scale."""
    low, high = np.log(0.01 + 3.5), np.log(10 + 3.5)
    grey = np.rint((np.log(distances() + 3.5) - low) / (high - low) * 4095).clip(0, 4095)
    with av.open(str(path), "w", format="mp4") as container:
        stream = container.add_stream("libx265", rate=FPS)
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "gray12le"
        stream.time_base = Fraction(1, FPS)
        stream.options = {"x265-params": "lossless=1:log-level=none:bframes=0"}
        for number in range(frames):
            frame = av.VideoFrame(WIDTH, HEIGHT, "gray12le")
            plane = np.zeros((HEIGHT, frame.planes[0].line_size // 2), "<u2")
            plane[:, :WIDTH] = grey
            frame.planes[0].update(plane.tobytes())
            frame.pts, frame.time_base = number, Fraction(1, FPS)
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))


def marked(folder: Path, camera: str, **info: Any) -> Path:
    file = folder / "meta/info.json"
    told = json.loads(file.read_text())
    told["features"][camera]["info"] = info
    file.write_text(json.dumps(told))
    return folder


def with_depth_video(folder: Path, **info: Any) -> Path:
    new_dataset(folder, lengths=LENGTHS)
    depth_video(folder / f"videos/{WRIST}/chunk-000/file-000.mp4", sum(LENGTHS))
    return marked(folder, WRIST, **({"video.is_depth_map": True} | info))


def with_depth_images(folder: Path, kind: str, **info: Any) -> Path:
    image_dataset(folder, LENGTHS)
    metres = distances()
    numbers, ending = {
        "uint16": ((1000 * metres).astype(np.uint16), ".png"),
        "tiff16": ((1000 * metres).astype(np.uint16), ".tiff"),
        "float32": (metres, ".tiff"),
    }[kind]
    _, content = cv2.imencode(ending, numbers)
    for episode, frames in enumerate(LENGTHS):
        data = folder / f"data/chunk-000/episode_{episode:06d}.parquet"
        table = pq.read_table(data)
        cells = [{"bytes": content.tobytes(), "path": None}] * frames
        place = table.column_names.index(CAMERA)
        pq.write_table(table.set_column(place, CAMERA, pa.array(cells)), data)
    return marked(folder, CAMERA, **({"is_depth_map": True} | info))


def imported(folder: Path, *options: str) -> list[dict[str, str]]:
    out = folder.parent / "out"
    assert run(["import", "lerobot", str(folder), "--out", str(out), "--force", *options]) == 0
    return list(csv.DictReader((out / "episodes.csv").read_text().splitlines()))


def looked_at(film: Path, frames: int) -> None:
    """The number of frames, and colours: black where nothing is known, red near, blue far."""
    with av.open(str(film)) as container:
        pictures = [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]
    assert len(pictures) == frames
    picture = pictures[-1]
    height, width, _ = picture.shape
    assert width >= 320
    assert picture[4, width // 2].max() < 40
    middle = height // 2
    red, _, blue = picture[middle, 8].astype(int)
    assert red > blue + 60
    red, _, blue = picture[middle, -8].astype(int)
    assert blue > red + 20
    assert picture[-20:].max() > 180  # the scale's numbers


def test_a_depth_video_beside_a_camera(tmp_path: Path, capsys):
    folder = with_depth_video(tmp_path / "set")
    (row, *_) = imported(folder)
    assert "camera_2" not in row
    assert f"cameras that aren't shown: {WRIST}" in capsys.readouterr().err
    rows = imported(folder, "--camera", CAMERA, "--camera", WRIST)
    assert "people see distances, from 0.5" in capsys.readouterr().err
    for row, frames in zip(rows, LENGTHS, strict=True):
        assert row["camera_2"] == WRIST
        looked_at(tmp_path / "out" / row["video_2"], frames)
    rows = imported(folder, "--camera", WRIST)
    looked_at(tmp_path / "out" / rows[0]["video"], LENGTHS[0])


def test_depth_that_is_a_picture_already_is_shown_as_it_is(tmp_path: Path):
    folder = marked(new_dataset(tmp_path / "set"), WRIST, is_depth_map=True)
    (row, *_) = imported(folder, "--camera", WRIST)
    assert row["video"].endswith(f"{WRIST}/chunk-000/file-000.mp4")
    folder = marked(image_dataset(tmp_path / "images"), CAMERA, is_depth_map=True)
    (row, *_) = imported(folder, "--camera", CAMERA)
    assert row["video"].startswith("films/")


@pytest.mark.parametrize("kind", ["uint16", "tiff16", "float32"])
def test_depth_images(kind: str, tmp_path: Path, capsys):
    folder = with_depth_images(tmp_path / "set", kind)
    rows = imported(folder, "--camera", CAMERA)
    told = capsys.readouterr().err
    assert "from 0.5" in told
    assert "to 2.00 m" in told
    for row, frames in zip(rows, LENGTHS, strict=True):
        looked_at(tmp_path / "out" / row["video"], frames)


def test_a_unit_of_the_metadata(tmp_path: Path, capsys):
    folder = with_depth_images(tmp_path / "set", "float32", depth_unit="mm")
    imported(folder, "--camera", CAMERA)
    assert "from 0.00 m" in capsys.readouterr().err


@pytest.mark.parametrize(
    "info",
    [
        {"video.depth_min": "x"}, {"video.depth_max": 1e300}, {"video.shift": -3},
        {"video.depth_min": 5, "depth_max": 1},
    ],
)  # fmt: skip
def test_wrong_quantization_is_named(info: dict[str, Any], tmp_path: Path, capsys):
    folder = with_depth_video(tmp_path / "set", **info)
    call = ["import", "lerobot", str(folder), "--camera", WRIST, "--out", str(tmp_path / "out")]
    assert run(call) == 2
    assert f"info.json, {WRIST}" in capsys.readouterr().err


def test_damaged_and_huge_depth_maps_are_named(tmp_path: Path, capsys):
    _, content = cv2.imencode(".tiff", distances())
    whole = content.tobytes()
    huge = bytearray(whole)
    at = int.from_bytes(whole[4:8], "little") + 2
    while int.from_bytes(huge[at : at + 2], "little") != 256:
        at += 12
    huge[at + 2 : at + 12] = bytes([4, 0, 1, 0, 0, 0]) + (100_000_000).to_bytes(4, "little")
    for damaged, what in (
        (b"II*\0", "no depth map"), (whole[:200], "depth map"), (bytes(huge), "100000000 by"),
    ):  # fmt: skip
        folder = with_depth_images(tmp_path / f"set-{len(damaged)}-{what[:3]}", "float32")
        data = folder / "data/chunk-000/episode_000001.parquet"
        table = pq.read_table(data)
        cells = [{"bytes": damaged, "path": None}] * LENGTHS[1]
        place = table.column_names.index(CAMERA)
        pq.write_table(table.set_column(place, CAMERA, pa.array(cells)), data)
        call = ["import", "lerobot", str(folder), "--camera", CAMERA, "--out", str(tmp_path / "o")]
        assert run(call) == 2
        message = capsys.readouterr().err
        assert what in message
        assert "episode 1, frame 0" in message
