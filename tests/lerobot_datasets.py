"""Small LeRobot datasets, as LeRobot itself writes them, with real videos."""

from __future__ import annotations

import json
import shutil
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.parquet as pq

from corpus_tools.tables.curve_file import CurveFile, read_header

CAMERA, WRIST = "observation.images.top", "observation.images.wrist"
FPS = 10
WIDTH, HEIGHT = 64, 48
TEXT = pa.string()
ROW = [("role", TEXT), ("content", TEXT), ("style", TEXT)]
# A dataset without tool calls has this type: LeRobot lets pyarrow infer it.
PERSISTENT = pa.list_(
    pa.struct([*ROW, ("timestamp", pa.float32()), ("camera", TEXT), ("tool_calls", pa.null())])
)
EVENTS = pa.list_(pa.struct([*ROW, ("camera", TEXT), ("tool_calls", pa.null())]))


def said(style: str, time: float, content: str) -> dict[str, Any]:
    role = "user" if style == "task_aug" else "assistant"
    return {
        "role": role, "content": content, "style": style, "timestamp": float(np.float32(time)),
        "camera": None, "tool_calls": None,
    }  # fmt: skip


LANGUAGE = {
    0: [said("subtask", 0.0, "reach"), said("memory", 0.5, "it was near"),
        said("subtask", 0.5, "grasp")],
    1: [said("subtask", 0.0, "push")],
    2: [],
}  # fmt: skip


def shade(episode: int, frame: int) -> int:
    """The grey of a frame."""
    return 20 + (60 * episode + 2 * frame) % 220


def film(path: Path, frames: list[int], codec: str = "libx264") -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with av.open(str(path), "w") as container:
        stream = container.add_stream(codec, rate=FPS)
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuv420p"
        stream.time_base = Fraction(1, FPS)
        stream.options = {"g": "2", "crf": "10"}
        for grey in frames:
            picture = np.full((HEIGHT, WIDTH, 3), grey, np.uint8)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
        container.mux(stream.encode(None))


def frames(episode: int, n: int, first: int, task: int, *, language: bool) -> dict[str, Any]:
    """The columns of an episode, in types that a careless writer would change."""
    rng = np.random.default_rng(episode)
    vector = pa.list_(pa.float32(), 3)
    columns: dict[str, Any] = {
        "action": pa.array(rng.normal(size=(n, 3)).astype(np.float32).tolist(), vector),
        "observation.state": pa.array(rng.normal(size=(n, 3)).astype(np.float32).tolist(), vector),
        "next.done": pa.array([i == n - 1 for i in range(n)]),
        "note": pa.array([None if i % 3 else f"n{i}" for i in range(n)], TEXT),
        "timestamp": pa.array((np.arange(n) / FPS).astype(np.float32)),
        "frame_index": pa.array(range(n), pa.int64()),
        "episode_index": pa.array([episode] * n, pa.int64()),
        "index": pa.array(range(first, first + n), pa.int64()),
        "task_index": pa.array([task] * n, pa.int64()),
    }
    if language:
        columns["language_persistent"] = pa.array([LANGUAGE[episode]] * n, PERSISTENT)
        vqa = {"role": "user", "content": "where?", "style": "vqa", "camera": CAMERA,
               "tool_calls": None}  # fmt: skip
        columns["language_events"] = pa.array([[vqa] if i == 1 else [] for i in range(n)], EVENTS)
    return columns


def info(version: str, lengths: list[int], *, language: bool, cameras: list[str]) -> dict[str, Any]:
    one = {"shape": [1], "names": None}
    vector = {"dtype": "float32", "shape": [3], "names": ["a", "b", "c"]}
    features: dict[str, Any] = {"action": vector, "observation.state": vector}
    for camera in cameras:
        features[camera] = {
            "dtype": "video", "shape": [HEIGHT, WIDTH, 3],
            "names": ["height", "width", "channels"], "info": {"video.fps": FPS},
        }  # fmt: skip
    features |= {"next.done": {"dtype": "bool", **one}, "note": {"dtype": "string", **one}}
    features["timestamp"] = {"dtype": "float32", **one}
    for name in ("frame_index", "episode_index", "index", "task_index"):
        features[name] = {"dtype": "int64", **one}
    if language:
        for name in ("language_persistent", "language_events"):
            features[name] = {"dtype": "language", **one}
    told = {
        "codebase_version": version, "robot_type": "so101", "fps": FPS, "chunks_size": 1000,
        "total_episodes": len(lengths), "total_frames": sum(lengths), "total_tasks": 2,
        "splits": {"train": f"0:{len(lengths)}"}, "features": features, "mine": {"kept": True},
    }  # fmt: skip
    if version == "v3.0":
        files = "chunk-{chunk_index:03d}/file-{file_index:03d}"
        paths = {
            "data_path": f"data/{files}.parquet", "video_path": f"videos/{{video_key}}/{files}.mp4",
        }  # fmt: skip
    else:
        chunk, name = "chunk-{episode_chunk:03d}", "episode_{episode_index:06d}"
        paths = {
            "data_path": f"data/{chunk}/{name}.parquet",
            "video_path": f"videos/{chunk}/{{video_key}}/{name}.mp4",
        }
    return told | paths


TASKS = ["Push the cube.", ""]


def new_dataset(
    folder: Path,
    *,
    language: bool = True,
    lengths: tuple[int, ...] = (12, 8, 10),
    row_group_size: int = 7,
) -> Path:
    """Version 3: all episodes in a file, with the frames in several groups of rows."""
    (folder / "meta/episodes/chunk-000").mkdir(parents=True)
    (folder / "data/chunk-000").mkdir(parents=True)
    of_task = [0, 0, 1]
    first, tables, rows = 0, [], []
    for episode, n in enumerate(lengths):
        tables.append(pa.table(frames(episode, n, first, of_task[episode % 3], language=language)))
        row: dict[str, Any] = {
            "episode_index": episode, "tasks": [TASKS[of_task[episode % 3]]], "length": n,
            "data/chunk_index": 0, "data/file_index": 0, "dataset_from_index": first,
            "dataset_to_index": first + n, "stats/action/mean": [0.0, 0.0, 0.0],
        }  # fmt: skip
        for camera in (CAMERA, WRIST):
            row |= {
                f"videos/{camera}/chunk_index": 0, f"videos/{camera}/file_index": 0,
                f"videos/{camera}/from_timestamp": first / FPS,
                f"videos/{camera}/to_timestamp": (first + n) / FPS,
            }  # fmt: skip
        rows.append(row)
        first += n
    table = pa.concat_tables(tables).replace_schema_metadata({"mine": "kept"})
    pq.write_table(table, folder / "data/chunk-000/file-000.parquet", row_group_size=row_group_size)
    episodes = pa.Table.from_pylist(rows)
    pq.write_table(episodes, folder / "meta/episodes/chunk-000/file-000.parquet")
    tasks = pa.table({"task_index": pa.array([0, 1], pa.int64()), "__index_level_0__": TASKS})
    pq.write_table(tasks, folder / "meta/tasks.parquet")
    greys = [shade(e, i) for e, n in enumerate(lengths) for i in range(n)]
    for camera in (CAMERA, WRIST):
        film(folder / f"videos/{camera}/chunk-000/file-000.mp4", greys)
    told = info("v3.0", list(lengths), language=language, cameras=[CAMERA, WRIST])
    (folder / "meta/info.json").write_text(json.dumps(told))
    (folder / "meta/stats.json").write_text("{}")
    return folder


def old_dataset(folder: Path, lengths: tuple[int, ...] = (12, 8, 10)) -> Path:
    """Version 2.1: files for each episode, without language."""
    (folder / "meta").mkdir(parents=True)
    (folder / "data/chunk-000").mkdir(parents=True)
    first, lines = 0, []
    of_task = [0, 0, 1]
    for episode, n in enumerate(lengths):
        name = f"episode_{episode:06d}"
        table = pa.table(frames(episode, n, first, of_task[episode], language=False))
        pq.write_table(table, folder / f"data/chunk-000/{name}.parquet")
        film(
            folder / f"videos/chunk-000/{CAMERA}/{name}.mp4", [shade(episode, i) for i in range(n)]
        )
        lines.append({"episode_index": episode, "tasks": [TASKS[of_task[episode]]], "length": n})
        first += n
    write_lines(folder / "meta/episodes.jsonl", lines)
    tasks = [{"task_index": number, "task": task} for number, task in enumerate(TASKS)]
    write_lines(folder / "meta/tasks.jsonl", tasks)
    told = info("v2.1", list(lengths), language=False, cameras=[CAMERA])
    (folder / "meta/info.json").write_text(json.dumps(told))
    return folder


def png(grey: int) -> bytes:
    """A picture of one grey."""
    context = av.CodecContext.create("png", "w")
    context.width, context.height, context.pix_fmt = WIDTH, HEIGHT, "rgb24"
    context.time_base = Fraction(1, FPS)
    picture = np.full((HEIGHT, WIDTH, 3), grey, np.uint8)
    frame = av.VideoFrame.from_ndarray(picture, format="rgb24")
    return b"".join(bytes(p) for p in [*context.encode(frame), *context.encode(None)])


def image_dataset(
    folder: Path, lengths: tuple[int, ...] = (12, 8, 10), *, as_files: bool = False
) -> Path:
    """Version 2.1 with pictures in place of videos: in the data's cells, or in files."""
    old_dataset(folder, lengths)
    shutil.rmtree(folder / "videos")
    for episode, n in enumerate(lengths):
        data = folder / f"data/chunk-000/episode_{episode:06d}.parquet"
        pictures = [png(shade(episode, i)) for i in range(n)]
        if as_files:
            place = folder / f"images/{CAMERA}/episode_{episode:06d}"
            place.mkdir(parents=True)
            for number, picture in enumerate(pictures):
                (place / f"frame_{number:06d}.png").write_bytes(picture)
        else:
            cells = [{"bytes": p, "path": f"frame_{i:06d}.png"} for i, p in enumerate(pictures)]
            pq.write_table(pq.read_table(data).append_column(CAMERA, pa.array(cells)), data)
    told = json.loads((folder / "meta/info.json").read_text())
    told["features"][CAMERA]["dtype"] = "image"
    told["video_path"] = None
    (folder / "meta/info.json").write_text(json.dumps(told))
    return folder


def write_lines(path: Path, rows: list[dict[str, Any]]) -> None:
    path.write_text("".join(f"{json.dumps(row)}\n" for row in rows))


def curves_of(file: Path) -> tuple[CurveFile, npt.NDArray[np.float32]]:
    """The header of a file of curves, and its values, shape (samples, curves)."""
    header = read_header(file)
    content = file.read_bytes()
    size = 4 * header.samples * len(header.curves)  # the values come last
    values = np.frombuffer(content[len(content) - size :], "<f4")
    return header, values.reshape(header.samples, len(header.curves))
